"""The body that reaches: its capsules, the limits of its limbs, and the rig that solves a pose."""
