"""What is left of a graph when dead ends are cut off, and at which threshold.

The strongly connected components come from scipy: at some thousand nodes they take a millisecond,
and the automatic threshold asks for a few hundred of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from mgjax.core.errors import GraphError

SAMPLES = 200
"""Thresholds that are tried to say what can be reached where the automatic threshold fails."""


@dataclass(frozen=True, kw_only=True)
class Candidates:
    """All transitions that the labels allow, on the flat axis of frames, sorted by distance.

    Attributes:
        leave, arrive: frame at which a transition leaves, and at which it arrives. [M]
        distances: of an adult: divided by the scale of the body, as thresholds are given, m. [M]
        starts, stops: frames of the clips. [K]
        label_starts, label_stops: frames of the labels. [P]
    """

    leave: Int[np.ndarray, " M"]
    arrive: Int[np.ndarray, " M"]
    distances: Float[np.ndarray, " M"]
    starts: Int[np.ndarray, " K"]
    stops: Int[np.ndarray, " K"]
    label_starts: Int[np.ndarray, " P"]
    label_stops: Int[np.ndarray, " P"]

    def subset(self, stays: Bool[np.ndarray, " M"]) -> Candidates:
        """Some of them."""
        return replace(
            self,
            leave=self.leave[stays],
            arrive=self.arrive[stays],
            distances=self.distances[stays],
        )


@dataclass(frozen=True, kw_only=True)
class Component:
    """The strongly connected component that holds most motion.

    Attributes:
        count: transitions with a distance below the threshold.
        kept: which of them have both ends in the component. [count]
        labels: which labels lie in it. [P]
        frames: frames of clips in it.
        most_labels: labels in whichever component has most of them.
    """

    count: int
    kept: Bool[np.ndarray, " M"]
    labels: Bool[np.ndarray, " P"]
    frames: int
    most_labels: int


def largest_component(candidates: Candidates, count: int) -> Component:
    """The largest strongly connected component of the first ``count`` transitions.

    Largest by frames of clips, not by nodes: nodes crowd where clips resemble each other, so their
    number says little about how much motion is left. Of two as large, that with more labels.
    """
    c = candidates
    leave, arrive = c.leave[:count], c.arrive[:count]
    # A node at the end of a clip has the clip's stop as its frame, which may be the start of the
    # next clip: shift clip k by k, so that every end has a number of its own.
    clip = np.arange(len(c.starts))
    ends = np.concatenate([c.starts + clip, c.stops + clip])
    shift = np.searchsorted(c.starts, leave, side="right") - 1
    from_node = leave + shift
    to_node = arrive + _clip_of_arrival(c, arrive)
    nodes = np.unique(np.concatenate([ends, from_node, to_node]))
    owner = np.searchsorted(c.stops + clip, nodes, side="left")
    same = owner[1:] == owner[:-1]
    position = np.arange(len(nodes))
    source = np.concatenate([position[:-1][same], np.searchsorted(nodes, from_node)])
    target = np.concatenate([position[1:][same], np.searchsorted(nodes, to_node)])
    ones = np.ones(len(source), dtype=np.int8)
    size = (len(nodes), len(nodes))
    _, part = connected_components(
        csr_array((ones, (source, target)), shape=size), directed=True, connection="strong"
    )
    inside = same & (part[1:] == part[:-1])
    weight = np.bincount(part[:-1][inside], (nodes[1:] - nodes[:-1])[inside], minlength=len(nodes))
    label_clip = np.searchsorted(c.starts, c.label_starts, side="right") - 1
    before = np.searchsorted(nodes, c.label_starts + label_clip, side="right") - 1
    after = np.searchsorted(nodes, c.label_stops + label_clip, side="left")
    home, end = part[before], part[np.minimum(after, len(nodes) - 1)]
    held = np.bincount(home[home == end], minlength=len(weight))
    best = int(np.lexsort((held, weight))[-1])
    kept = (part[np.searchsorted(nodes, from_node)] == best) & (
        part[np.searchsorted(nodes, to_node)] == best
    )
    return Component(
        count=count,
        kept=kept,
        labels=(home == best) & (end == best),
        frames=int(weight[best]),
        most_labels=int(held.max()),
    )


def _clip_of_arrival(c: Candidates, arrive: np.ndarray) -> np.ndarray:
    """A transition arrives after its window, so the frame before lies in the same clip."""
    return np.searchsorted(c.starts, arrive - 1, side="right") - 1


def choose_threshold(candidates: Candidates, keep: float, max_threshold: float) -> float:
    """The smallest threshold at which ``keep`` of the labels stay.

    Without labels it is the smallest that keeps that share of the frames which ``max_threshold``
    keeps.

    With a higher threshold components only grow, but the largest may become another one, with fewer
    labels. So bisection alone would not do: it is used only where nothing can change in between.

    Raises:
        GraphError: ``max_threshold`` does not do; names the best share that can be reached.
    """
    c = candidates
    thresholds = np.nextafter(np.unique(c.distances), np.inf)
    thresholds = thresholds[thresholds <= max_threshold]

    @cache
    def component(i: int) -> Component:
        return largest_component(c, int(np.searchsorted(c.distances, thresholds[i], side="left")))

    def value(i: int) -> int:
        return int(component(i).labels.sum()) if len(c.label_starts) else component(i).frames

    last = len(thresholds) - 1
    total = len(c.label_starts) or (component(last).frames if last >= 0 else 0)

    def enough(count: int) -> bool:
        return count >= keep * total - 1e-9 and count > 0

    def first_enough(low: int, high: int) -> int | None:
        """The first that is enough after ``low``, which is not, and up to ``high``."""
        reached = component(high)
        if not enough(value(high)):
            bound = reached.most_labels if len(c.label_starts) else reached.frames
            same = low >= 0 and component(low).frames == reached.frames
            if same or not enough(bound):
                return None
        if high - low == 1:
            return high if enough(value(high)) else None
        middle = (low + high) // 2
        place = first_enough(low, middle)
        return first_enough(middle, high) if place is None else place

    place = first_enough(-1, last) if last >= 0 else None
    if place is not None:
        return float(thresholds[place])
    tried = np.unique(np.linspace(0, last, min(last + 1, SAMPLES)).round().astype(int))
    best = max(tried.tolist(), key=value, default=None)
    reached = "none" if best is None else f"{value(best)}"
    at = "" if best is None else f" (at {thresholds[best]:.4f} m)"
    what = "labels" if len(c.label_starts) else "frames"
    raise GraphError(
        f"got {reached} of {total} {what} kept at most{at} with thresholds up to"
        f" {max_threshold:g} m, expected {keep:.0%}; lower keep, raise max_threshold_m or add clips"
    )


def smallest_useful_threshold(candidates: Candidates) -> float | None:
    """The smallest threshold that leaves anything at all, or None."""
    low, high = 0, len(candidates.distances)
    if high == 0 or not largest_component(candidates, high).frames:
        return None
    while low < high:  # more transitions never make a component smaller
        middle = (low + high) // 2
        if largest_component(candidates, middle).frames:
            high = middle
        else:
            low = middle + 1
    return float(np.nextafter(candidates.distances[low - 1], np.inf))
