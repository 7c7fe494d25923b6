"""What the numbers of a file mean: unit, up axis, floor, front and root, from the motion itself."""
