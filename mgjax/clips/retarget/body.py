"""A body to be retargeted: what each joint's frame means, and how long its legs are.

Joints of two skeletons turn alike once both are seen in anatomical axes. For trunk and clavicles
these are those of the standing rest pose; for a limb, along the bone and about the axis of knee or
elbow; for a foot, those of the floor that it stands on.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mgjax.clips.retarget.shown import LIMBS, Shown, heading, look_at, tip
from mgjax.core import quaternion
from mgjax.core.body.height import tree_of
from mgjax.core.body.roles import find_roles, require_roles
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton, rest_positions

NEEDED = tuple(f"{s}_{part}" for s in ("left", "right") for part in ("hip", "knee", "ankle"))
_UP, _DOWN = np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])
_LEFT = np.array([1.0, 0.0, 0.0])
_ANATOMY = {
    "left_hip": (_DOWN, _LEFT),
    "right_hip": (_DOWN, _LEFT),
    "left_shoulder": (_LEFT, _DOWN),
    "right_shoulder": (-_LEFT, _UP),
}
"""Of each limb in a T-pose, by its first joint: direction, and the axis about which it bends."""
_ELSEWHERE = np.radians(45.0)
"""A hand that is bent or turned by more on average does not rest in the rest pose."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """A skeleton with a standing rest pose, and what its joints mean.

    Attributes:
        skeleton: its bones.
        roles: which joint is which.
        pelvis: the joint on which legs and trunk hang.
        frames: by role, the rotation from anatomical axes to those of the joint, wxyz.
        thigh_and_shin: from hip to ankle along the bones, mean of both legs, m.
        heights: of ``toe`` and ``ankle`` over the floor when they stand, m, where it was seen.
    """

    skeleton: Skeleton
    roles: dict[str, int]
    pelvis: int
    frames: dict[str, np.ndarray]
    thigh_and_shin: float
    heights: dict[str, float]

    def leg_length(self, point: str) -> float:
        """From the hips straight down to the ankles or the balls of the feet, m."""
        drops = [0.0]
        if point == "toe":
            rest = rest_positions(self.skeleton)
            drops = []
            for side in ("left", "right"):
                ankle, toe = self.roles[f"{side}_ankle"], self.roles[f"{side}_toe"]
                flat = quaternion.conjugate(self.frames[f"{side}_ankle"])
                drops.append(-float(quaternion.rotate(flat, rest[toe] - rest[ankle])[1]))
        return self.thigh_and_shin + float(np.mean(drops))


def make_body(skeleton: Skeleton, motions: Iterable[Motion] = ()) -> Body:
    """A body from its skeleton, with a rest pose that stands, and motions of it.

    Raises:
        SkeletonError: it has no legs; the joint that is missing is named.
    """
    require_roles(skeleton, NEEDED)
    roles = find_roles(skeleton)
    shown = look_at(skeleton, roles, motions)
    rest, tree = rest_positions(skeleton), tree_of(skeleton)
    faces = _facing(rest, roles)
    carried = [roles["left_hip"], roles["right_hip"]]
    pelvis = tree.common([*carried, roles["chest"]] if "chest" in roles else carried)
    frames = {role: faces for role in ("root", "chest", "head") if role in roles}
    frames["clavicle"] = faces
    if "chest" in roles:
        frames["spine"] = _upright(faces, rest[roles["chest"]] - rest[pelvis])
        if "head" in roles:
            neck = rest[roles["head"]] - rest[roles.get("neck", roles["chest"])]
            frames["neck"] = _upright(faces, neck)
    for limb in LIMBS.values():
        if roles.keys() >= set(limb):
            frames |= _limb_frames(rest, roles, limb, faces, shown)
    for side in ("left", "right"):
        for role in (f"{side}_ankle", f"{side}_toe"):
            if (end := tip(skeleton, roles, role)) is not None:
                flat = shown.flat.get(role)
                bone = rest[end] - rest[roles[role]]
                frames[role] = heading(bone) if flat is None else _inverse(flat)
            elif role in roles:
                frames[role] = faces
        _add_hand(frames, roles, side, shown)
    legs = [tree.distance(roles[f"{s}_hip"], roles[f"{s}_ankle"]) for s in ("left", "right")]
    return Body(
        skeleton=skeleton,
        roles=roles,
        pelvis=pelvis,
        frames=frames,
        thigh_and_shin=float(np.mean(legs)),
        heights=shown.heights,
    )


def bending_axis(body: Body, role: str) -> np.ndarray:
    """The axis about which the limb that begins at a role bends, in the frame of that joint."""
    return np.asarray(quaternion.rotate(body.frames[role], _ANATOMY[role][1]))


def _facing(rest: np.ndarray, roles: dict[str, int]) -> np.ndarray:
    """Turn about +Y from facing +Z to where the rest pose faces."""
    across = rest[roles["left_hip"]] - rest[roles["right_hip"]]
    return np.asarray(quaternion.from_yaw(np.arctan2(-across[2], across[0])))


def _upright(faces: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Axes of a part of the trunk: up is along it."""
    return _swung(faces, _UP, direction)


def _swung(faces: np.ndarray, canonical: np.ndarray, direction: np.ndarray) -> np.ndarray:
    ahead = np.asarray(quaternion.rotate(_inverse(faces), direction))
    return np.asarray(
        quaternion.multiply(faces, np.asarray(quaternion.from_two_vectors(canonical, ahead)))
    )


def _limb_frames(
    rest: np.ndarray, roles: dict[str, int], limb: tuple[str, ...], faces: np.ndarray, shown: Shown
) -> dict[str, np.ndarray]:
    """Frames of both bones of a limb."""
    direction, axis = _ANATOMY[limb[0]]
    frames: dict[str, np.ndarray] = {}
    upper = shown.hinges.get(limb[0])
    for role, end in zip(limb, limb[1:], strict=False):
        bone = rest[roles[end]] - rest[roles[role]]
        # Bones that the rest pose does not turn have the axis of the upper one.
        hinge = shown.hinges.get(role, upper)
        if hinge is None:
            frames[role] = _swung(faces, direction, bone)
        else:
            frames[role] = _frame(bone, hinge, direction, axis)
    return frames


def _add_hand(
    frames: dict[str, np.ndarray], roles: dict[str, int], side: str, shown: Shown
) -> None:
    """A hand has the axes of the forearm in the rest pose, or else on average."""
    for part, above in (("wrist", "elbow"), ("hand", "wrist")):
        role, known = f"{side}_{part}", frames.get(f"{side}_{above}")
        if role not in roles or known is None:
            continue
        mean = shown.hands.get(role)
        still = np.array([1.0, 0.0, 0.0, 0.0])
        if mean is None or quaternion.angle_between(mean, still) < _ELSEWHERE:
            mean = still
        frames[role] = np.asarray(quaternion.multiply(_inverse(mean), known))


def _frame(
    bone: np.ndarray, hinge: np.ndarray, direction: np.ndarray, axis: np.ndarray
) -> np.ndarray:
    """Rotation that brings a direction to a bone and an axis as near as possible to its hinge."""

    def columns(along: np.ndarray, about: np.ndarray) -> np.ndarray:
        along = along / np.linalg.norm(along)
        about = about - (about @ along) * along
        about = about / np.linalg.norm(about)
        return np.stack([along, about, np.cross(along, about)], axis=1)

    return np.asarray(quaternion.from_matrix(columns(bone, hinge) @ columns(direction, axis).T))


def _inverse(q: np.ndarray) -> np.ndarray:
    return np.asarray(quaternion.conjugate(q))
