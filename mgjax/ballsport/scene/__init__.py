"""Scenes of several players (§5)."""
