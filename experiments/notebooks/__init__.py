"""Notebooks are executed here, and what they show is kept."""
