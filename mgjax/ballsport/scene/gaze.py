"""Players look at the ball: the neck turns the head towards it as far as a neck goes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.ndimage import gaussian_filter1d

from mgjax.core import quaternion
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

NECK = ("lowerneck", "upperneck", "head")
"""Joints of the embedded skeleton that share the turn."""
_MOST = np.radians(60.0)
"""Largest turn of the head from where the clip has it."""
_FADE = np.radians((100.0, 150.0))
"""The ball is no longer followed from the first angle on, and beyond the second not looked for."""
_SMOOTH_S = 0.12
"""Standard deviation of the smoothing of the turn, s."""
_TRUNCATE = 4.0
"""Standard deviations after which the smoothing ends."""


def gaze_frames(frame_rate: float) -> int:
    """How many frames before and after it the turn in a frame depends on."""
    return int(_TRUNCATE * _SMOOTH_S * frame_rate + 0.5)


def look_at(skeleton: Skeleton, motion: Motion, ball: Float[np.ndarray, "F 3"]) -> Motion:
    """The motion with the head turned towards a place in each frame.

    Only the joints of :data:`NECK` change, so hands and feet stay where they are.

    Args:
        skeleton: the embedded one.
        motion: in the coordinates of the ball.
        ball: place to look at, m.
    """
    local = np.asarray(motion.local_rotations, np.float64).copy()
    places, turns = forward(skeleton, np.asarray(motion.root_translation, np.float64), local)
    joints = [skeleton.index(name) for name in NECK]
    head = joints[-1]
    ahead = quaternion.rotate(turns[:, head], np.array([0.0, 0.0, 1.0]))
    direction = ball - places[:, head]
    direction = direction / np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-9)
    axis = np.cross(ahead, direction)
    size = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(size, np.sum(ahead * direction, axis=1))
    fade = np.clip((_FADE[1] - angle) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
    vector = axis / np.maximum(size, 1e-9)[:, None] * (np.minimum(angle, _MOST) * fade)[:, None]
    width = _SMOOTH_S * motion.frame_rate
    vector = gaussian_filter1d(vector, width, axis=0, mode="nearest", truncate=_TRUNCATE)
    third = quaternion.exp(vector / len(joints))
    for joint in joints:
        above = turns[:, skeleton.parents[joint]]
        turn = quaternion.multiply(quaternion.conjugate(above), quaternion.multiply(third, above))
        local[:, joint] = quaternion.multiply(turn, local[:, joint])
    return replace(motion, local_rotations=local.astype(np.float32))
