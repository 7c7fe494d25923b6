"""Reaching poses blended into a motion, and how fast its joints then turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.core import planar, quaternion
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion
from mgjax.core.timing.easing import plateau
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.body.pelvis import lower_pelvis
from mgjax.hybrid.body.rig import full_pose, track_targets
from mgjax.hybrid.config import ReachConfig
from mgjax.hybrid.ik.limbs import LIMBS, Limb, find_limb
from mgjax.hybrid.prepared import ReachBody
from mgjax.hybrid.reaching.key_pose import KeyPose
from mgjax.hybrid.reaching.targets import Target

_SETTLE_S = 0.15
"""Time in which a goal comes to rest relative to the body."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Hold:
    """Targets that are held together, in frames of the motion.

    Attributes:
        first, last: the hold, ends included.
        targets: one for each limb of the key.
        key: a pose that reaches them.
        key_frame: where the key pose stands.
    """

    first: int
    last: int
    targets: tuple[Target, ...]
    key: KeyPose
    key_frame: int


def hold_weight(hold: Hold, frames: int, blend: tuple[int, int]) -> Float[np.ndarray, " F"]:
    """1 over the hold, rising before and falling after it over so many frames."""
    return plateau(np.arange(frames), hold.first, hold.last, *blend)


def overlapping_groups(holds: Sequence[Hold], blend: int) -> list[list[Hold]]:
    """Holds in groups, those together whose blends overlap; sorted by time."""
    groups: list[list[Hold]] = []
    for hold in sorted(holds, key=lambda s: s.first):
        if groups and hold.first - blend <= max(s.last for s in groups[-1]) + blend:
            groups[-1].append(hold)
        else:
            groups.append([hold])
    return groups


def blend_group(
    graph: MotionGraph,
    body: ReachBody,
    motion: Motion,
    group: list[Hold],
    blend: int,
    config: ReachConfig,
) -> Motion:
    """A motion with the reaches of one group of holds.

    All limbs of the group are solved together. In each frame a limb's goal leads from where the
    walk has it to its target, and the walk's pose gives way to the solved one by a weight that is 1
    over every hold. Both are C¹ in time.
    """
    first = max(group[0].first - blend, 0)
    last = min(max(s.last for s in group) + blend, motion.num_frames - 1)
    weights = np.stack([hold_weight(s, motion.num_frames, _room(s, group, blend)) for s in group])
    total = 1 - np.prod(1 - weights, axis=0)
    depth = np.array([s.key.drop_m for s in group])
    drop = (weights * depth[:, None]).sum(axis=0) / np.maximum(1.0, weights.sum(axis=0))
    lowered = lower_pelvis(body.skeleton, motion, drop)
    names = {limb.name for s in group for limb in s.key.rig.limbs}
    limbs = tuple(find_limb(body.skeleton, name) for name in LIMBS if name in names)
    rig = body.rig(limbs, config)
    rows = np.arange(first, last + 1)
    root = np.asarray(lowered.root_translation)[rows]
    local = np.asarray(lowered.local_rotations)[rows]
    share = (weights / np.maximum(total, 1e-9))[:, rows]
    goals = _goals(graph, rig.limbs, root, local, group, share, rows)
    key = group[0].key_frame - first
    pose = local[key][list(rig.joints)].copy()
    for joint, rotation in zip(group[0].key.rig.joints, group[0].key.pose, strict=True):
        pose[rig.joints.index(joint)] = rotation
    solved = full_pose(rig, root, local, track_targets(rig, root, local, goals, key, pose))
    mixed = np.asarray(lowered.local_rotations).copy()
    mixed[rows] = quaternion.slerp(local, solved, total[rows, None].astype(np.float32))
    return replace(lowered, local_rotations=mixed)


def _room(hold: Hold, group: list[Hold], blend: int) -> tuple[int, int]:
    """Blend frames before and after a hold; neighbours that move the same limb leave less room."""
    own = {limb.name for limb in hold.key.rig.limbs}
    others = [s for s in group if s is not hold and own & {x.name for x in s.key.rig.limbs}]
    before = [hold.first - s.last for s in others if s.last < hold.first]
    after = [s.first - hold.last for s in others if s.first > hold.last]
    return max(min([blend, *before]), 1), max(min([blend, *after]), 1)


def _goals(
    graph: MotionGraph,
    limbs: tuple[Limb, ...],
    root: np.ndarray,
    local: np.ndarray,
    group: list[Hold],
    share: Float[np.ndarray, "S F"],
    rows: np.ndarray,
) -> Float[np.ndarray, "F E 3"]:
    """Where the limbs' ends are to be: of the walk's place and the targets' so much of each."""
    positions = np.asarray(forward(graph.skeleton, root, local)[0], np.float64)
    planes = np.asarray(planar_frames(graph.skeleton, positions))
    walked = positions[:, [limb.joints[-1] for limb in limbs]]
    goals = walked.copy()
    names = [limb.name for limb in limbs]
    for number, hold in enumerate(group):
        for target in hold.targets:
            column = names.index(target.limb)
            displacement = (
                _carried(target, hold, planes, rows, graph.frame_rate) - walked[:, column]
            )
            goals[:, column] += share[number][:, None] * displacement
    return goals


def _carried(
    target: Target,
    hold: Hold,
    planes: Float[np.ndarray, "F 3"],
    rows: np.ndarray,
    frame_rate: float,
) -> Float[np.ndarray, "F 3"]:
    """The target over its hold; before and after that a place that goes along with the body.

    A second earlier the target may be far out of reach, and an arm stretched towards it would snap
    when it comes near. So the goal keeps its place before the body, and the velocity that it has
    relative to the body at the beginning or the end of the hold dies down within a few frames.
    """
    own = np.asarray(
        planar.apply(
            np.asarray(planar.inverse(planes)), target.at((rows - hold.first) / frame_rate)
        )
    )
    for edge, sign in ((hold.first, -1), (hold.last, 1)):
        at = edge - int(rows[0])
        low, high = max(at - 1, 0), min(at + 1, len(rows) - 1)
        velocity = (own[high] - own[low]) * frame_rate / max(high - low, 1)
        seconds = np.maximum(sign * (rows - edge), 0) / frame_rate
        displacement = sign * _SETTLE_S * (1 - np.exp(-seconds / _SETTLE_S))
        own = np.where((seconds > 0)[:, None], own[at] + displacement[:, None] * velocity, own)
    return np.asarray(planar.apply(planes, own))


def turn_speeds(motion: Motion) -> Float[np.ndarray, "F J"]:
    """Degrees per second by which each joint turns from one frame to the next."""
    local = np.asarray(motion.local_rotations, np.float64)
    return (
        np.degrees(np.asarray(quaternion.angle_between(local[:-1], local[1:]))) * motion.frame_rate
    )


def fastest_turn(motion: Motion, plain: Motion) -> float:
    """Fastest turn of a joint where it turns more than 5 % faster than in the plain motion."""
    return float(fast_frames(motion, plain).max())


def fast_frames(motion: Motion, plain: Motion) -> Float[np.ndarray, " F"]:
    """Fastest turn of a joint from each frame to the next, degrees/s.

    Only joints count that turn more than 5 % faster than in the plain motion; 0 where none does.
    """
    turned, before = turn_speeds(motion), turn_speeds(plain)
    return np.where(turned > 1.05 * before + 1.0, turned, 0.0).max(axis=1)
