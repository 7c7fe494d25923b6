"""Macro edges: what the path search needs of a graph, whatever the path."""
