"""From judged candidates to the choice: in their order, the first that is certainly clear."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import jax
import numpy as np

from mgjax.avoidance.answer import Choice, Dropped, Energy
from mgjax.avoidance.attack import Attack, Crop
from mgjax.avoidance.candidates import NO_EDGE, Candidates
from mgjax.avoidance.certify import LANES, MORE_LANES, Bounds
from mgjax.avoidance.check import CLEAR_M
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.device_tables import search_tables
from mgjax.avoidance.exact import clearance_between
from mgjax.avoidance.follow import Played, extend, play_on
from mgjax.avoidance.search import SCORES, Found, Task, bound
from mgjax.avoidance.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk

ROUNDING_M = 1e-5
"""What the jitted check may differ from that of the written motion."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Settled:
    """What was found among some candidates; ``choice`` is None if none of them can be timed."""

    choice: Choice | None
    dropped: Dropped


def settle(
    graph: MotionGraph,
    node: int,
    attack: Attack,
    crop: Crop,
    candidates: Candidates,
    task: Task,
    found: Found,
    config: AvoidanceConfig,
    *,
    culled: int = 0,
) -> Settled:
    """Goes through candidates in the order of their energy; the first that stays clear wins.

    The bounds of :mod:`mgjax.avoidance.certify` decide on most. Where they leave a doubt, or the
    path is clear and the longest edges after it are not, the poses of the written motion are looked
    at, and other edges are tried after the path.
    """
    counts = np.asarray(found.counts)
    dropped = Dropped(
        culled=culled,
        not_adjustable=int(counts[NOT_ADJUSTABLE]),
        time_scale=int(counts[OUT_OF_RANGE]),
        overflow=candidates.overflow,
    )
    usable = int(counts[OK])
    if not usable:
        return Settled(choice=None, dropped=dropped)
    # Without hope for any the one that is touched least stands for all.
    hopeful = max(int(found.hopeful), 1)
    order = np.asarray(found.order)[: min(hopeful, config.checks)]
    clear, hits = False, 0
    best: tuple[int, Played] | None = None
    for number, lane, bounds in _lanes(graph, order, task, found, config):
        touched = bool(bounds.touched_from[lane] < bounds.path_end[lane])
        if touched and best is not None and bounds.clearance[lane] <= best[1].clearance:
            hits += 1
            continue
        clear, played = _decide(graph, attack, int(task.length[number]), lane, bounds, config)
        if clear or best is None or played.clearance > best[1].clearance:
            best = (number, played)
        if clear:
            break
        hits += 1
    assert best is not None
    number, played = best
    if not clear:
        hits += usable - hopeful
        dropped = replace(dropped, overflow=dropped.overflow + hopeful - len(order))
    dropped = replace(dropped, hit=hits)
    scores = dict(zip(SCORES, np.asarray(found.scores)[number].tolist(), strict=True))
    choice = Choice(
        status="avoided" if clear else "hit",
        node=node,
        walk=played.walk,
        path_length=int(task.length[number]),
        part=int(task.part[number]),
        time_scale=scores.pop("s_time"),
        candidates=len(candidates.length) + candidates.overflow + culled,
        dropped=dropped,
        energy=Energy(**scores),
        clearance_m=played.clearance,
        clear_until=None if clear else played.clear_until,
        crop=crop,
    )
    return Settled(choice=choice, dropped=dropped)


def better_of(one: Settled, other: Settled) -> Settled:
    """The choice among all candidates of two sets: the one that avoids, or is touched least."""
    counts = {f.name: getattr(one.dropped, f.name) + getattr(other.dropped, f.name) for f in
              fields(Dropped)}  # fmt: skip
    choices = [x.choice for x in (one, other) if x.choice is not None]
    best = max(choices, key=_worth, default=None)
    return Settled(choice=best, dropped=Dropped(**counts))


def _worth(choice: Choice) -> tuple[bool, float]:
    return choice.status == "avoided", choice.clearance_m or 0.0


def _lanes(
    graph: MotionGraph, order: np.ndarray, task: Task, found: Found, config: AvoidanceConfig
) -> Iterator[tuple[int, int, Bounds]]:
    """Candidates in their order, each with its lane in the bounds of some."""
    _, device = search_tables(graph, config.body_rate, config.speed)
    for first in (0, *range(LANES, len(order), MORE_LANES)):
        some = order[first : first + MORE_LANES] if first else order[:LANES]
        bounds = found.bounds
        if first:
            rows = np.resize(some, MORE_LANES)  # repeats fill the lanes
            bounds = bound(
                device,
                task.edges[rows],
                np.asarray(found.scales)[rows],
                task.length[rows],
                task.flight,
                frame_rate=graph.frame_rate,
            )
        bounds = jax.tree.map(np.asarray, bounds)
        for lane, number in enumerate(some):
            yield int(number), lane, bounds


def _decide(
    graph: MotionGraph,
    attack: Attack,
    length: int,
    lane: int,
    bounds: Bounds,
    config: AvoidanceConfig,
) -> tuple[bool, Played]:
    """Whether a candidate stays clear, and what would be played."""
    until = attack.end + config.settle_s
    clearance = float(bounds.clearance[lane])
    if bounds.least[lane] >= CLEAR_M:
        walk = _walk(graph, bounds, lane, until)
        return True, Played(walk=walk, clearance=clearance, clear_until=None)
    if bounds.touched_from[lane] < bounds.path_end[lane]:
        walk = _walk(graph, bounds, lane, until)
        return False, Played(walk=walk, clearance=clearance, clear_until=None)
    edges, scales = (np.asarray(x[lane, :length]) for x in (bounds.edges, bounds.scales))
    played = play_on(graph, attack, make_walk(graph, edges, scales), config)
    if played.clearance < CLEAR_M or played.clear_until is not None:
        return False, played
    # Pieces were checked one by one; what counts is the motion as a whole.
    whole = clearance_between(graph, attack, played.walk, 0.0, attack.end)
    played = Played(walk=played.walk, clearance=whole, clear_until=None)
    return whole >= CLEAR_M + ROUNDING_M, played


def _walk(graph: MotionGraph, bounds: Bounds, lane: int, until: float) -> Walk:
    """A lane's walk, cut or extended to end after ``until`` s."""
    edges = np.asarray(bounds.edges[lane], dtype=np.int64)
    edges = edges[edges != NO_EDGE]
    scales = np.asarray(bounds.scales[lane, : len(edges)], dtype=np.float64)
    ends = np.cumsum(graph.edge_frames[edges] * scales) / graph.frame_rate
    path = int(np.searchsorted(ends, float(bounds.path_end[lane]) - 1e-4)) + 1
    needed = max(int(np.searchsorted(ends, until)) + 1, path)
    return extend(graph, Walk(edges=edges[:needed], scales=scales[:needed]), until)
