"""The joints of the SMPL body (Loper et al., SMPL, 2015), and about where they are in an adult."""

from __future__ import annotations

import numpy as np

# Joint, parent, offset in m of a rough adult 1.7 m tall, in the model's rest pose: arms out, y up,
# x to the left, z ahead. The first row is where the pelvis lies in the model's coordinates.
# These are rounded proportions, not those of any fitted body.
_TABLE = (
    ("pelvis", -1, (0.0, -0.23, 0.02)),
    ("left_hip", 0, (0.065, -0.09, -0.01)),
    ("right_hip", 0, (-0.065, -0.09, -0.01)),
    ("spine1", 0, (0.0, 0.11, -0.025)),
    ("left_knee", 1, (0.04, -0.385, 0.005)),
    ("right_knee", 2, (-0.04, -0.385, 0.005)),
    ("spine2", 3, (0.0, 0.135, 0.005)),
    ("left_ankle", 4, (-0.015, -0.405, -0.04)),
    ("right_ankle", 5, (0.015, -0.405, -0.04)),
    ("spine3", 6, (0.0, 0.055, 0.005)),
    ("left_foot", 7, (0.04, -0.06, 0.125)),
    ("right_foot", 8, (-0.04, -0.06, 0.125)),
    ("neck", 9, (0.0, 0.21, -0.035)),
    ("left_collar", 9, (0.08, 0.12, -0.02)),
    ("right_collar", 9, (-0.08, 0.12, -0.02)),
    ("head", 12, (0.0, 0.085, 0.05)),
    ("left_shoulder", 13, (0.105, 0.035, -0.01)),
    ("right_shoulder", 14, (-0.105, 0.035, -0.01)),
    ("left_elbow", 16, (0.26, -0.015, -0.02)),
    ("right_elbow", 17, (-0.26, -0.015, -0.02)),
    ("left_wrist", 18, (0.25, 0.01, 0.0)),
    ("right_wrist", 19, (-0.25, 0.01, 0.0)),
    ("left_hand", 20, (0.085, -0.01, -0.01)),
    ("right_hand", 21, (-0.085, -0.01, -0.01)),
)
NAMES = tuple(name for name, _, _ in _TABLE)
PARENTS = tuple(parent for _, parent, _ in _TABLE)
OFFSETS = np.array([offset for _, _, offset in _TABLE])
"""[24,3] of the rough adult, m."""

JOINTS_OF_WIDTH = {66: 22, 72: 24, 156: 22, 165: 22}
"""How many of these joints a row of ``poses`` has, by its width: 22 alone, SMPL, SMPL-H (which
goes on with 30 joints of the fingers) and SMPL-X (jaw, eyes and fingers)."""
