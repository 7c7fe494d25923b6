"""The body as spheres fixed to its bones (§4.2), and their places over a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.core.body.height import body_height, tree_of
from mgjax.core.body.roles import find_role, require_roles
from mgjax.core.skeleton import Skeleton

PRESET_HEIGHT_M = 1.7

# From joint, to joint, place between them, radius in m for a body of 1.7 m. "@" stands for a side.
_PRESET: tuple[tuple[str, str, float, float], ...] = (
    ("root", "chest", 0.0, 0.130),
    ("root", "chest", 0.5, 0.135),
    ("chest", "neck", 0.0, 0.140),
    ("chest", "neck", 0.8, 0.120),
    ("neck", "head", 0.6, 0.070),
    ("head", "head_end", 0.5, 0.115),
    ("@_shoulder", "@_elbow", 0.0, 0.070),
    ("@_shoulder", "@_elbow", 0.5, 0.055),
    ("@_elbow", "@_wrist", 0.0, 0.050),
    ("@_elbow", "@_wrist", 0.6, 0.045),
    ("@_wrist", "@_hand", 0.6, 0.060),
    ("@_hip", "@_knee", 0.2, 0.100),
    ("@_hip", "@_knee", 0.65, 0.080),
    ("@_knee", "@_ankle", 0.0, 0.065),
    ("@_knee", "@_ankle", 0.4, 0.060),
    ("@_knee", "@_ankle", 0.85, 0.050),
    ("@_ankle", "@_toe", 0.2, 0.050),
    ("@_ankle", "@_toe", 1.0, 0.045),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class BodySpheres:
    """Spheres between pairs of joints: centre = (1 − share) · first joint + share · second.

    Attributes:
        names: one for each sphere, such as ``"left_knee-left_ankle 0.40"``.
        first, second: joint indices. [S]
        share: place between them, 0 … 1; above 1 beyond the second. [S]
        radii: m. [S]
    """

    names: tuple[str, ...]
    first: Int[np.ndarray, " S"]
    second: Int[np.ndarray, " S"]
    share: Float[np.ndarray, " S"]
    radii: Float[np.ndarray, " S"]


def preset_spheres(skeleton: Skeleton) -> BodySpheres:
    """30 spheres for head, neck, torso, arms, hands, legs and feet, scaled to the skeleton.

    Works on every human body, whatever its joints are called and its rest pose looks like;
    :class:`SkeletonError` names what is missing. An arm of which there is no joint has no spheres.
    Hands, toes and the top of the head fall back to
    the end of their bone, and to the joint itself where there is none; a neck to the head, a head
    to the chest.
    """
    height = body_height(skeleton)
    if height is None:
        require_roles(skeleton, ("left_hip",))
    scale = (height or PRESET_HEIGHT_M) / PRESET_HEIGHT_M
    tree = tree_of(skeleton)
    along = [tree.distance(0, joint) for joint in range(skeleton.num_joints)]
    rows: list[tuple[str, int, int, float, float]] = []
    missing = _missing_arms(skeleton)
    for a, b, share, radius in _PRESET:
        for side in ("left", "right") if "@" in a else ("",):
            if side in missing and a in _ARM:
                continue
            ends = [x.replace("@", side) for x in (a, b)]
            first, second = (_joint(skeleton, end) for end in ends)
            name = f"{ends[0]}-{ends[1]} {share:.2f}"
            short = b in _BEYOND and along[second] - along[first] < _SHORT_M * scale
            if short and skeleton.parents[first] > 0:
                # The bone has no end in the skeleton: it goes on as the one before it.
                second, first = first, skeleton.parents[first]
                bone = max(float(along[second] - along[first]), 1e-3)
                beyond = share * _BEYOND[b] * scale / bone
                share_there = 1 + min(beyond, _FARTHEST)
            else:
                share_there = share
            rows.append((name, first, second, share_there, radius * scale))
    return BodySpheres(
        names=tuple(row[0] for row in rows),
        first=np.array([row[1] for row in rows]),
        second=np.array([row[2] for row in rows]),
        share=np.array([row[3] for row in rows], dtype=np.float32),
        radii=np.array([row[4] for row in rows], dtype=np.float32),
    )


_BEYOND = {"head_end": 0.18, "@_hand": 0.09}
"""Lengths of head and hand of a body of 1.7 m, for skeletons that end at the joint."""

_SHORT_M = 0.03
"""An end that is nearer to its joint, for a body of 1.7 m, is no end of a head or hand."""

_FARTHEST = 3.0
"""At most so many times the length of a bone lies a sphere beyond it."""

_ARM = ("@_shoulder", "@_elbow", "@_wrist")


def _missing_arms(skeleton: Skeleton) -> tuple[str, ...]:
    """The sides on which no joint of an arm is."""
    return tuple(
        side
        for side in ("left", "right")
        if all(find_role(skeleton, joint.replace("@", side)) is None for joint in _ARM)
    )


_FALLBACKS = {"head_end": "head", "hand": "wrist", "toe": "ankle"}
_NEXT = {"neck": "head", "head": "chest"}


def _joint(skeleton: Skeleton, role: str) -> int:
    side, _, part = role.rpartition("_") if role != "head_end" else ("", "", role)
    if part in _FALLBACKS:
        own = None if part == "head_end" else find_role(skeleton, role)
        if own is not None:
            return own
        base = _FALLBACKS[part] if not side else f"{side}_{_FALLBACKS[part]}"
        joint = _joint(skeleton, base)
        return next((j for j in skeleton.end_joints if skeleton.parents[j] == joint), joint)
    while find_role(skeleton, role) is None and role in _NEXT:
        role = _NEXT[role]
    return require_roles(skeleton, (role,))[0]


def sphere_centres(
    spheres: BodySpheres, positions: Float[Array, "*b J 3"]
) -> Float[Array, "*b S 3"]:
    """Centres of the spheres for joint positions, m."""
    share = spheres.share[:, None]
    return (
        positions[..., spheres.first, :] * (1 - share) + positions[..., spheres.second, :] * share
    )
