"""Which joint of one body follows which of another, and the rotations that follow from it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from mgjax.clips.retarget.axes import trunk
from mgjax.clips.retarget.body import Body
from mgjax.core import quaternion
from mgjax.core.body.height import tree_of
from mgjax.core.body.names import bare

_ALONE = (
    *("chest", "head"),
    *(
        f"{side}_{part}"
        for side in ("left", "right")
        for part in ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist", "hand")
    ),
)
"""Roles that follow the same role; others share what a chain of joints does."""


class Follow(NamedTuple):
    """What a joint does: it turns as something between two joints of the source.

    Attributes:
        first, second: joints of the source.
        share: of the second, 0 … 1.
    """

    first: int
    second: int
    share: float


def carried(
    source: Body, target: Body, turns: Float[np.ndarray, "F S 4"]
) -> Float[np.ndarray, "F J 4"]:
    """Local rotations of the target whose joints turn in the world as the source's do.

    Both are seen in anatomical axes (:mod:`mgjax.clips.retarget.axes`). A joint takes the rotation
    of the joint with its role; joints of spine, neck and clavicles take one between those of the
    joints at the same share of the length; fingers and the like that of the joint with their name.
    Others, such as twist bones, keep still against their parents.

    Args:
        source, target: the bodies.
        turns: rotations of the source's joints in the world.
    """
    plan = followers(source, target)
    skeleton = target.skeleton
    world = np.zeros((len(turns), skeleton.num_joints, 4))
    local = np.zeros_like(world)
    local[..., 0] = 1.0
    for joint, parent in enumerate(skeleton.parents):
        follow = plan.get(joint)
        if follow is None:
            world[:, joint] = world[:, parent]
            continue
        turn = quaternion.multiply(turns[:, follow.first], source.axes(follow.first))
        if follow.share > 0:
            other = quaternion.multiply(turns[:, follow.second], source.axes(follow.second))
            turn = quaternion.slerp(turn, other, np.array(follow.share))
        own = np.asarray(quaternion.conjugate(target.axes(joint)))
        world[:, joint] = quaternion.multiply(turn, own)
        local[:, joint] = world[:, joint]
        if parent >= 0:
            above = quaternion.conjugate(world[:, parent])
            local[:, joint] = quaternion.multiply(above, world[:, joint])
    return np.asarray(quaternion.normalise(local))


def followers(source: Body, target: Body) -> dict[int, Follow]:
    """What each joint of the target does; those that keep still are missing."""
    plan = {0: Follow(source.pelvis, source.pelvis, 0.0)}
    for role in _ALONE:
        if role in source.roles and role in target.roles:
            same = source.roles[role]
            plan[target.roles[role]] = Follow(same, same, 0.0)
    chains = [trunk(tree_of(b.skeleton), b.roles, b.pelvis) for b in (source, target)]
    for role in chains[0].keys() & chains[1].keys():
        with_top = not role.endswith("shoulder")
        plan |= _between(source, target, chains[0][role], chains[1][role], with_top=with_top)
    _by_name(source, target, plan)
    return plan


def _between(
    source: Body, target: Body, theirs: list[int], ours: list[int], *, with_top: bool
) -> dict[int, Follow]:
    """Joints between the ends of a chain, and where they are between those of the source's.

    A bone takes the rotation that the source has at its middle. ``with_top``: the upper joint
    counts; of clavicles it does not, as the chest does not move a shoulder.
    """
    middles, at = _middles(target, ours), _middles(source, theirs)
    if not with_top:
        theirs, at = theirs[1:-1], at[1:-1]
    if not theirs:
        return {}
    found: dict[int, Follow] = {}
    for joint, middle in zip(ours[1:-1], middles[1:-1], strict=True):
        low = int(np.clip(np.searchsorted(at, middle, side="right") - 1, 0, max(len(at) - 2, 0)))
        high = min(low + 1, len(at) - 1)
        share = (middle - at[low]) / max(at[high] - at[low], 1e-9)
        found[joint] = Follow(theirs[low], theirs[high], float(np.clip(share, 0.0, 1.0)))
    return found


def _middles(body: Body, path: list[int]) -> np.ndarray:
    """Middles of the bones of a chain as shares of its length, and 1 for its last joint."""
    lengths = tree_of(body.skeleton).lengths[path[1:]]
    if lengths.sum() <= 0:
        lengths = np.ones(len(path) - 1)
    along = np.concatenate([[0.0], np.cumsum(lengths)]) / max(lengths.sum(), 1e-9)
    return np.append((along[1:] + along[:-1]) / 2, 1.0)


def _by_name(source: Body, target: Body, plan: dict[int, Follow]) -> None:
    """Joints below those that follow, such as fingers, follow the joint with their name."""
    ends = (set(source.skeleton.end_joints), set(target.skeleton.end_joints))
    taken = set(source.roles.values())
    names = {
        bare(name).lower(): j
        for j, name in enumerate(source.skeleton.names)
        if j not in taken and j not in ends[0]
    }
    known = set(target.roles.values()) | ends[1]
    limbs = {j for j in target.roles.values() if j != 0}
    for joint, name in enumerate(target.skeleton.names):
        twin, parent = names.get(bare(name).lower()), target.skeleton.parents[joint]
        on_the_way = any(joint in _path_up(target, j) for j in limbs)
        if twin is None or joint in known or joint in plan or parent not in plan or on_the_way:
            continue
        plan[joint] = Follow(twin, twin, 0.0)


def _path_up(body: Body, joint: int) -> list[int]:
    """The joints above one."""
    found: list[int] = []
    while (joint := body.skeleton.parents[joint]) >= 0:
        found.append(joint)
    return found
