"""A body that ducks under a bar: the pelvis goes down, the head comes down and forward."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.body.capsules import segment_distance, to_bar
from mgjax.core.kinematics import forward, global_positions, planar_frames
from mgjax.core.motion import Motion
from mgjax.core.timing.easing import plateau
from mgjax.hybrid.body.pelvis import lower_pelvis
from mgjax.hybrid.body.rig import full_pose, track_targets
from mgjax.hybrid.config import ReachConfig
from mgjax.hybrid.ik.limbs import HEAD, find_limb
from mgjax.hybrid.prepared import ReachBody
from mgjax.hybrid.reaching.targets import Bar

CLEAR_M = 0.02
"""What is to be left between an adult's body and a bar."""
_NEAR_M = 0.75
"""An adult's body stays down while its root is so near to the bar on the floor."""
_LEAN = math.radians(75.0)
"""How far the head turns forward about the hips in the deepest duck."""
_DEPTHS = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class Duck:
    """What came of one bar.

    Attributes:
        motion: with the duck.
        depth: 0 where none is needed, 1 for the deepest.
        frames: first and last frame of staying down; None where the body passes upright.
    """

    motion: Motion
    depth: float
    frames: tuple[int, int] | None


def bar_clearance(body: ReachBody, motion: Motion, bar: Bar) -> Float[np.ndarray, " F"]:
    """Distance of the whole body to a bar in each frame, m; negative where it is hit."""
    positions = np.asarray(global_positions(body.skeleton, motion), np.float64)
    return to_bar(body.capsules, positions, bar.ends, bar.radius)


def duck(body: ReachBody, motion: Motion, bar: Bar, blend: int, config: ReachConfig) -> Duck:
    """The least duck with which the whole body passes under a bar, or the deepest one.

    The head's target is its place turned forward about the hips, which lower at the same time with
    the feet fixed; depth by depth, until nothing of the body comes nearer to the bar than
    :data:`CLEAR_M`, times the scale of the body. Where no depth does, the one that leaves most is
    kept.
    """
    plain, clear = bar_clearance(body, motion, bar), body.scale * CLEAR_M
    if plain.min() >= clear:
        return Duck(motion=motion, depth=0.0, frames=None)
    passes = _passes(body, motion, bar, plain, blend)
    number = np.arange(motion.num_frames)
    weight = np.max([plateau(number, *ends, blend, blend) for ends in passes], axis=0)
    first, last = passes[0][0], passes[-1][1]
    middle = sum(passes[0]) // 2
    best: tuple[float, Duck] | None = None
    for depth in np.arange(1, _DEPTHS + 1) / _DEPTHS:
        moved = _ducked(body, motion, weight, float(depth), middle, config)
        least = float(bar_clearance(body, moved, bar).min())
        trial = Duck(motion=moved, depth=float(depth), frames=(first, last))
        if best is None or least > best[0]:
            best = least, trial
        if least >= clear:
            break
    assert best is not None
    return best[1]


def _passes(
    body: ReachBody, motion: Motion, bar: Bar, plain: Float[np.ndarray, " F"], blend: int
) -> list[tuple[int, int]]:
    """First and last frame of each time that the body is under the bar, where it would be hit."""
    root = np.asarray(motion.root_translation, np.float64) * [1, 0, 1]
    floor = np.broadcast_to(bar.ends[0] * [1, 0, 1], root.shape)
    axis = np.broadcast_to((bar.ends[1] - bar.ends[0]) * [1, 0, 1] + [1e-6, 0, 0], root.shape)
    distance = segment_distance(root, root + np.array([0.0, 1e-3, 0.0]), floor, axis)
    clear = body.scale * CLEAR_M
    low = np.flatnonzero((distance < body.scale * _NEAR_M) | (plain < clear))
    cuts = np.flatnonzero(np.diff(low) > max(2 * blend, 1)) + 1
    runs = [(int(run[0]), int(run[-1])) for run in np.split(low, cuts)]
    return [(a, b) for a, b in runs if plain[a : b + 1].min() < clear]


def _ducked(
    body: ReachBody,
    motion: Motion,
    weight: Float[np.ndarray, " F"],
    depth: float,
    middle: int,
    config: ReachConfig,
) -> Motion:
    lowered = lower_pelvis(body.skeleton, motion, depth * config.drop_m * weight)
    limb = find_limb(body.skeleton, HEAD.name)
    rig = body.rig((limb,), config)
    rows = np.flatnonzero(weight > 0)
    root = np.asarray(lowered.root_translation)[rows]
    local = np.asarray(lowered.local_rotations)[rows]
    positions = np.asarray(forward(body.skeleton, root, local)[0], np.float64)
    heading = np.asarray(planar_frames(body.skeleton, positions))[:, 0]
    base = positions[:, limb.joints[0]]
    up = positions[:, limb.joints[-1]] - base
    left = np.stack([np.cos(heading), 0 * heading, -np.sin(heading)], axis=-1)
    # A bent back is shorter than a straight one.
    turned = quaternion.rotate(quaternion.from_axis_angle(left, depth * _LEAN + 0 * heading), up)
    goals = base + (1 - 0.08 * depth) * turned
    key = int(np.searchsorted(rows, middle))
    poses = track_targets(
        rig, root, local, np.asarray(goals)[:, None], key, local[key][list(rig.joints)]
    )
    solved = full_pose(rig, root, local, poses)
    mixed = np.asarray(lowered.local_rotations).copy()
    mixed[rows] = quaternion.slerp(local, solved, weight[rows, None].astype(np.float32))
    return replace(lowered, local_rotations=mixed)
