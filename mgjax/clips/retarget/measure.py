"""Measures of a retargeted motion: foot slide, joint limits, paths of hands, feet and head."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from mgjax.clips.retarget.body import Body
from mgjax.core import quaternion
from mgjax.core.contacts import floor_steps, stays_planted

ENDS = ("left_wrist", "right_wrist", "left_ankle", "right_ankle", "head")
FOLD_DEG = 160.0
"""Knees and elbows bend no farther."""
BACK_DEG = 10.0
"""Knees bend no farther to the front."""
HEAD_DEG = 100.0
"""The head turns no farther against the chest."""
TRUNK_DEG = 120.0
"""The chest turns no farther against the pelvis."""


def foot_slide(feet: Float[np.ndarray, "F 2 3"], on: Bool[np.ndarray, "F 2"]) -> float:
    """Metres that planted feet travel over the floor per frame, both together."""
    moved = np.asarray(floor_steps(feet))
    return float(moved[np.asarray(stays_planted(on))].sum()) / max(len(moved), 1)


def path_error(wanted: Float[np.ndarray, "F K 3"], got: Float[np.ndarray, "F K 3"]) -> float:
    """Mean distance of points from where they should be, m."""
    return float(np.linalg.norm(got - wanted, axis=-1).mean())


def outside_limits(
    body: Body, places: Float[np.ndarray, "F J 3"], turns: Float[np.ndarray, "F J 4"]
) -> Bool[np.ndarray, " F"]:
    """Frames in which a joint is beyond what bodies can do.

    A simple set for every body: knees and elbows bend to 160°, knees to the front by 10°, the head
    turns against the chest by 100°, the chest against the pelvis by 120°.
    """
    roles = body.roles
    outside = np.zeros(len(places), dtype=bool)
    for side in ("left", "right"):
        for limb in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")):
            joints = [roles[r] for p in limb if (r := f"{side}_{p}") in roles]
            if len(joints) < 3:
                continue
            upper, lower = (
                _unit(places[:, b] - places[:, a]) for a, b in zip(joints, joints[1:], strict=False)
            )
            outside |= (upper * lower).sum(-1) < np.cos(np.radians(FOLD_DEG))
            if limb[0] == "hip":
                axis = body.hinge(f"{side}_hip")[None]
                hinge = np.asarray(quaternion.rotate(turns[:, joints[0]], axis))
                bend = (np.cross(upper, lower) * hinge).sum(-1)
                outside |= bend < -np.sin(np.radians(BACK_DEG))
    trunk = [body.pelvis, *(roles[role] for role in ("chest", "head") if role in roles)]
    for low, high, largest in zip(trunk, trunk[1:], (TRUNK_DEG, HEAD_DEG), strict=False):
        pair = [np.asarray(quaternion.multiply(turns[:, j], body.axes(j))) for j in (low, high)]
        angle = np.asarray(quaternion.angle_between(pair[0], pair[1]))
        outside |= angle > np.radians(largest)
    return outside


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-9)
