"""Arms and legs found in a tree: pairs of long chains, legs below and arms above.

Structure comes first: a limb is one of a pair of chains with two bones of about one length, and a
name (:mod:`mgjax.core.body.names`) tips the scale between joints that would do.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from mgjax.core.body.names import NameHint
from mgjax.core.body.tree import Tree

LEG = ("hip", "knee", "ankle")
ARM = ("shoulder", "elbow", "wrist")
_LEG_WORDS = (*LEG, "toe", "before_hip")
_ARM_WORDS = (*ARM, "clavicle", "finger")

_SHORT = 0.35
"""A chain shorter than this share of the longest one is no limb (ears, breasts, fingers)."""

MOST_JOINTS = 1000
"""Bodies with faces and clothes have up to about 500 joints; more is something else."""

_BRANCHES = 8
"""As many of the longest chains that leave one joint are looked at."""

_OTHER, _NEVER = -3.0, -8.0
"""What it counts against a joint that its name says another part, or a twist bone or finger."""


@dataclass(frozen=True, kw_only=True)
class Limb:
    """A leg (hip, knee, ankle) or an arm (shoulder, elbow, wrist).

    Attributes:
        top: the joint where the limb leaves the trunk, such as a clavicle.
        joints: the three joints between and at the ends of its two long bones.
    """

    top: int
    joints: tuple[int, int, int]


@dataclass(frozen=True, kw_only=True)
class Limbs:
    """Both legs, and both arms or none; (left, right) where ``named_sides``, else in order."""

    legs: tuple[Limb, Limb]
    arms: tuple[Limb, Limb] | tuple[()]
    named_sides: bool


def find_limbs(tree: Tree) -> Limbs | None:
    """The limbs of a body on two legs, or None where the tree has none."""
    if len(tree.names) > MOST_JOINTS:
        return None
    pairs = _named_pairs(tree)
    named = _legs_and_arms(tree, pairs)
    legs, arms = named or _legs_and_arms(tree, _alike_pairs(tree)) or ((), ())
    left, right = ([_limb(tree, top, LEG) for top in legs] or [None, None])[:2]
    if left is None or right is None:
        return None
    upper = [limb for top in arms if (limb := _limb(tree, top, ARM)) is not None]
    if named is None and not _like_a_body(tree, [left, right], upper):
        return None
    return Limbs(
        legs=(left, right),
        arms=(upper[0], upper[1]) if len(upper) == 2 else (),
        named_sides=named is not None,
    )


def _like_a_body(tree: Tree, legs: list[Limb], arms: list[Limb]) -> bool:
    """Whether limbs that no name speaks for have the lengths of a body's: equal on both sides."""
    if len(arms) != 2:
        return False
    lengths = np.array([_bones(tree, limb) for limb in (*legs, *arms)]).reshape(2, 2, 2)
    left, right = lengths[:, 0], lengths[:, 1]
    even = np.abs(left - right).max() < 0.03 * lengths.max()
    upper, lower = lengths[..., 0] / lengths[..., 1], lengths[0].sum() / lengths[1].sum()
    return bool(even and (upper > 0.6).all() and (upper < 1.7).all() and 0.8 < lower < 2.5)


def _bones(tree: Tree, limb: Limb) -> tuple[float, float]:
    first, middle, last = limb.joints
    return tree.distance(first, middle), tree.distance(middle, last)


def _named_pairs(tree: Tree) -> list[tuple[int, int]]:
    """Pairs (left, right) of topmost joints whose names have a side and are equal otherwise."""
    tops: dict[tuple[str, ...], dict[str, int]] = {}
    for joint, hint in enumerate(tree.hints):
        if hint.side and hint.side not in tree.sides_above[joint]:
            tops.setdefault(hint.words, {}).setdefault(hint.side, joint)
    return [(two["left"], two["right"]) for two in tops.values() if len(two) == 2]


def _alike_pairs(tree: Tree) -> list[tuple[int, int]]:
    """Pairs of siblings whose chains are about as long and of as many joints."""
    pairs: list[tuple[int, int]] = []
    taken: set[int] = set()
    for children in tree.children:
        siblings = sorted((j for j in children if tree.reach[j] > 0), key=lambda j: -tree.reach[j])
        for a, b in combinations(sorted(siblings[:_BRANCHES]), 2):
            longer, shorter = max(tree.reach[a], tree.reach[b]), min(tree.reach[a], tree.reach[b])
            fits = abs(tree.counts[a] - tree.counts[b]) <= 2 and shorter > 0.85 * longer
            if fits and not {a, b} & taken and not taken & set(tree.ancestors(a)):
                pairs.append((a, b))
                taken |= {a, b}
    return pairs


