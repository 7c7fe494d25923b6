"""Experiments of the hybrid room."""
