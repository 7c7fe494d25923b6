"""How far windows of motion are apart, and which pairs of them are local minima of that."""
