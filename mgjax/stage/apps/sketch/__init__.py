"""Sketch: a path drawn on the floor is walked, and hands and head reach on the way (paper C)."""
