"""Motion carried from one skeleton to another whose rest pose and bone lengths differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.clips.prepare import standing_height
from mgjax.core import quaternion
from mgjax.core.body.rest import standing_rest
from mgjax.core.body.roles import find_role, require_roles
from mgjax.core.contacts import foot_joints
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

_SIDED = ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist", "hand")
_ROLES = (
    *("root", "spine", "chest", "neck", "head"),
    *(f"{side}_{part}" for side in ("left", "right") for part in _SIDED),
)
_NEEDED = ("left_hip", "left_knee", "left_ankle", "right_hip", "right_knee", "right_ankle")


def retarget(source: Skeleton, motion: Motion, target: Skeleton) -> Motion:
    """The motion on another skeleton: bones point where they pointed.

    A joint of the target takes its rotation from the joint with the same name or else the same
    role (:func:`mgjax.core.body.roles.find_role`), corrected by the smallest turn between the rest
    directions of the two bones. Joints without a counterpart keep still against their parent.
    The root's place is scaled by the ratio of the heights at which the two skeletons stand, and
    raised so that the lower foot is as high over the floor as it was, in the median.

    Raises:
        SkeletonError: a skeleton has no legs.
        MotionError: bones are not rigid.
    """
    if motion.joint_offsets is not None:
        raise MotionError("got bones of changing length, expected rigid bones")
    for skeleton in (source, target):
        require_roles(skeleton, _NEEDED)
    if (rest := standing_rest(source)) is not None:
        source, motion = rest.skeleton, rest.motion(motion)
    twins = _twins(source, target)
    places, turns = forward(
        source, np.asarray(motion.root_translation), np.asarray(motion.local_rotations)
    )
    places, turns = np.asarray(places), np.asarray(turns, np.float64)
    count = motion.num_frames
    world = np.zeros((count, target.num_joints, 4))
    local = np.zeros_like(world)
    local[..., 0] = 1.0
    for joint, parent in enumerate(target.parents):
        twin = twins[joint]
        if twin is None:
            world[:, joint] = world[:, parent]
            continue
        ours, theirs = _direction(target, joint), _direction(source, twin)
        world[:, joint] = turns[:, twin]
        if ours is not None and theirs is not None:
            swing = np.asarray(quaternion.from_two_vectors(ours, theirs))
            world[:, joint] = quaternion.multiply(turns[:, twin], swing)
        above = world[:, parent] if parent >= 0 else None
        local[:, joint] = (
            world[:, joint]
            if above is None
            else quaternion.multiply(quaternion.conjugate(above), world[:, joint])
        )
    scale = standing_height(target) / standing_height(source)
    root = np.asarray(motion.root_translation, np.float64) * scale
    moved = forward(target, root, local)[0]
    root[:, 1] += _floor(source, places) * scale - _floor(target, np.asarray(moved))
    return replace(
        motion,
        root_translation=root.astype(np.float32),
        local_rotations=local.astype(np.float32),
    )


def _floor(skeleton: Skeleton, positions: np.ndarray) -> float:
    """Median height of the lower ball of the foot, m."""
    return float(np.median(positions[:, list(foot_joints(skeleton)), 1].min(axis=1)))


def _twins(source: Skeleton, target: Skeleton) -> list[int | None]:
    """Each target joint's counterpart; the root's is the root, end joints have none."""
    by_name = {name.lower(): j for j, name in enumerate(source.names)}
    roles = {find_role(target, r): find_role(source, r) for r in _ROLES}
    twins = [by_name.get(name.lower(), roles.get(j)) for j, name in enumerate(target.names)]
    twins[0] = 0
    return [None if j in target.end_joints else twin for j, twin in enumerate(twins)]


def _direction(skeleton: Skeleton, joint: int) -> np.ndarray | None:
    """Where a joint's bone points in the rest pose; None where it has several or no bones."""
    offsets = np.asarray(skeleton.offsets, np.float64)
    children = [j for j, p in enumerate(skeleton.parents) if p == joint]
    if joint == 0 or len(children) != 1 or np.linalg.norm(offsets[children[0]]) < 1e-3:
        return None
    return offsets[children[0]]
