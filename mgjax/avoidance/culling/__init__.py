"""Slices (§5.2): pictures of bodies and attacks whose overlap drops candidates."""
