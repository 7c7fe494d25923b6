"""Seeded throws, the answers to them, and what the answers amount to."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.checks.written import clearance, sphere_trajectory, walk_motion
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.rates import CLEAR_M
from mgjax.core.errors import AttackError
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk

DISTANCE_M = 5.0
"""From where a ball is thrown to where it is aimed at."""
OUTCOMES = (
    "avoided",
    "hit",
    "no_candidate",
    "no_time_scale",
    "not_near",
    "refused",
    "parried",
)
"""``no_time_scale``: eq. 1 has candidates, and none can be scaled to meet the attack;
``not_near``: the attack stays outside the cylinder around the character; ``refused``: it begins
inside the body."""
CONTINUATIONS = 6
"""Random continuations that are tried after a path that is played as captured."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Throws:
    """Straight balls at the body's axis.

    Attributes:
        node: where the character stands, as a share of the graph's nodes. [B]
        side: where the ball comes from, rad from ahead towards the left. [B]
        height: at the axis, m. [B]
        speed: m/s.
        arrives: at the axis, s from now.
    """

    node: np.ndarray
    side: np.ndarray
    height: np.ndarray
    speed: float = 10.0
    arrives: float = 1.2

    def __len__(self) -> int:
        return len(self.node)

    def attack(self, number: int) -> Attack:
        """One ball."""
        side = self.side[number]
        return ball_from(
            float(side),
            float(self.height[number]),
            distance=DISTANCE_M,
            speed=self.speed,
            arrives=self.arrives,
        )

    def node_of(self, number: int, graph: MotionGraph) -> int:
        """Where the character stands."""
        return int(self.node[number] * graph.num_nodes)


def standard_throws(count: int, seed: int) -> Throws:
    """10 m/s from any side, 0.5–1.7 m high, there in 1.2 s, at random nodes."""
    rng = np.random.default_rng(seed)
    node, side, height = rng.uniform(size=(3, count))
    return Throws(node=node, side=2 * np.pi * side, height=0.5 + 1.2 * height)


def outcome_of(chosen: Selection) -> str:
    """What became of an attack, one of :data:`OUTCOMES`."""
    if chosen.status != "no_candidate":
        return chosen.status
    if chosen.crop is None:
        return "not_near"
    return "no_time_scale" if chosen.candidates else "no_candidate"


def answer(graph: MotionGraph, throws: Throws, config: AvoidanceConfig) -> dict[str, Any]:
    """Chooses for every ball, and sums up; see :func:`summary`."""
    outcomes: list[str] = []
    gaps: list[float] = []
    kinds: list[str] = []
    scales: list[float] = []
    candidates: list[int] = []
    genuine = cut_short = 0
    for number in range(len(throws)):
        try:
            chosen = select(
                graph, throws.node_of(number, graph), throws.attack(number), config=config
            )
        except AttackError:
            outcomes.append("refused")
            gaps.append(np.nan)
            continue
        outcomes.append(outcome_of(chosen))
        gaps.append(np.nan if chosen.clearance_m is None else chosen.clearance_m)
        candidates.append(chosen.candidates)
        if outcomes[-1] == "avoided" and chosen.part is not None:
            kinds.append(graph.label_kind[chosen.part])
            genuine += bool(graph.label_genuine[chosen.part])
            scales.append(chosen.time_scale or 1.0)
        cut_short += outcomes[-1] == "hit" and chosen.clear_until is not None
    result = summary(outcomes, gaps)
    return result | {
        "avoided_by_a_genuine_part": genuine / len(throws),
        "avoided_by_kind": {k: n / len(throws) for k, n in sorted(Counter(kinds).items())},
        "hit_after_the_path": cut_short / len(throws),
        "time_scale_p5_p50_p95": percentiles(scales, (5, 50, 95)),
        "candidates_mean": float(np.mean(candidates)) if candidates else None,
    }


def answer_unscaled(graph: MotionGraph, throws: Throws, config: AvoidanceConfig) -> dict[str, Any]:
    """The same with every candidate played as captured, at whatever time its avoidance comes.

    Of the candidates of eq. 1 the ``config.checks`` nearest in time are checked exactly; avoided
    is what one of them, with one of a few random continuations, stays clear of.
    """
    tables = prepared_for(graph, config).tables
    config = for_body(config, graph.body_scale)
    outcomes: list[str] = []
    gaps: list[float] = []
    for number in range(len(throws)):
        attack, node = throws.attack(number), throws.node_of(number, graph)
        crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
        if crop is None:
            outcomes.append("not_near")
            gaps.append(np.nan)
            continue
        found = enumerate_candidates(
            graph, tables, node, crop.middle, window=config.T_window, capacity=config.capacity
        )
        gap = _best_unscaled(graph, tables, found, attack, crop.middle, config)
        gaps.append(gap)
        status = "avoided" if gap >= CLEAR_M else "hit"
        outcomes.append(status if len(found.length) else "no_candidate")
    return summary(outcomes, gaps)


