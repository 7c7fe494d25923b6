"""A few poses of a clip as stick figures, for a list of clips."""

from __future__ import annotations

import numpy as np
from jaxtyping import Int

from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

POSES = 5
_TURN = np.radians(35.0)
"""How far the bodies are turned from looking at the viewer: limbs in front are seen so."""
_ONE = 1000


def key_poses(skeleton: Skeleton, motion: Motion, count: int = POSES) -> Int[np.ndarray, "K J 2"]:
    """Joints of poses evenly spread over a motion, each turned to look to the same side.

    Returns:
        Right and up in thousandths of the clip's tallest pose; a body stands over 0, and what is
        farther away than 30 of its heights is drawn there.
    """
    frames = np.unique(np.linspace(0, motion.num_frames - 1, count + 2).round().astype(int)[1:-1])
    offsets = None if motion.joint_offsets is None else np.asarray(motion.joint_offsets)[frames]
    places = np.asarray(
        forward(
            skeleton,
            np.asarray(motion.root_translation)[frames],
            np.asarray(motion.local_rotations)[frames],
            offsets,
        )[0],
        dtype=np.float64,
    )
    heading = np.asarray(planar_frames(skeleton, places))[:, 0] - _TURN
    x = places[..., 0] - places[:, :1, 0]
    z = places[..., 2] - places[:, :1, 2]
    # Seen from where the body looks to, its left is on the right.
    right = x * np.cos(heading)[:, None] - z * np.sin(heading)[:, None]
    up = places[..., 1]
    tall = max(float((up.max(axis=1) - up.min(axis=1)).max()), 1e-6)
    both = np.stack([right, up], axis=-1) / tall * _ONE
    return np.clip(both.round(), -30 * _ONE, 30 * _ONE).astype(np.int16)
