"""The body in a skeleton: limbs, roles of joints, sides and height, by structure and by name."""
