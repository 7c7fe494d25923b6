"""Experiments on the quality of what is generated."""
