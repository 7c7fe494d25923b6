"""Anatomical axes of joints: what a rotation of zero means, whatever axes a skeleton was made with.

For pelvis and chest they are those of the standing rest pose, for spine, neck and clavicles along
the bone and without twist on average, for limbs along the bone and about the axis of knee or elbow,
for feet those of the floor on which they stand.
"""

from __future__ import annotations

import numpy as np

from mgjax.clips.retarget.shown import LIMBS, Shown, heading, tip
from mgjax.core import quaternion
from mgjax.core.body.roles import SIDES
from mgjax.core.body.tree import Tree
from mgjax.core.skeleton import Skeleton, rest_positions

_UP, _DOWN = np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])
_LEFT = np.array([1.0, 0.0, 0.0])
ANATOMY = {
    "left_hip": (_DOWN, _LEFT),
    "right_hip": (_DOWN, _LEFT),
    "left_shoulder": (_LEFT, _DOWN),
    "right_shoulder": (-_LEFT, _UP),
}
"""Of each limb in a T-pose, by its first joint: direction, and the axis about which it bends."""
_ELSEWHERE = np.radians(35.0)
"""Hands, toes and heads that are turned by more on average do not rest in the rest pose."""


def trunk(tree: Tree, roles: dict[str, int], pelvis: int) -> dict[str, list[int]]:
    """Joints from the pelvis to the ``chest``, and from there to ``head`` and both shoulders."""
    if "chest" not in roles:
        return {}
    chest = roles["chest"]
    ends = [role for role in ("head", *(f"{s}_shoulder" for s in SIDES)) if role in roles]
    paths = {role: tree.path(chest, roles[role]) for role in ends}
    return {"chest": tree.path(pelvis, chest)} | paths


def loose_joints(tree: Tree, roles: dict[str, int], pelvis: int) -> dict[int, int]:
    """Joints whose axes the rest pose does not say for sure, and those that they are seen from."""
    loose = {joint: path[0] for path in trunk(tree, roles, pelvis).values() for joint in path[1:-1]}
    pairs = [("head", "chest")]
    for side in SIDES:
        chain = [f"{side}_{part}" for part in ("elbow", "wrist", "hand", "ankle", "toe")]
        pairs += [(chain[1], chain[0]), (chain[2], chain[1]), (chain[4], chain[3])]
    return loose | {roles[a]: roles[b] for a, b in pairs if a in roles and b in roles}


def anatomical_axes(
    skeleton: Skeleton, tree: Tree, roles: dict[str, int], pelvis: int, shown: Shown
) -> dict[int, np.ndarray]:
    """By joint, the rotation from anatomical axes to the joint's own, wxyz."""
    rest = rest_positions(skeleton)
    faces = _facing(rest, roles)
    axes = {pelvis: faces} | {roles[role]: faces for role in ("chest", "head") if role in roles}
    for limb in LIMBS.values():
        if roles.keys() >= set(limb):
            axes |= _limb_axes(rest, roles, limb, faces, shown)
    for side in SIDES:
        for role in (f"{side}_ankle", f"{side}_toe"):
            end, flat = tip(skeleton, roles, role), shown.flat.get(role)
            if role.endswith("ankle") or end is not None:
                bone = rest[end] - rest[roles[role]] if end is not None else None
                still = faces if bone is None else heading(bone)
                axes[roles[role]] = still if flat is None else _inverse(flat)
    for role, path in trunk(tree, roles, pelvis).items():
        for joint in path[1:-1]:
            mean = shown.against.get(joint)
            if role.endswith("shoulder"):
                own, along = faces, rest[path[-1]] - rest[joint]
            else:
                along = rest[path[-1]] - rest[path[0 if role == "chest" else 1]]
                own = _swung(faces, _UP, along)
            axes[joint] = own if mean is None else _untwisted(own, along, axes[path[0]], mean)
    for joint, other in loose_joints(tree, roles, pelvis).items():
        if joint not in axes or joint == roles.get("head"):
            own, mean = axes.get(joint, axes[other]), shown.against.get(joint)
            axes[joint] = own if mean is None else _rested(own, axes[other], mean)
    return axes


def _facing(rest: np.ndarray, roles: dict[str, int]) -> np.ndarray:
    """Turn about +Y from facing +Z to where the rest pose faces."""
    across = rest[roles["left_hip"]] - rest[roles["right_hip"]]
    return np.asarray(quaternion.from_yaw(np.arctan2(-across[2], across[0])))


def _swung(faces: np.ndarray, canonical: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Axes in which a direction of the rest pose is the canonical one."""
    ahead = np.asarray(quaternion.rotate(_inverse(faces), direction))
    swing = np.asarray(quaternion.from_two_vectors(canonical, ahead))
    return np.asarray(quaternion.multiply(faces, swing))


def _limb_axes(
    rest: np.ndarray, roles: dict[str, int], limb: tuple[str, ...], faces: np.ndarray, shown: Shown
) -> dict[int, np.ndarray]:
    """Axes of both bones of a limb."""
    direction, axis = ANATOMY[limb[0]]
    axes: dict[int, np.ndarray] = {}
    upper = shown.hinges.get(limb[0])
    for role, end in zip(limb, limb[1:], strict=False):
        bone = rest[roles[end]] - rest[roles[role]]
        # In the rest pose both bones have one axis, where the lower one does not show its own.
        hinge = shown.hinges.get(role, upper)
        if hinge is None:
            axes[roles[role]] = _swung(faces, direction, bone)
        else:
            axes[roles[role]] = _hinged(bone, hinge, direction, axis)
    return axes


def _hinged(
    bone: np.ndarray, hinge: np.ndarray, direction: np.ndarray, axis: np.ndarray
) -> np.ndarray:
    """Rotation that brings a direction to a bone and an axis as near as possible to its hinge."""

    def columns(along: np.ndarray, about: np.ndarray) -> np.ndarray:
        along = along / np.linalg.norm(along)
        about = about - (about @ along) * along
        about = about / np.linalg.norm(about)
        return np.stack([along, about, np.cross(along, about)], axis=1)

    return np.asarray(quaternion.from_matrix(columns(bone, hinge) @ columns(direction, axis).T))


def _untwisted(
    own: np.ndarray, along: np.ndarray, other: np.ndarray, mean: np.ndarray
) -> np.ndarray:
    """Axes turned about the bone so that it is not twisted on average, seen from another joint."""
    seen = quaternion.multiply(quaternion.multiply(_inverse(other), mean), own)
    bone = np.asarray(quaternion.rotate(_inverse(own), along))
    bone = bone / max(float(np.linalg.norm(bone)), 1e-9)
    twist = np.concatenate([seen[:1], (seen[1:] @ bone) * bone])
    if np.linalg.norm(twist) < 1e-6:
        return own
    twist = twist / np.linalg.norm(twist)
    return np.asarray(quaternion.multiply(own, _inverse(twist)))


def _rested(own: np.ndarray, other: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Axes of the rest pose, or of the mean of the motion where that is far from it."""
    seen = np.asarray(quaternion.multiply(quaternion.multiply(_inverse(other), mean), own))
    if quaternion.angle_between(seen, np.array([1.0, 0.0, 0.0, 0.0])) < _ELSEWHERE:
        return own
    return np.asarray(quaternion.multiply(_inverse(mean), other))


def _inverse(q: np.ndarray) -> np.ndarray:
    return np.asarray(quaternion.conjugate(q))
