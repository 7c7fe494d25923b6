"""The height of a body from the lengths of its bones, whatever its rest pose looks like."""

from __future__ import annotations

import numpy as np

from mgjax.core.body.roles import find_roles
from mgjax.core.body.tree import Tree
from mgjax.core.skeleton import Skeleton

REST = 0.063
"""What ankles and hips add to the lengths of legs and trunk, as a share of these."""

HEAD = 0.09
"""Length of a head as a share of legs and trunk, where the skeleton has no plausible end of it."""

LEGS = 0.52
"""Hip to ankle as a share of the height, where no head is known: 0.49 … 0.54."""

ADULT_M = 1.625
"""Height of the body for which lengths and speeds of settings and tables are written, m: that of
the embedded clips. The captured bodies on which they were chosen have 1.56 to 1.61 m."""


def body_scale(skeleton: Skeleton) -> float:
    """By how much lengths meant for a body of :data:`ADULT_M` are larger for this one.

    Times stay, so speeds are scaled like lengths, and masses and gravity do not come in: a body and
    its motion made twice as large move through the same frames. What belongs to the world (a ball,
    the floor, the accuracy of capture and files) is not scaled. 1 where there is no body.
    """
    return (body_height(skeleton) or ADULT_M) / ADULT_M


def body_height(skeleton: Skeleton) -> float | None:
    """Height of the standing body in the unit of the offsets, or None where there is no body.

    From the lengths of legs, trunk and head, so that a rest pose that lies flat, or has all bones
    along one axis, changes nothing. Within 2 % of a standing rest pose, where there is one.
    """
    return chain_height(tree_of(skeleton), find_roles(skeleton))


def tree_of(skeleton: Skeleton) -> Tree:
    """The skeleton's tree of bones."""
    offsets = np.asarray(skeleton.offsets, dtype=np.float64)
    return Tree(skeleton.names, skeleton.parents, skeleton.end_joints, offsets)


def chain_height(tree: Tree, roles: dict[str, int]) -> float | None:
    """The height of a body with these roles; see :func:`body_height`."""
    legs = [
        tree.distance(roles[f"{side}_hip"], roles[f"{side}_ankle"])
        for side in ("left", "right")
        if f"{side}_hip" in roles and f"{side}_ankle" in roles
    ]
    if not legs or not np.mean(legs) > 0:
        return None
    leg = float(np.mean(legs))
    if "head" not in roles:
        return leg / LEGS
    hips = tree.common([roles["left_hip"], roles["right_hip"], roles["head"]])
    length = leg + tree.distance(hips, roles["head"])
    above = [tree.lengths[j] for j in tree.children[roles["head"]] if not tree.beside[j]]
    head = max(above, default=0.0) / length
    return float(length * (1 + REST + (head if 0.04 <= head <= 0.2 else HEAD)))
