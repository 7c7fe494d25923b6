"""The labelled parts of a graph: where transitions may be beside them, and how soon one comes."""
