"""Show: a result as it was written."""
