"""Which joint of a body is which: by structure first, by name where structure leaves it open.

Roles: root, spine, chest, neck, head and, with ``left_`` or ``right_`` before them, hip, knee,
ankle, toe, shoulder, elbow, wrist, hand. A role names the joint at that place: ``left_knee`` is
ASF's ``ltibia``, the joint where the shin begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from jax.core import Tracer

from mgjax.core.body.limbs import (
    ARM,
    LEG,
    MOST_JOINTS,
    Limb,
    Limbs,
    find_limbs,
    four_legged,
)
from mgjax.core.body.names import LIKELY
from mgjax.core.body.tree import Tree
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton

SIDES = ("left", "right")
CENTRAL = ("root", "spine", "chest", "neck", "head")
SIDED = ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist", "hand")
ROLES = (*CENTRAL, *(f"{side}_{part}" for side in SIDES for part in SIDED))


def find_role(skeleton: Skeleton, role: str) -> int | None:
    """Index of the joint with a role such as ``"left_knee"``, ``"chest"`` or ``"root"``, or None.

    Raises:
        KeyError: no such role.
    """
    if role not in ROLES:
        raise KeyError(role)
    return 0 if role == "root" else find_roles(skeleton).get(role)


def find_roles(skeleton: Skeleton) -> dict[str, int]:
    """All roles that a skeleton has joints for: those it was given, else those found in its tree.

    A skeleton on four legs has the role ``root`` only; of a part of a body, names decide.
    """
    if skeleton.roles:
        return dict(skeleton.roles)
    offsets = skeleton.offsets
    if isinstance(offsets, Tracer):  # lengths are not known: names and branches decide
        offsets = np.ones((skeleton.num_joints, 3))
    lengths = np.asarray(offsets, dtype=np.float64).tobytes()
    return dict(_found(skeleton.names, skeleton.parents, skeleton.end_joints, lengths))


def require_roles(skeleton: Skeleton, roles: Sequence[str]) -> tuple[int, ...]:
    """Joint indices of all ``roles``; :class:`SkeletonError` names the first that is missing."""
    joints: list[int] = []
    for role in roles:
        joint = find_role(skeleton, role)
        if joint is None:
            raise SkeletonError(f"found no joint for {role!r} among {', '.join(skeleton.names)}")
        joints.append(joint)
    return tuple(joints)


@lru_cache(maxsize=64)
def _found(
    names: tuple[str, ...], parents: tuple[int, ...], end_joints: tuple[int, ...], offsets: bytes
) -> tuple[tuple[str, int], ...]:
    tree = Tree(names, parents, end_joints, np.frombuffer(offsets).reshape(-1, 3))
    return tuple(roles_in(tree, find_limbs(tree)).items())


def roles_in(tree: Tree, limbs: Limbs | None) -> dict[str, int]:
    """Roles of a tree: by its limbs, or by its names alone where it is part of a body."""
    if limbs is not None:
        return roles_of(tree, limbs)
    roles: dict[str, int | None] = {"root": 0}
    if len(tree.names) <= MOST_JOINTS and not four_legged(tree):
        roles |= {f"{side}_{part}": _named(tree, side, part) for side in SIDES for part in SIDED}
        roles |= {part: _named(tree, "", part) for part in ("neck", "head")}
    return {role: joint for role, joint in roles.items() if joint is not None}


def roles_of(tree: Tree, limbs: Limbs) -> dict[str, int]:
    """Roles of a body with these limbs, the first of each pair being the left one."""
    roles: dict[str, int | None] = {"root": 0}
    for side, leg in zip(SIDES, limbs.legs, strict=True):
        roles |= {f"{side}_{part}": j for part, j in zip(LEG, leg.joints, strict=True)}
        roles[f"{side}_toe"] = _toe(tree, leg)
    for side, arm in zip(SIDES, limbs.arms, strict=False):
        roles |= {f"{side}_{part}": j for part, j in zip(ARM, arm.joints, strict=True)}
        roles[f"{side}_hand"] = _hand(tree, arm)
    if not limbs.arms:
        roles |= {f"{side}_{part}": _named(tree, side, part) for side in SIDES for part in ARM}
    found = {role: joint for role, joint in roles.items() if joint is not None}
    return found | _centre(tree, limbs, found)


def _named(tree: Tree, side: str, part: str) -> int | None:
    """The first joint of a side whose name says the part, rather outright than likely."""
    found = [(-h.weight(part), j) for j, h in enumerate(tree.hints) if h.side == side]
    weight, joint = min(found, default=(0.0, 0))
    return joint if -weight >= LIKELY else None


def hips_of(tree: Tree, limbs: Limbs) -> int:
    """The joint that carries the body: where legs and arms meet, or the pelvis just above."""
    tops = [limb.top for limb in (*limbs.legs, *limbs.arms)]
    meet = tree.common([tree.parents[top] for top in tops])
    thigh = tree.distance(limbs.legs[0].joints[0], limbs.legs[0].joints[1])
    for joint in tree.ancestors(meet):
        if tree.hints[joint].has("hips") and tree.distance(joint, meet) < 0.5 * thigh:
            return joint
    return meet


def _centre(tree: Tree, limbs: Limbs, roles: dict[str, int]) -> dict[str, int]:
    """Spine, chest, neck and head, as far as there are joints for them."""
    hips = hips_of(tree, limbs)
    tops = [arm.top for arm in limbs.arms]
    tops = tops or [roles[f"{side}_shoulder"] for side in SIDES if f"{side}_shoulder" in roles]
    if len(tops) < 2:  # one arm alone does not say where it leaves the trunk
        tops += [j for j, hint in enumerate(tree.hints) if hint.has("neck", "head")][:1]
    if not tops:
        return {}
    chest = tree.common([tree.parents[top] for top in tops])
    if hips not in tree.ancestors(chest):
        hips = tree.common([hips, chest])
    roles = {"chest": chest}
    between = tree.path(hips, chest)[1:-1]
    middle = 0.5 * tree.distance(hips, chest)
    if between:
        roles["spine"] = min(between, key=lambda j: (abs(tree.distance(hips, j) - middle), -j))
    above = _neck_and_head(tree, limbs, chest)
    if above:
        roles["head"] = above[-1]
        named = [j for j in above[:-1] if tree.hints[j].has("neck")]
        if above[:-1]:
            roles["neck"] = (named or above[:-1])[0]
    return roles


def _neck_and_head(tree: Tree, limbs: Limbs, chest: int) -> list[int]:
    """Joints above the chest up to the head."""
    arms = {j for arm in limbs.arms for j in tree.below(arm.top)}
    free = [j for j in tree.below(chest)[1:] if j not in arms and j not in set(tree.end_joints)]
    heads = [j for j in free if tree.hints[j].has("head") and not tree.hints[j].side]
    if not heads:
        free = [j for j in free if not tree.beside[j] and not tree.hints[j].side]
        heads = sorted(free, key=lambda j: -tree.distance(chest, j))
        heads = [j for j in heads if tree.hints[j].has("neck")] or heads
    return tree.path(chest, heads[0])[1:] if heads else []


def _toe(tree: Tree, leg: Limb) -> int | None:
    """The ball of the foot: the next joint after the ankle that is no end and no helper."""
    ends = set(tree.end_joints)
    below = [j for j in tree.below(leg.joints[2])[1:] if j not in ends and not tree.beside[j]]
    named = [j for j in below if tree.hints[j].has("toe")]
    return next(iter(named or below), None)


_HAND = ("fingers", "middle", "mid", "index", "ring", "finger")


def _hand(tree: Tree, arm: Limb) -> int | None:
    """Where the fingers begin, in the middle of the hand: first phalanges, no metacarpals."""
    found: list[tuple[int, int, int]] = []
    for joint in tree.below(arm.joints[2])[1:]:
        words = tree.hints[joint].words
        kind = next((rank for rank, word in enumerate(_HAND) if word in words), None)
        if kind is not None and tree.hints[joint].has("finger"):
            metacarpal = "in" in words or "metacarpal" in words or "carpal" in words
            found.append((kind, int(metacarpal), joint))
    return min(found)[2] if found else None
