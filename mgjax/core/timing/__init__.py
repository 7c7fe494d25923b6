"""How things go on over time: weights that rise and fall smoothly, and time warps."""
