"""Clips, their labels and the graph made of them, seen and edited in the browser."""
