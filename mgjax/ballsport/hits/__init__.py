"""Hits in motion (§3): found offline and live, with their key poses and motion vectors."""
