"""The joints of one skeleton in the order of another: files of one body list them differently."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mgjax.core.body.names import bare
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton


def in_order_of(
    reference: Skeleton, skeleton: Skeleton, motion: Motion
) -> tuple[Skeleton, Motion] | None:
    """The same body and motion with the joints in the reference's order, or None.

    The hierarchies must be equal by the names of the joints that turn; end joints, which formats
    name differently, by what they hang on and in which order. Lengths of bones stay as they are.
    """
    here = {key: joint for joint, key in enumerate(_keys(skeleton))}
    wanted = _keys(reference)
    if len(here) != len(wanted) or set(here) != set(wanted):
        return None
    order = [here[key] for key in wanted]
    parents = [skeleton.parents[joint] for joint in order]
    if [-1 if p < 0 else order.index(p) for p in parents] != list(reference.parents):
        return None
    if order == list(range(len(order))):
        return skeleton, motion
    offsets = motion.joint_offsets
    return (
        Skeleton(
            names=tuple(skeleton.names[joint] for joint in order),
            parents=reference.parents,
            offsets=np.asarray(skeleton.offsets)[order],
            end_joints=reference.end_joints,
            roles=tuple((role, order.index(joint)) for role, joint in skeleton.roles),
        ),
        replace(
            motion,
            local_rotations=np.asarray(motion.local_rotations)[:, order],
            joint_offsets=None if offsets is None else np.asarray(offsets)[:, order],
        ),
    )


def _keys(skeleton: Skeleton) -> Sequence[tuple[str, int]]:
    """What each joint is known by: its name, or that of its parent and which of its ends it is."""
    ends: dict[str, int] = {}
    keys: list[tuple[str, int]] = []
    for joint, name in enumerate(skeleton.names):
        if joint in skeleton.end_joints:
            above = bare(skeleton.names[skeleton.parents[joint]])
            ends[above] = ends.get(above, 0) + 1
            keys.append((above, ends[above]))
        else:
            keys.append((bare(name), 0))
    return keys
