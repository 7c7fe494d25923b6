"""Public peers beside mgjax: the same work, in turns, each peer in an environment of its own."""
