"""Inverse kinematics: FABRIK for chains and trees, joint limits, and limbs of a body (§III)."""