def _best_unscaled(
    graph: MotionGraph,
    tables: EdgeTables,
    found: Candidates,
    attack: Attack,
    middle: float,
    config: AvoidanceConfig,
) -> float:
    """Largest clearance of those checked, m; stops at the first that is clear. NaN for none."""
    rows = np.arange(len(found.length))
    counted = np.where(found.edges >= 0, tables.seconds[found.edges], 0.0)
    counted[rows, found.length - 1] = tables.part_centre[found.part]
    late = np.abs(counted.sum(axis=1) - middle)
    rng = np.random.default_rng(0)
    best = np.nan
    for row in np.argsort(late, kind="stable")[: config.checks]:
        path = found.edges[row, : found.length[row]]
        for _ in range(CONTINUATIONS):
            gap, path_gap = _gaps(graph, path, attack, config.settle_s, rng)
            best = np.fmax(best, gap)
            if best >= CLEAR_M:
                return float(best)
            if path_gap < CLEAR_M:
                break  # no continuation helps
    return float(best)


def _gaps(
    graph: MotionGraph, path: np.ndarray, attack: Attack, settle: float, rng: np.random.Generator
) -> tuple[float, float]:
    """Clearance of a path with a random continuation, and of the path alone, m."""
    until = attack.end + settle
    edges = list(path)
    end = graph.edge_frames[path].sum() / graph.frame_rate
    path_end = end
    while end < until:
        edges.append(int(rng.choice(graph.edges_from(int(graph.edge_target[edges[-1]])))))
        end += graph.edge_frames[edges[-1]] / graph.frame_rate
    spheres = preset_spheres(graph.skeleton)
    motion = walk_motion(graph, make_walk(graph, np.array(edges)), until)
    trace = sphere_trajectory(graph, spheres, motion)
    steps, gap = clearance(attack, trace, spheres.radii)
    return gap, float(steps[trace.times[1:] <= path_end].min(initial=np.inf))


def summary(outcomes: list[str], gaps: list[float]) -> dict[str, Any]:
    """Shares of the outcomes, the 95 % interval of the share avoided, and how deep hits are.

    ``outcome`` (numbers within :data:`OUTCOMES`) and ``clearance_m`` are those of each ball.
    """
    count = len(outcomes)
    counts = Counter(outcomes)
    deep = [-gap for gap, outcome in zip(gaps, outcomes, strict=True) if outcome == "hit"]
    return {
        "balls": count,
        **{name: counts[name] / count for name in OUTCOMES},
        "avoided_interval": wilson(counts["avoided"], count),
        "hit_depth_m_p50_p90": percentiles(deep, (50, 90)),
        "outcome": [OUTCOMES.index(name) for name in outcomes],
        "clearance_m": gaps,
    }


def wilson(successes: int, count: int) -> list[float]:
    """The 95 % interval of a share (Wilson's score interval)."""
    z = 1.959964
    share = successes / count
    middle = share + z * z / (2 * count)
    half = z * np.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    low, high = (middle - half) / (1 + z * z / count), (middle + half) / (1 + z * z / count)
    return [float(max(low, 0.0)), float(min(high, 1.0))]


def percentiles(values: list[float], percents: tuple[float, ...]) -> list[float] | None:
    """Percentiles, or None of nothing."""
    return [float(x) for x in np.percentile(values, percents)] if values else None


def at_speed(throws: Throws, speed: float) -> Throws:
    return replace(throws, speed=speed)


def arriving_in(throws: Throws, seconds: float) -> Throws:
    return replace(throws, arrives=seconds)


def at_height(throws: Throws, height: float) -> Throws:
    return replace(throws, height=np.full(len(throws), height))


def from_sector(throws: Throws, sector: int, sectors: int) -> Throws:
    """All from one of ``sectors`` directions; number 0 is ahead, then leftwards."""
    within = throws.side / (2 * np.pi) - 0.5
    return replace(throws, side=(sector + within) * 2 * np.pi / sectors)
