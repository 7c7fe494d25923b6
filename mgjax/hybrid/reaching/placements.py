"""When on a walk a target can be reached, and how well the body then stands to it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core import planar
from mgjax.core.body.capsules import to_points
from mgjax.hybrid.config import ReachConfig
from mgjax.hybrid.ik.limbs import Limb
from mgjax.hybrid.reaching.sampled_walk import SampledWalk
from mgjax.hybrid.reaching.targets import Target

NEAR = 0.95
"""Share of a chain's length within which a target counts as in reach."""
AHEAD_M = 0.45
"""How far in front of the root an adult reaches a target most easily."""
_ASIDE = (math.radians(-25.0), math.radians(65.0))
"""Directions in which a hand reaches easily, from straight ahead towards its own side."""
_CLEAR_M = 0.02
"""Nearer to its own body, an adult does not reach a target."""
_TRIED = 4
"""Most places on a walk that are tried for one target."""


@dataclass(frozen=True, kw_only=True)
class Placement:
    """A place of a reach on a walk.

    Attributes:
        frame: of the walk, in which the hold begins.
        stop: the walk stands still there as long as the target is held.
    """

    frame: int
    stop: bool


def radius_of(limb: Limb, height: float, base: float, drop_m: float) -> float:
    """How far on the floor the limb's base may be from a target, m; NaN where it is too high.

    √((0.95 Σd)² − Δy²), Δy the target's height above the base (0.95 Σd keeps the chain from being
    stretched); for a low target the base is as much lower as the pelvis may drop.
    """
    above = height - base
    above = min(above + drop_m, 0.0) if above < 0 else above
    length = NEAR * limb.reach_m
    return math.sqrt(length * length - above * above) if abs(above) <= length else math.nan


def stance_cost(
    sampled: SampledWalk, limb: Limb, points: Float[np.ndarray, "F 3"], config: ReachConfig
) -> Float[np.ndarray, " F"]:
    """How well the body of each frame stands to a point; infinite where it is out of reach.

    A target is easy to reach half an arm ahead of the body, on the hand's own side; one inside the
    body is not reached at all.
    """
    base, scale = sampled.positions[:, limb.joints[0]], sampled.body.scale
    local = np.asarray(planar.apply(np.asarray(planar.inverse(sampled.planes)), points))
    distance = np.linalg.norm(points[:, ::2] - base[:, ::2], axis=1)
    radius = np.array(
        [
            radius_of(limb, y, b, config.drop_m)
            for y, b in zip(points[:, 1], base[:, 1], strict=True)
        ]
    )
    inside = inside_body(sampled, points) | ~(distance <= radius)
    wanted = np.minimum(scale * AHEAD_M, 0.7 * np.nan_to_num(radius))
    cost = np.abs(distance - wanted) / (0.3 * scale)
    if limb.is_arm:
        angle = np.arctan2(limb.type.sign * local[:, 0], local[:, 2])
        cost = cost + np.maximum(0, np.maximum(angle - _ASIDE[1], _ASIDE[0] - angle)) / 0.8
    return np.where(inside, np.inf, cost)


def inside_body(sampled: SampledWalk, points: Float[np.ndarray, "F 3"]) -> np.ndarray:
    """[F] whether a point lies inside torso, head or legs."""
    core = [i for i, arm in enumerate(sampled.body.capsules.arms) if not arm]
    distance = to_points(sampled.body.capsules, sampled.positions, points)[:, core]
    return distance.min(axis=1) < sampled.body.scale * _CLEAR_M


def hold_costs(
    sampled: SampledWalk, limb: Limb, target: Target, config: ReachConfig
) -> tuple[np.ndarray, np.ndarray]:
    """Cost of holding a target from each frame on while walking, and while standing there. [F]"""
    rate = sampled.graph.frame_rate
    steps = round(target.hold_s * rate)
    count = sampled.frames + 1
    points = target.at(np.arange(steps + 1) / rate)
    if len(target.seconds) == 1:
        still = stance_cost(sampled, limb, np.broadcast_to(points[0], (count, 3)), config)
        walking = np.full(count, np.inf)
        if count > steps:
            views = np.lib.stride_tricks.sliding_window_view(still, steps + 1)
            walking[: count - steps] = views.max(axis=1)
        return walking, still
    rows = [stance_cost(sampled, limb, np.broadcast_to(p, (count, 3)), config) for p in points]
    walking = np.max(
        [np.concatenate([row[k:], np.full(k, np.inf)]) for k, row in enumerate(rows)], axis=0
    )
    return walking, np.max(rows, axis=0)


def find_placements(
    sampled: SampledWalk, limbs: list[Limb], targets: list[Target], config: ReachConfig
) -> list[Placement]:
    """Where on a walk targets that belong together may be reached, the best first."""
    pairs = [hold_costs(sampled, *pair, config) for pair in zip(limbs, targets, strict=True)]
    walking = np.sum([pair[0] for pair in pairs], axis=0)
    # Nobody stops on one leg.
    swinging = 0.8 * (2 - sampled.plants.sum(axis=1))
    standing = np.sum([pair[1] for pair in pairs], axis=0) + swinging
    when, rate = targets[0].when, sampled.graph.frame_rate
    frames = np.arange(sampled.frames + 1)
    if when == "start":
        return [Placement(frame=0, stop=True)] if np.isfinite(standing[0]) else []
    if when == "end":
        # A step earlier the body may stand better.
        early = (sampled.frames - frames) / rate
        standing = np.where(early > 0.8, np.inf, standing + early)
        return [Placement(frame=f, stop=True) for f in _best(standing)]
    late = np.zeros(len(frames))
    if not isinstance(when, str):
        first = min(round(when * rate), sampled.frames)
        late = np.where(frames < first, np.inf, (frames - first) / rate)
        # At the time that was asked for, whatever the body's stance.
        walking[first] = min(walking[first], 0.0) if np.isfinite(walking[first]) else np.inf
    chosen = [Placement(frame=f, stop=False) for f in _best(walking + late)]
    if config.stop:
        chosen += [Placement(frame=f, stop=True) for f in _best(standing + late)]
    return chosen


def _best(costs: Float[np.ndarray, " F"]) -> list[int]:
    """A few frames of least cost, a few frames apart."""
    costs = costs.copy()
    chosen: list[int] = []
    while len(chosen) < _TRIED and np.isfinite(costs).any():
        best = int(np.argmin(costs))
        chosen.append(best)
        costs[max(best - 4, 0) : best + 5] = np.inf
    return chosen
