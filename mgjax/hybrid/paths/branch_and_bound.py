"""Depth-first branch and bound over the walks of a bounded horizon."""

from __future__ import annotations

import math
import time

import numpy as np

from mgjax.hybrid.paths.beam import better, limit_of
from mgjax.hybrid.paths.frontier import Frontier, Search, Terminal, concatenate

BATCH = 768
"""Partial walks that are taken from the top of the stack at once: all their macro edges are one
call, so that the search is as deep first as batches allow."""


def branch_and_bound(
    search: Search,
    begin: Frontier,
    *,
    horizon: int,
    best: Terminal | None = None,
    expansions: int,
    deadline: float = math.inf,
) -> tuple[Terminal | None, bool, bool]:
    """The best walk up to the horizon (eq. 6: g ≥ 0, so a walk that costs as much is cut).

    Args:
        search: graph, path and memory.
        begin: walks to start from.
        horizon: frames; a walk of so many is over.
        best: a walk to beat.
        expansions: most partial walks that are extended.
        deadline: in the time of ``time.perf_counter``.

    Returns:
        The best walk, or None if all stray; whether it is proven to be the best; and whether the
        time was over.
    """
    with_end = search.request.with_end
    most = search.expanded + expansions
    stack = [begin]
    while stack:
        if time.perf_counter() > deadline:
            return best, False, True
        if search.expanded >= most:
            return best, False, False
        top = _pop(stack)
        taken, limit = len(top.stop), limit_of(best, with_end)
        top = top.pick(top.cost < limit)
        if len(top.stop):
            top = top.pick(search.bounds(top, horizon) < limit)
        search.pruned += taken - len(top.stop)
        if not len(top.stop):
            continue
        children, complete, reached = search.expand(top, horizon, limit)
        for terminal in (complete, reached):
            best = better(best, terminal, with_end)
        if len(children.stop):
            # The cheapest on top of the stack.
            stack.append(children.pick(np.argsort(-children.cost, kind="stable")))
    return best, True, False


def _pop(stack: list[Frontier]) -> Frontier:
    """The walks on top of the stack, a batch of them."""
    taken: list[Frontier] = []
    room = BATCH
    while stack and room > 0:
        top = stack.pop()
        if len(top.stop) > room:
            stack.append(top.pick(slice(None, -room)))
            top = top.pick(slice(-room, None))
        taken.append(top)
        room -= len(top.stop)
    return concatenate(taken)
