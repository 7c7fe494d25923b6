"""Many attacks at once, and one attack under many settings."""
