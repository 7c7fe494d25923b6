"""All experiments at full size."""
