"""What is left of a graph when dead ends are cut off, and at which threshold.

The strongly connected components come from scipy: at some thousand nodes they take a millisecond,
and the automatic threshold asks for a few hundred of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from mgjax.core.errors import GraphError

STEP_M = 0.001
"""The automatic threshold is looked for in steps of this, and then exactly within the step."""


@dataclass(frozen=True, kw_only=True)
class Candidates:
    """All transitions that the labels allow, on the flat axis of frames, sorted by distance.

    Attributes:
        leave, arrive: frame at which a transition leaves, and at which it arrives. [M]
        distances: m. [M]
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


@dataclass(frozen=True, kw_only=True)
class Component:
    """The strongly connected component that holds most motion.

    Attributes:
        count: transitions with a distance below the threshold.
        kept: which of them have both ends in the component. [count]
        labels: which labels lie in it. [P]
        frames: frames of clips in it.
    """

    count: int
    kept: Bool[np.ndarray, " M"]
    labels: Bool[np.ndarray, " P"]
    frames: int


def largest_component(candidates: Candidates, count: int) -> Component:
    """The largest strongly connected component of the first ``count`` transitions.

    Largest by frames of clips, not by nodes: nodes crowd where clips resemble each other, so their
    number says little about how much motion is left.
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
    weight = np.bincount(part[:-1][inside], (nodes[1:] - nodes[:-1])[inside], minlength=1)
    best = int(np.argmax(weight))
    kept = (part[np.searchsorted(nodes, from_node)] == best) & (
        part[np.searchsorted(nodes, to_node)] == best
    )
    label_clip = np.searchsorted(c.starts, c.label_starts, side="right") - 1
    before = np.searchsorted(nodes, c.label_starts + label_clip, side="right") - 1
    after = np.searchsorted(nodes, c.label_stops + label_clip, side="left")
    labels = (part[before] == best) & (part[np.minimum(after, len(nodes) - 1)] == best)
    return Component(
        count=count,
        kept=kept,
        labels=labels,
        frames=int(weight[best]),
    )


def _clip_of_arrival(c: Candidates, arrive: np.ndarray) -> np.ndarray:
    """A transition arrives after its window, so the frame before lies in the same clip."""
    return np.searchsorted(c.starts, arrive - 1, side="right") - 1


def choose_threshold(candidates: Candidates, keep: float, max_threshold: float) -> float:
    """The smallest threshold at which ``keep`` of the labels stay; without labels, of the frames.

    Raises:
        GraphError: ``max_threshold`` does not do; names the best share that can be reached.
    """
    c = candidates

    def share(threshold: float) -> float:
        count = int(np.searchsorted(c.distances, threshold, side="left"))
        component = largest_component(c, count)
        if len(c.label_starts):
            return float(component.labels.mean())
        return component.frames / max(int((c.stops - c.starts).sum()), 1)

    def enough(value: float) -> bool:
        return value >= keep - 1e-9 and value > 0

    steps = np.arange(1, round(max_threshold / STEP_M) + 1) * STEP_M
    best = (0.0, 0.0)
    below = 0.0
    for threshold in steps:
        value = share(float(threshold))
        if value > best[0]:
            best = (value, float(threshold))
        if enough(value):
            inside = c.distances[(c.distances >= below) & (c.distances < threshold)]
            for exact in np.nextafter(inside, np.inf):
                if enough(share(float(exact))):
                    return float(exact)
            return float(threshold)
        below = float(threshold)
    what = f"{len(c.label_starts)} labels" if len(c.label_starts) else "the motion"
    raise GraphError(
        f"got {best[0]:.0%} of {what} kept at most (at {best[1]:.3f} m) with thresholds up to"
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
