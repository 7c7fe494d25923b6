"""Which candidates become the transitions of a graph.

Those below the threshold, among the best that leave their second of motion, and with both ends in
the largest strongly connected component.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from mgjax.graph.config import GraphConfig
from mgjax.graph.pruning.prune import Candidates, choose_threshold, largest_component
from mgjax.graph.pruning.thin import best_per_second


@dataclass(frozen=True, kw_only=True)
class Kept:
    """What is kept of the candidates.

    Attributes:
        threshold: for an adult, m.
        transitions: numbers of the candidates; none if no motion is left. [M]
        dropped: candidates below the threshold that ``best_per_s`` leaves out.
        lost: labels that the component would have with them.
    """

    threshold: float
    transitions: Int[np.ndarray, " M"]
    dropped: int
    lost: int


def keep(candidates: Candidates, largest: float, window: int, config: GraphConfig) -> Kept:
    """The threshold, and what is kept below it.

    Args:
        candidates: sorted by distance.
        largest: the largest distance of any pair of windows, m; for a normalised threshold.
        window: frames of a transition.
        config: of the graph.

    Raises:
        GraphError: the automatic threshold does not exist; says what can be reached.
    """
    threshold = _threshold(candidates, largest, config)
    count = int(np.searchsorted(candidates.distances, threshold, side="left"))
    stays = best_per_second(
        candidates,
        count,
        window,
        most=config.best_per_s,
        second=max(round(config.frame_rate), 1),
    )
    best = np.flatnonzero(stays)
    component = largest_component(candidates.subset(stays), len(best))
    dropped = count - len(best)
    lost = 0
    if dropped:
        lost = int(largest_component(candidates, count).labels.sum() - component.labels.sum())
    return Kept(
        threshold=float(threshold),
        transitions=best[component.kept] if component.frames else np.zeros(0, np.int64),
        dropped=dropped,
        lost=max(lost, 0),
    )


def _threshold(candidates: Candidates, largest: float, config: GraphConfig) -> float:
    if config.threshold_m is not None:
        return config.threshold_m
    if config.normalised is not None:
        return config.normalised * largest
    return choose_threshold(candidates, config.keep, config.max_threshold_m)
