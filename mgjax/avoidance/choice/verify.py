"""From judged candidates to the choice: in their order, the first that is certainly clear."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.body.device_tables import search_tables
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.checks.bounds import MORE_LANES, Bounds
from mgjax.avoidance.checks.fast import clearance_between
from mgjax.avoidance.choice.continuation import Played, extend, play_on
from mgjax.avoidance.choice.results import Choice, Dropped, Energy
from mgjax.avoidance.choice.search import DEPTH, HOPELESS_M, SCORES, STATUS, Found, Task, bound
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import CLEAR_M
from mgjax.avoidance.timing.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE, PADDING
from mgjax.graph.types import NO_EDGE, MotionGraph
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

    The bounds of :mod:`mgjax.avoidance.checks.bounds` decide on most. Where they leave a doubt, or
    the path is clear and the longest edges after it are not, the poses of the written motion are
    looked at, and other edges are tried after the path.
    """
    judged = np.asarray(found.scores)
    fit = judged[STATUS] == OK
    counts = np.bincount(judged[STATUS].astype(np.int64), minlength=PADDING + 1).tolist()
    dropped = Dropped(
        culled=culled,
        not_adjustable=counts[NOT_ADJUSTABLE],
        time_scale=counts[OUT_OF_RANGE],
        overflow=candidates.overflow,
    )
    usable = counts[OK]
    if not usable:
        return Settled(choice=None, dropped=dropped)
    # Without hope for any the one that is touched least stands for all.
    hopeful = max(int(np.count_nonzero(fit & (judged[DEPTH] >= -HOPELESS_M))), 1)
    order = np.asarray(found.order)[: min(hopeful, config.checks)]
    clear, hits = False, 0
    best: tuple[int, Played] | None = None
    for lane in _lanes(graph, order, task, found, config):
        touched = lane.touched_from < lane.path_end
        if touched and best is not None and lane.clearance <= best[1].clearance:
            hits += 1
            continue
        clear, played = _decide(graph, attack, task, lane, config)
        if clear or best is None or played.clearance > best[1].clearance:
            best = (lane.number, played)
        if clear:
            break
        hits += 1
    assert best is not None
    number, played = best
    if not clear:
        hits += usable - hopeful
        dropped = replace(dropped, overflow=dropped.overflow + hopeful - len(order))
    dropped = replace(dropped, hit=hits)
    scores = dict(zip(SCORES, judged[:STATUS, number].tolist(), strict=True))
    choice = Choice(
        status="avoided" if clear else "hit",
        node=node,
        walk=played.walk,
        path_length=int(task.walks.length[number]),
        part=int(task.walks.part[number]),
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


class _Lane(NamedTuple):
    """A candidate with what follows it, and what is certain of it; see :class:`Bounds`."""

    number: int
    edges: Int[np.ndarray, " M"]
    scales: Float[np.ndarray, " M"]
    clearance: float
    least: float
    doubt_from: float
    touched_from: float
    path_end: float


def _lanes(
    graph: MotionGraph, order: np.ndarray, task: Task, found: Found, config: AvoidanceConfig
) -> Iterator[_Lane]:
    """Candidates in their order, each with its bounds."""
    known = found.bounds.figures.shape[0]
    yield from _bounded(order[:known], found.bounds)
    for first in range(known, len(order), MORE_LANES):
        some = order[first : first + MORE_LANES]
        rows = np.resize(some, MORE_LANES)  # repeats fill the lanes
        bounds = bound(
            search_tables(graph, config.body_rate, config.speed)[1],
            task.walks.rows(rows),
            np.asarray(found.scales)[:, rows],
            task.shots,
            frame_rate=graph.frame_rate,
        )
        yield from _bounded(some, bounds)


def _bounded(numbers: np.ndarray, bounds: Bounds) -> Iterator[_Lane]:
    edges, scales = np.asarray(bounds.edges), np.asarray(bounds.scales)
    figures = np.asarray(bounds.figures).tolist()
    for lane, number in enumerate(numbers.tolist()):
        yield _Lane(number, edges[lane], scales[lane], *figures[lane])


def _decide(
    graph: MotionGraph, attack: Attack, task: Task, lane: _Lane, config: AvoidanceConfig
) -> tuple[bool, Played]:
    """Whether a candidate stays clear, and what would be played."""
    walk = _walk(graph, lane, attack.end + config.settle_s)
    default = Played(walk=walk, clearance=lane.clearance, clear_until=None)
    if lane.least >= CLEAR_M:
        return True, default
    if lane.touched_from < lane.path_end:
        return False, default
    whole = clearance_between(graph, attack, walk, 0.0, attack.end)
    if whole >= CLEAR_M + ROUNDING_M:
        return True, Played(walk=walk, clearance=whole, clear_until=None)
    length = int(task.walks.length[lane.number])
    path = make_walk(graph, lane.edges[:length], lane.scales[:length])
    played = play_on(graph, attack, path, config)
    if played.clearance < CLEAR_M or played.clear_until is not None:
        return False, played
    # Pieces were checked one by one; what counts is the motion as a whole.
    whole = clearance_between(graph, attack, played.walk, 0.0, attack.end)
    played = Played(walk=played.walk, clearance=whole, clear_until=None)
    return whole >= CLEAR_M + ROUNDING_M, played


def _walk(graph: MotionGraph, lane: _Lane, until: float) -> Walk:
    """A lane's walk, cut or extended to end after ``until`` s."""
    edges = lane.edges[lane.edges != NO_EDGE].astype(np.int64)
    scales = lane.scales[: len(edges)].astype(np.float64)
    ends = np.cumsum(graph.edge_frames[edges] * scales)
    last = max(lane.path_end - 1e-4, until) * graph.frame_rate
    needed = int(ends.searchsorted(last)) + 1
    walk = Walk(edges=edges[:needed], scales=scales[:needed])
    return walk if needed <= len(edges) else extend(graph, walk, until)
