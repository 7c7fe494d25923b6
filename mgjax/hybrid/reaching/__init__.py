"""Hands and head reach for targets on the way (§III, eq. 8)."""
