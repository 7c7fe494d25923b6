"""Attacks as space-time volumes of spheres (§4.2): sources, crop, and many as one batch."""
