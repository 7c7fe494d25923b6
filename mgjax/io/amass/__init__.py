"""Motions of the SMPL body as AMASS distributes them: reading."""
