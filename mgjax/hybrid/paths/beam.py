"""The beam: of all partial walks of about the same duration only the best go on."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from mgjax.hybrid.paths.frontier import Frontier, Search, Terminal, concatenate

SHORTLIST = 8
"""The lower bound is computed of the cheapest walks so far, so many times the width."""


@dataclass(frozen=True, kw_only=True)
class Beam:
    """What a beam found.

    Attributes:
        best: the best complete walk, or the best at the horizon; None if there is neither.
        farthest: the partial walk that got farthest along the path, with its arc length.
        interrupted: the time was over before the beam was.
    """

    best: Terminal | None
    farthest: Terminal
    arc: float
    interrupted: bool


def better(one: Terminal | None, other: Terminal | None, with_end: bool) -> Terminal | None:
    """The better of two walks; to a given end a complete one beats one that is not."""
    if one is None or other is None:
        return one or other
    if with_end and one.complete != other.complete:
        return one if one.complete else other
    return one if one.cost <= other.cost else other


def limit_of(best: Terminal | None, with_end: bool) -> float:
    """Partial walks that cost as much cannot become better."""
    if best is None or (with_end and not best.complete):
        return math.inf
    return best.cost


def run_beam(
    search: Search, begin: Frontier, *, width: int, horizon: int, deadline: float = math.inf
) -> Beam:
    """Searches from the given walks on.

    Walks are sorted by their frames into slots of Δ. In each slot, from the first on, the ``width``
    best by cost and lower bound are extended by all their macro edges.

    Args:
        search: graph, path and memory.
        begin: where to start from; may be of different durations.
        width: of the beam.
        horizon: frames; a walk of so many is over.
        deadline: in the time of ``time.perf_counter``; checked once per slot.
    """
    delta, with_end = search.macro_edges.delta, search.request.with_end
    slots: dict[int, list[Frontier]] = {}
    _sort_in(slots, begin, delta)
    best: Terminal | None = None
    farthest, arc = _farthest(begin)
    interrupted = False
    while slots:
        if time.perf_counter() > deadline:
            interrupted = True
            break
        frontier = concatenate(slots.pop(min(slots)))
        if len(frontier.stop) > SHORTLIST * width:
            order = np.argpartition(frontier.cost, SHORTLIST * width)[: SHORTLIST * width]
            search.pruned += len(frontier.stop) - len(order)
            frontier = frontier.pick(order)
        keys = search.bounds(frontier, horizon)
        order = np.argsort(keys, kind="stable")[:width]
        order = order[keys[order] < limit_of(best, with_end)]
        search.pruned += len(keys) - len(order)
        if not len(order):
            continue
        children, complete, reached = search.expand(
            frontier.pick(order), horizon, limit_of(best, with_end), SHORTLIST * width
        )
        for terminal in (complete, reached):
            best = better(best, terminal, with_end)
        if len(children.stop):
            _sort_in(slots, children, delta)
            terminal, reach = _farthest(children)
            if reach > arc:
                farthest, arc = terminal, reach
    return Beam(best=best, farthest=farthest, arc=arc, interrupted=interrupted)


def _sort_in(slots: dict[int, list[Frontier]], frontier: Frontier, delta: int) -> None:
    number = frontier.frames // delta
    for slot in np.unique(number).tolist():
        slots.setdefault(slot, []).append(frontier.pick(number == slot))


def _farthest(frontier: Frontier) -> tuple[Terminal, float]:
    """The walk with most arc length; of those within 1 cm the cheapest."""
    arc = frontier.arc
    cost = np.where(arc > arc.max() - 0.01, frontier.cost, np.inf)
    i = int(np.argmin(cost))
    terminal = Terminal(float(cost[i]), int(frontier.record[i]), -1, int(frontier.frames[i]), False)
    return terminal, float(arc[i])
