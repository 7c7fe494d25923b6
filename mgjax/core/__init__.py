"""Skeletons, motions and the geometry that everything else is written in."""
