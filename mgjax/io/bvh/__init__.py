"""BVH files: reading and writing."""
