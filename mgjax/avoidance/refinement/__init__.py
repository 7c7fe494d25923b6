"""Near misses that are changed until they are clear: small offsets of a motion, smooth in time."""
