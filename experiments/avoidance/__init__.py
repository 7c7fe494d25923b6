"""Experiments of the avoidance paper."""