def _legs_and_arms(
    tree: Tree, pairs: list[tuple[int, int]]
) -> tuple[tuple[int, int], tuple[int, ...]] | None:
    """The pair of legs and the pair of arms (or none); None where there are no two legs."""
    size = {pair: min(tree.reach[pair[0]], tree.reach[pair[1]]) for pair in pairs}
    most = max(size.values(), default=0.0)
    long = [pair for pair in pairs if size[pair] > _SHORT * most]
    votes = {pair: _vote(tree, pair[0]) + _vote(tree, pair[1]) for pair in long}
    legs = [pair for pair in long if votes[pair] > 0]
    arms = [pair for pair in long if votes[pair] < 0]
    unnamed = sorted((p for p in long if votes[p] == 0), key=lambda p: _height(tree, p))
    if not legs and unnamed:
        legs = [unnamed.pop(0)]
    if not arms and unnamed:
        arms = [unnamed.pop(0)]
    if not legs or (len(legs) > 1 and _four_legs(tree, legs)):
        return None
    return max(legs, key=lambda p: size[p]), max(arms, key=lambda p: size[p], default=())


def four_legged(tree: Tree) -> bool:
    """Whether names speak of two pairs of legs, or of a tail, wings, paws or hooves."""
    legs = [pair for pair in _named_pairs(tree) if _vote(tree, pair[0]) > 0]
    animal = sum(hint.has("animal") for hint in tree.hints)
    return animal > 0 or (len(legs) > 1 and _four_legs(tree, legs))


def _four_legs(tree: Tree, legs: list[tuple[int, int]]) -> bool:
    """Whether two pairs of legs leave the trunk at places of their own."""
    tops = [tree.common(list(pair)) for pair in legs]
    return len(set(tops)) > 1


def _height(tree: Tree, pair: tuple[int, int]) -> tuple[float, float]:
    """How far from the root a pair leaves the trunk; of two at one place the longer comes first."""
    return tree.distance(0, tree.common(list(pair))), -float(tree.reach[pair[0]])


def _vote(tree: Tree, top: int) -> float:
    """Above 0 where the names of a chain speak of a leg, below where they speak of an arm."""
    total = 0.0
    for joint in tree.below(top):
        hint = tree.hints[joint]
        total += sum(hint.weight(w) for w in _LEG_WORDS) - sum(hint.weight(w) for w in _ARM_WORDS)
    return total


def _limb(tree: Tree, top: int, parts: tuple[str, str, str]) -> Limb | None:
    chain = main_chain(tree, top, parts)
    total = max(tree.distance(top, chain[-1]), 1e-9)
    best, joints = -np.inf, None
    along = np.cumsum([0.0, *(tree.lengths[j] for j in chain[1:])])
    for i, j, k in combinations(range(len(chain)), 3):
        upper, lower = along[j] - along[i], along[k] - along[j]
        if min(upper, lower) <= 0.02 * total:
            continue
        score = 4 * (upper + lower) / total - 2 * abs(np.log(upper / lower)) - (k - i - 2)
        for at, part in zip((i, j, k), parts, strict=True):
            score += _fit(tree.hints[chain[at]], part)
        if score > best:
            best, joints = score, (chain[i], chain[j], chain[k])
    return None if joints is None else Limb(top=top, joints=joints)


def _fit(hint: NameHint, part: str) -> float:
    if part in hint.weights:
        return hint.weight(part)
    if hint.has("helper", "finger", "prop"):
        return _NEVER
    return _OTHER if hint.weights else 0.0


def main_chain(tree: Tree, top: int, parts: tuple[str, ...]) -> list[int]:
    """Joints from ``top`` along the limb: where it branches, to the joints named like its parts.

    Else along the longest chain. Fingers are left out, and ends too where there are three joints.
    """
    chain = [top]
    ends = set(tree.end_joints)
    while below := [j for j in tree.children[chain[-1]] if not tree.beside[j]]:
        named = [j for j in below if any(tree.hints[k].has(*parts) for k in tree.below(j))]
        chain.append(max(named or below, key=lambda j: tree.reach[j] + tree.lengths[j]))
    while len(chain) > 3 and (chain[-1] in ends or tree.hints[chain[-1]].has("finger")):
        chain.pop()
    return chain
