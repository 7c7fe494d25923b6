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

from mgjax.graph.prune import Candidates


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
    c = candidates
    stays = np.arange(len(c.leave)) < count
    if not most:
        return stays
    leave, arrive = c.leave[:count], c.arrive[:count] - window
    clip = np.searchsorted(c.starts, leave, side="right") - 1
    moment = (leave - c.starts[clip]) // second
    turn = _turn(clip, moment, _leads_to(c, arrive))
    order = np.argsort(turn, kind="stable")
    stays[order] = _turn(clip[order], moment[order]) < most
    return stays


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
