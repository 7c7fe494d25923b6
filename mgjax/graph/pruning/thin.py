"""Which transitions a graph can do without.

Where clips resemble each other, minima of the distance come with the square of the clips' length.
Of those that leave one second of motion so many stay, so a graph grows with the length. They are
taken in turn from all places that they lead to, the nearest first: a body that has to react soon
needs ways to many parts rather than the smoothest ones to a few. Dropping the farthest alone lost
twice as many answers at the same size, and dropping what has a better neighbour within 0.2 s left
nearly all there.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Int

from mgjax.graph.pruning.prune import Candidates


def best_per_second(
    candidates: Candidates, count: int, window: int, *, most: int, second: int
) -> Bool[np.ndarray, " M"]:
    """Which of the first ``count`` candidates are among the best that leave their second of motion.

    The best of each place that is led to come first, then the second best of each, and so on, each
    time the nearest first. A place is a labelled part, the next to come after the arrival, or the
    rest of a clip without one. Seconds count from the start of a clip, so other clips shift none.

    Args:
        candidates: sorted by distance.
        count: the others do not stay.
        window: frames of a transition.
        most: so many stay for each second; 0: all.
        second: frames of a second.
    """
    stays = np.arange(len(candidates.leave)) < count
    if most:
        best = candidates.subset(stays)
        stays[:count] = turns(best, window, most=most, second=second)[1]
    return stays


def turns(
    candidates: Candidates, window: int, *, most: int, second: int
) -> tuple[Int[np.ndarray, " M"], Bool[np.ndarray, " M"]]:
    """How many nearer ones lead from a candidate's second to its place, and whether it stays.

    Args: those of :func:`best_per_second`; ``most`` is at least 1.
    """
    number = seconds_of(candidates, candidates.leave, second)[1]
    turn = _turn(number, _leads_to(candidates, candidates.arrive - window))
    order = np.argsort(turn, kind="stable")
    stays = np.zeros(len(turn), bool)
    stays[order] = _turn(number[order]) < most
    return turn, stays


def seconds_of(
    candidates: Candidates, frames: Int[np.ndarray, " N"], second: int
) -> tuple[int, Int[np.ndarray, " N"]]:
    """How many seconds all clips have, each counted from its start, and in which a frame lies."""
    starts, stops = candidates.starts, candidates.stops
    before = np.concatenate([[0], np.cumsum(-(-(stops - starts) // second))])
    clip = np.searchsorted(starts, frames, side="right") - 1
    return int(before[-1]), before[clip] + (frames - starts[clip]) // second


def _leads_to(c: Candidates, arrive: Int[np.ndarray, " M"]) -> Int[np.ndarray, " M"]:
    """Number of the next part of the clip; behind the last one a number of the clip's own."""
    clip = np.searchsorted(c.starts, arrive, side="right") - 1
    begins = np.sort(c.label_starts)
    part = np.searchsorted(begins, arrive)
    last = np.searchsorted(begins, c.stops[clip])  # parts that begin before the clip is over
    return np.where(part < last, part, len(begins) + clip)


def _turn(*key: Int[np.ndarray, " M"]) -> Int[np.ndarray, " M"]:
    """How many items before it have an item's key, which has several columns."""
    order = np.lexsort(key)  # stable: items of one key stay in their order
    changed = np.ones(len(order), bool)
    changed[1:] = np.any([np.diff(values[order]) != 0 for values in key], axis=0)
    first = np.flatnonzero(changed)
    turn = np.empty(len(order), np.int64)
    turn[order] = np.arange(len(order)) - np.repeat(first, np.diff(np.append(first, len(order))))
    return turn
