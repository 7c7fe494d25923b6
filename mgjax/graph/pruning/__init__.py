"""Which minima of the distance become the transitions of a graph."""
