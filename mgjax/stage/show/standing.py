"""A rest pose for drawing: one that stands, with each joint turned as the body really holds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.core import quaternion
from mgjax.core.body.rest import NewRest, standing_rest
from mgjax.core.body.roles import find_roles
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion, cut
from mgjax.core.skeleton import Skeleton

_LOOKED_AT = 200
"""As many frames are looked at for one in which the body stands upright."""


def standing(skeleton: Skeleton, motion: Motion) -> tuple[Skeleton, Motion]:
    """The same motion of a skeleton with rigid bones whose rest pose stands, if it is a body.

    Joints that slide in their parents' frames are held in the middle of where they are. A rest pose
    that does not stand says nothing of how limbs are twisted, so the most upright pose of the
    motion becomes the rest pose first, and is straightened from there.
    """
    if motion.joint_offsets is not None:
        middle = np.median(np.asarray(motion.joint_offsets, dtype=np.float32), axis=0)
        middle[0] = np.asarray(skeleton.offsets)[0]
        skeleton = replace(skeleton, offsets=middle)
        motion = replace(motion, joint_offsets=None)
    if standing_rest(skeleton) is None:
        return skeleton, motion
    posed = _posed_rest(skeleton, motion)
    skeleton, motion = posed.skeleton, posed.motion(motion)
    rest = standing_rest(skeleton)
    return (skeleton, motion) if rest is None else (rest.skeleton, rest.motion(motion))


def _posed_rest(skeleton: Skeleton, motion: Motion) -> NewRest:
    """The most upright pose of a motion, turned to look along +Z, as the rest pose."""
    roles = find_roles(skeleton)
    step = -(-motion.num_frames // _LOOKED_AT)
    some = np.arange(0, motion.num_frames, step)
    places, _ = forward(
        skeleton,
        np.asarray(motion.root_translation, np.float64)[some],
        np.asarray(motion.local_rotations, np.float64)[some],
    )
    feet = places[:, [roles["left_ankle"], roles["right_ankle"]]]
    hands = places[:, [roles["left_wrist"], roles["right_wrist"]], 1].max(axis=1)
    chest = places[:, roles["chest"], 1]
    apart = np.linalg.norm(feet[:, 0] - feet[:, 1], axis=1)
    raised = np.maximum(hands - chest, 0.0)
    best = int(some[np.argmax(chest - feet[..., 1].max(axis=1) - 0.5 * (apart + raised))])
    one = cut(motion, best, best + 1)
    pose, turns = forward(
        skeleton,
        np.asarray(one.root_translation, np.float64),
        np.asarray(one.local_rotations, np.float64),
    )
    across = pose[0, roles["left_hip"]] - pose[0, roles["right_hip"]]
    heading = quaternion.from_yaw(np.array(np.arctan2(-across[2], across[0])))
    turned = np.asarray(quaternion.multiply(quaternion.conjugate(heading), turns[0]))
    parents = np.maximum(np.array(skeleton.parents), 0)
    offsets = np.asarray(skeleton.offsets, np.float64)
    moved = np.asarray(quaternion.rotate(turned[parents], offsets))
    moved[0] = offsets[0]
    return NewRest(skeleton=replace(skeleton, offsets=moved.astype(np.float32)), turns=turned)
