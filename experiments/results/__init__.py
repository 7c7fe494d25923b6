"""All experiments at full size, and the documents that are written of their records."""
