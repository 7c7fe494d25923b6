"""A rest pose that stands: for skeletons whose rest pose lies flat or has all bones along one axis.

Limits of joints, mirroring, retargeting and motion sensors read directions off the rest pose, as a
stance with the arms to the side. Many makers write another one. Any rest pose describes the same
motion, if offsets and rotations change together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.body.roles import SIDED, find_roles
from mgjax.core.motion import Motion
from mgjax.core.shown import made_of
from mgjax.core.skeleton import Skeleton, rest_positions

STANDS = 0.8
"""Cosine to the vertical above which legs and trunk of a rest pose count as standing."""

_NEEDED = {"chest"} | {
    f"{side}_{part}"
    for side in ("left", "right")
    for part in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
}
_UP, _DOWN = np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])
_LEFT, _AHEAD = np.array([1.0, 0.0, 0.0]), np.array([0.0, -0.4, 0.9])


@dataclass(frozen=True, kw_only=True)
class NewRest:
    """Another rest pose of a skeleton.

    Attributes:
        skeleton: with the offsets of the new rest pose.
        turns: rotation of each joint in the world, from the old rest pose to the new. [J,4]
    """

    skeleton: Skeleton
    turns: Float[np.ndarray, "J 4"]

    def motion(self, motion: Motion) -> Motion:
        """The same joint places over time, for the new rest pose: l' = T_parent · l · T⁻¹."""
        parents = np.maximum(np.array(self.skeleton.parents), 0)
        above = self.turns[parents].copy()
        above[0] = [1.0, 0.0, 0.0, 0.0]
        local = np.asarray(motion.local_rotations, dtype=np.float64)
        turned = quaternion.multiply(
            quaternion.multiply(above, local), quaternion.conjugate(self.turns)
        )
        moving = motion.joint_offsets
        if moving is not None:
            moving = np.asarray(quaternion.rotate(above, np.asarray(moving, np.float64)))
            moving = moving.astype(np.float32)
        poses = replace(
            motion,
            local_rotations=np.asarray(turned).astype(np.float32),
            joint_offsets=moving,
        )
        return made_of(poses, self.skeleton)


def standing_rest(skeleton: Skeleton) -> NewRest | None:
    """A T-pose for a body whose rest pose does not stand; None where it does, or for no body.

    The spine goes up, the legs down, the feet ahead (+Z), the arms to the sides (left is +X). What
    hangs on these (fingers, helpers) turns with the joint that it hangs on.
    """
    roles = find_roles(skeleton)
    if not roles.keys() >= _NEEDED or _stands(skeleton, roles):
        return None
    goals = _goals(skeleton, roles)
    offsets = np.asarray(skeleton.offsets, dtype=np.float64)
    turns = np.zeros((skeleton.num_joints, 4))
    below: list[list[int]] = [[] for _ in skeleton.names]
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0 and joint in goals and np.linalg.norm(offsets[joint]) > 0:
            below[parent].append(joint)
    for joint, parent in enumerate(skeleton.parents):
        turns[joint] = turns[parent] if parent >= 0 else [1.0, 0.0, 0.0, 0.0]
        if len(below[joint]) == 1:
            (child,) = below[joint]
            swing = quaternion.from_two_vectors(
                np.asarray(quaternion.rotate(turns[joint], offsets[child])), goals[child]
            )
            turns[joint] = np.asarray(quaternion.multiply(np.asarray(swing), turns[joint]))
        elif below[joint]:
            turns[joint] = _fit(offsets[below[joint]], np.stack([goals[c] for c in below[joint]]))
    parents = np.maximum(np.array(skeleton.parents), 0)
    moved = np.asarray(quaternion.rotate(turns[parents], offsets))
    moved[0] = offsets[0]
    standing = replace(skeleton, offsets=moved.astype(np.float32))
    return NewRest(skeleton=standing, turns=turns)


def _stands(skeleton: Skeleton, roles: dict[str, int]) -> bool:
    places = rest_positions(skeleton)

    def cosine(low: str, high: str) -> float:
        up = places[roles[high]] - places[roles[low]]
        return float(up[1] / max(float(np.linalg.norm(up)), 1e-9))

    legs = min(cosine(f"{side}_ankle", f"{side}_hip") for side in ("left", "right"))
    ahead = places[roles.get("left_toe", roles["left_ankle"])] - places[roles["left_ankle"]]
    across = places[roles["left_hip"]] - places[roles["right_hip"]]
    faces = float(np.cross(across, _UP) @ ahead) >= 0 if "left_toe" in roles else True
    trunk = cosine("left_hip", "head") if "head" in roles else legs
    return legs > STANDS and trunk > STANDS and faces and bool(np.abs(across).argmax() == 0)


def _goals(skeleton: Skeleton, roles: dict[str, int]) -> dict[int, np.ndarray]:
    """Where the bone from its parent to a joint points in a T-pose, for the joints that matter."""
    goals: dict[int, np.ndarray] = {}

    def along(first: int, last: int, direction: np.ndarray) -> None:
        """Bones from ``first`` down to ``last``, but those that have a goal."""
        joint = last
        while joint not in (first, 0):
            goals.setdefault(joint, direction)
            joint = skeleton.parents[joint]

    for side, out in (("left", _LEFT), ("right", -_LEFT)):
        joints = {part: roles[f"{side}_{part}"] for part in SIDED if f"{side}_{part}" in roles}
        along(joints["ankle"], joints.get("toe", joints["ankle"]), _AHEAD)
        along(joints["hip"], joints["ankle"], _DOWN)
        along(0, joints["hip"], out)
        along(joints["shoulder"], joints.get("hand", joints["wrist"]), out)
        along(roles["chest"], joints["shoulder"], out + 0.3 * _UP)
    along(0, roles.get("head", roles.get("chest", 0)), _UP)
    return goals


def _fit(bones: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Quaternion that turns bones as near as possible to their goals (Kabsch)."""
    bones = bones / np.linalg.norm(bones, axis=1, keepdims=True)
    goals = goals / np.linalg.norm(goals, axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(goals.T @ bones)
    sign = np.sign(np.linalg.det(u @ vt))
    return np.asarray(quaternion.from_matrix(u @ np.diag([1.0, 1.0, sign]) @ vt))
