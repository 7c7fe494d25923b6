"""A pelvis that goes down while the feet stay where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion, two_bone
from mgjax.core.body.roles import require_roles
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

_MOVED_M = 1e-4
"""A pelvis that is less far down stays as it is."""


def lower_pelvis(skeleton: Skeleton, motion: Motion, drop: Float[np.ndarray, " F"]) -> Motion:
    """The motion with the pelvis ``drop`` m lower in each frame.

    Ankles keep their places and feet their orientation in the world; hips and knees give way by
    two-bone inverse kinematics, knees to where they point already.
    """
    rows = np.flatnonzero(np.abs(drop) > _MOVED_M)
    if not rows.size:
        return motion
    root = np.asarray(motion.root_translation, np.float64).copy()
    local = np.asarray(motion.local_rotations, np.float64).copy()
    old, turns = forward(skeleton, root[rows], local[rows])
    down = drop[rows, None] * np.array([[0.0, -1.0, 0.0]])
    root[rows] += down
    for side in ("left", "right"):
        hip, knee, ankle = require_roles(
            skeleton, tuple(f"{side}_{p}" for p in ("hip", "knee", "ankle"))
        )
        places = (old[:, hip] + down, old[:, knee] + down, old[:, ankle] + down)
        ahead = quaternion.rotate(turns[:, 0], np.broadcast_to([0.0, 0.0, 1.0], places[0].shape))
        hip_turn, knee_turn = two_bone.solve(*places, old[:, ankle], ahead)
        above = turns[:, skeleton.parents[hip]]
        leg = (turns[:, hip], turns[:, knee], turns[:, ankle])
        new = two_bone.local_rotations(hip_turn, knee_turn, above, *leg)
        local[rows, hip], local[rows, knee], local[rows, ankle] = (np.asarray(q) for q in new)
    return replace(
        motion,
        root_translation=root.astype(np.float32),
        local_rotations=np.asarray(quaternion.normalise(local), np.float32),
    )
