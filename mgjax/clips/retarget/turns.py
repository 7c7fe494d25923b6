"""Which joint of one body follows which of another, and the rotations that follow from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

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


@dataclass(frozen=True, kw_only=True, eq=False)
class Follow:
    """What a joint does: the rotation between two joints of the source, in the joint's own axes.

    Attributes:
        first, second: joints of the source.
        share: of the second, 0 … 1.
        align: rotation from the axes of the joint to those of the source's. [4]
    """

    first: int
    second: int
    share: float
    align: np.ndarray


def carried(
    source: Body, target: Body, turns: Float[np.ndarray, "F S 4"]
) -> Float[np.ndarray, "F J 4"]:
    """Local rotations of the target whose joints turn in the world as the source's do.

    A joint takes the rotation of the joint with its role; joints of spine, neck and clavicles take
    one between those of the joints at the same share of the length; fingers and the like that of
    the joint with their name. Others, such as twist bones, keep still against their parents.

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
        turn = turns[:, follow.first]
        if follow.share > 0:
            share = np.array(follow.share)
            turn = quaternion.slerp(turn, turns[:, follow.second], share)
        world[:, joint] = quaternion.multiply(turn, follow.align)
        local[:, joint] = world[:, joint]
        if parent >= 0:
            above = quaternion.conjugate(world[:, parent])
            local[:, joint] = quaternion.multiply(above, world[:, joint])
    return np.asarray(quaternion.normalise(local))


def followers(source: Body, target: Body) -> dict[int, Follow]:
    """What each joint of the target does; those that keep still are missing."""
    plan: dict[int, Follow] = {}

    def follow(joint: int, twin: tuple[int, int, float], role: str) -> None:
        if role in source.frames and role in target.frames:
            align = quaternion.multiply(
                source.frames[role], np.asarray(quaternion.conjugate(target.frames[role]))
            )
            first, second, share = twin
            plan[joint] = Follow(first=first, second=second, share=share, align=np.asarray(align))

    follow(0, (source.pelvis, source.pelvis, 0.0), "root")
    for role in _ALONE:
        if role in source.roles and role in target.roles:
            same = source.roles[role]
            follow(target.roles[role], (same, same, 0.0), role)
    shoulders = (("left", "clavicle"), ("right", "clavicle"))
    for ends, role in (
        (("", "chest"), "spine"),
        (("chest", "head"), "neck"),
        *((("chest", f"{side}_shoulder"), role) for side, role in shoulders),
    ):
        for joint, twin in _between(source, target, ends, with_top=role != "clavicle"):
            follow(joint, twin, role)
    _by_name(source, target, plan)
    return plan


def _between(
    source: Body, target: Body, ends: tuple[str, str], *, with_top: bool
) -> list[tuple[int, tuple[int, int, float]]]:
    """Joints of the target between two roles, and where they are between those of the source.

    A bone takes the rotation that the source has at its middle. ``with_top``: the upper joint
    counts; of clavicles it does not, as the chest does not move a shoulder.
    """
    if ends[1] not in source.roles or ends[1] not in target.roles:
        return []
    joints, middles = _middles(target, ends)
    twins, at = _middles(source, ends)
    if not with_top:
        twins, at = twins[1:-1], at[1:-1]
    if len(joints) < 3 or not twins:
        return []
    found: list[tuple[int, tuple[int, int, float]]] = []
    for joint, middle in zip(joints[1:-1], middles[1:-1], strict=True):
        low = int(np.clip(np.searchsorted(at, middle, side="right") - 1, 0, max(len(at) - 2, 0)))
        high = min(low + 1, len(at) - 1)
        share = (middle - at[low]) / max(at[high] - at[low], 1e-9)
        found.append((joint, (twins[low], twins[high], float(np.clip(share, 0.0, 1.0)))))
    return found


def _middles(body: Body, ends: tuple[str, str]) -> tuple[list[int], np.ndarray]:
    """Joints from one role down to another, and the middles of their bones as shares of all."""
    tree = tree_of(body.skeleton)
    top = body.roles[ends[0]] if ends[0] else body.pelvis
    path = tree.path(top, body.roles[ends[1]])
    along = np.cumsum([0.0, *(tree.lengths[j] for j in path[1:])])
    if along[-1] <= 0:
        along = np.arange(len(path), dtype=np.float64)
    along = along / max(along[-1], 1e-9)
    return path, np.append((along[1:] + along[:-1]) / 2, 1.0)


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
        above = plan.get(parent)
        on_the_way = any(joint in _path_up(target, j) for j in limbs)
        if twin is None or joint in known or joint in plan or above is None or on_the_way:
            continue
        plan[joint] = Follow(first=twin, second=twin, share=0.0, align=above.align)


def _path_up(body: Body, joint: int) -> list[int]:
    """The joints above one."""
    found: list[int] = []
    while (joint := body.skeleton.parents[joint]) >= 0:
        found.append(joint)
    return found
