"""The best transitions of each second of motion while the search for them goes on.

Clips that resemble each other have minima of the distance with the square of their length, far
more than stay (:mod:`mgjax.graph.pruning.thin`). Two things hold whatever the rest of the search
finds. What is not among the best of some of the minima is not among the best of all. And once a
second leads to as many places as transitions stay, only what is nearer than the farthest of their
nearest can still be one. So memory goes with the length of the clips, and pairs of windows above
such a limit need not be compared.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from mgjax.graph.pruning.candidates import Conditions
from mgjax.graph.pruning.prune import Candidates
from mgjax.graph.pruning.thin import seconds_of, turns

_FEW = 1 << 15
"""So many minima are looked through at once, or half as many as are kept."""

MANY = 40_000
"""Frames from which a build leaves out what cannot stay; of fewer it counts all that there is."""


def best_of_seconds(conditions: Conditions, limit: float) -> BestOfSeconds | None:
    """For the search of a build below a limit, m²; None where it needs all minima: where they are
    few, where all stay, and where the threshold follows from them."""
    config, frames = conditions.config, len(conditions.timeline.root)
    given = config.threshold_m is not None and config.best_per_s and not config.range_frames
    return BestOfSeconds(conditions, limit) if given and frames >= MANY else None


class BestOfSeconds:
    """Keeps what :func:`mgjax.graph.pruning.thin.best_per_second` keeps of all.

    Args:
        conditions: of candidates; their threshold is given, and ``best_per_s`` is not 0.
        limit: of the search, m².
    """

    def __init__(self, conditions: Conditions, limit: float) -> None:
        config = conditions.config
        self._conditions, self._limit = conditions, float(limit)
        self._most, self._second = config.best_per_s, max(round(config.frame_rate), 1)
        self._limits = np.full(len(conditions.timeline.root), self._limit)
        none = np.zeros(0, np.int64)
        self._best = none, none, np.zeros(0)
        self._waiting: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def limits(self) -> Float[np.ndarray, " F"]:
        """What a further minimum has to be below by the frame that its row begins at, m²."""
        return self._limits

    def add(
        self,
        rows: Int[np.ndarray, " M"],
        columns: Int[np.ndarray, " M"],
        squared: Float[np.ndarray, " M"],
    ) -> None:
        """Further minima: frames that their windows begin at, and D², m². One that is known
        already changes nothing."""
        wanted = squared <= self._limits[rows]
        self._waiting.append((rows[wanted], columns[wanted], squared[wanted]))
        if sum(len(each[0]) for each in self._waiting) >= max(_FEW, len(self._best[0]) // 2):
            self._thin()

    def kept(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Those of all that stay, likewise, sorted by distance."""
        self._thin()
        return self._best

    def _thin(self) -> None:
        every = [np.concatenate(each) for each in zip(self._best, *self._waiting, strict=True)]
        self._waiting = []
        rows, columns, squared = every
        order = np.lexsort((columns, rows, squared))
        rows, columns, squared = (each[order] for each in every)
        known = np.zeros(len(rows), bool)
        known[1:] = (np.diff(rows) == 0) & (np.diff(columns) == 0)
        rows, columns, squared = (each[~known] for each in (rows, columns, squared))
        candidates, chosen = self._conditions.candidates(rows, columns, np.sqrt(squared))
        rows, columns, squared = (each[chosen] for each in (rows, columns, squared))
        threshold = self._conditions.config.threshold_m
        candidates = candidates.subset(candidates.distances < threshold)
        count = len(candidates.leave)  # sorted, so what is below the threshold comes first
        window = self._conditions.window
        turn, stays = turns(candidates, window, most=self._most, second=self._second)
        rows, columns, squared = (each[:count] for each in (rows, columns, squared))
        self._best = rows[stays], columns[stays], squared[stays]
        self._lower(candidates.subset(stays), turn[stays])

    def _lower(self, best: Candidates, turn: np.ndarray) -> None:
        """Limits by what is kept, where each of as many as stay leads to another place."""
        first, number = seconds_of(best, np.arange(len(self._limits)), self._second)
        second = number[best.leave]
        count = np.bincount(second, minlength=first)
        again = np.bincount(second, turn > 0, minlength=first)
        farthest = np.zeros(first)
        np.maximum.at(farthest, second, self._best[2])
        full = (count == self._most) & (again == 0)
        self._limits = np.where(full, farthest, self._limit)[number]
