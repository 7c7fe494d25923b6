"""A pose in which no limb touches another: a body's surface is made in it and brought back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.body.rest import standing_rest
from mgjax.core.body.roles import SIDES, find_roles
from mgjax.core.skeleton import Skeleton, rest_positions

_ARM_DEG, _LEG_DEG = 40.0, 9.0
"""Arms hang this far below the horizontal, legs stand at least so far apart from the vertical."""


@dataclass(frozen=True, kw_only=True)
class SpreadPose:
    """A skeleton whose rest pose is the spread one.

    Attributes:
        skeleton: with its offsets.
        turns: rotation of each joint in the world, from its own rest pose to this. [J,4]
        person: it stands, and has arms and legs that were found.
    """

    skeleton: Skeleton
    turns: Float[np.ndarray, "J 4"]
    person: bool


def spread_pose(skeleton: Skeleton) -> SpreadPose:
    """Arms a little below the horizontal and legs apart; what is no person stays as it is."""
    standing = standing_rest(skeleton)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (skeleton.num_joints, 1))
    stood = skeleton
    if standing is not None:
        turns, stood = np.asarray(standing.turns, np.float64), standing.skeleton
    roles = find_roles(skeleton)
    needed = [f"{s}_{p}" for s in SIDES for p in ("hip", "ankle", "knee", "shoulder", "elbow")]
    if not all(role in roles for role in (*needed, "chest")) or not _upright(stood, roles):
        return SpreadPose(skeleton=stood, turns=turns, person=False)
    offsets = np.asarray(stood.offsets, np.float64)
    more = np.tile([1.0, 0.0, 0.0, 0.0], (skeleton.num_joints, 1))
    swings = _swings(stood, roles)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            more[joint] = more[parent]
        if joint in swings:
            more[joint] = swings[joint]
    parents = np.maximum(np.array(skeleton.parents), 0)
    moved = np.asarray(quaternion.rotate(more[parents], offsets))
    moved[0] = offsets[0]
    return SpreadPose(
        skeleton=replace(stood, offsets=moved.astype(np.float32)),
        turns=np.asarray(quaternion.multiply(more, turns)),
        person=True,
    )


def _upright(skeleton: Skeleton, roles: dict[str, int]) -> bool:
    places = rest_positions(skeleton)
    hips = (places[roles["left_hip"]] + places[roles["right_hip"]]) / 2
    ankles = (places[roles["left_ankle"]] + places[roles["right_ankle"]]) / 2
    leg = hips - ankles
    return bool(leg[1] > 0.8 * np.linalg.norm(leg) and leg[1] > 1e-3)


def _swings(skeleton: Skeleton, roles: dict[str, int]) -> dict[int, np.ndarray]:
    """How shoulders and hips turn in the world."""
    places = rest_positions(skeleton)
    swings: dict[int, np.ndarray] = {}
    for side in SIDES:
        out = places[roles["left_hip"]] - places[roles["right_hip"]]
        out[1] = 0.0
        out = (1 if side == "left" else -1) * out / max(float(np.linalg.norm(out)), 1e-9)
        up = np.array([0.0, 1.0, 0.0])
        shoulder, elbow = roles[f"{side}_shoulder"], roles[f"{side}_elbow"]
        angle = np.radians(_ARM_DEG)
        goal = np.cos(angle) * out - np.sin(angle) * up
        swings[shoulder] = _swing(places[elbow] - places[shoulder], goal)
        hip, knee = roles[f"{side}_hip"], roles[f"{side}_knee"]
        thigh = places[knee] - places[hip]
        least = np.radians(_LEG_DEG)
        if thigh @ out < np.sin(least) * np.linalg.norm(thigh):
            goal = thigh - (thigh @ out) * out
            goal = np.cos(least) * goal / np.linalg.norm(goal) + np.sin(least) * out
            swings[hip] = _swing(thigh, goal)
    return swings


def _swing(bone: np.ndarray, goal: np.ndarray) -> np.ndarray:
    return np.asarray(quaternion.from_two_vectors(bone, goal), np.float64)
