"""Walks: sequences of edges, laid out in the world and played as one motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import planar, quaternion
from mgjax.core.errors import MotionError
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph


@dataclass(frozen=True, kw_only=True, eq=False)
class Walk:
    """Edges that follow one another, each with the factor by which its duration is stretched.

    Attributes:
        edges: [L].
        scales: duration of each edge divided by its natural one. [L]
    """

    edges: Int[np.ndarray, " L"]
    scales: Float[np.ndarray, " L"]

    def starts(self, graph: MotionGraph) -> Float[np.ndarray, " L1"]:
        """Seconds at which each edge begins, and at which the walk ends."""
        lasts = graph.edge_frames[self.edges] / graph.frame_rate * self.scales
        return np.concatenate([[0.0], np.cumsum(lasts)])


def make_walk(
    graph: MotionGraph, edges: Sequence[int] | np.ndarray, scales: Sequence[float] | np.ndarray | None = None
) -> Walk:
    """A walk from its edges; :class:`MotionError` if one does not begin where the last ends."""
    chosen = np.asarray(edges, dtype=np.int64)
    if not len(chosen):
        raise MotionError("got a walk without edges, expected at least one")
    broken = np.flatnonzero(graph.edge_target[chosen[:-1]] != graph.edge_source[chosen[1:]])
    if broken.size:
        i = int(broken[0])
        raise MotionError(f"got edge {chosen[i + 1]} after {chosen[i]}, expected one from its end")
    factors = np.ones(len(chosen)) if scales is None else np.asarray(scales, dtype=np.float64)
    return Walk(edges=chosen, scales=factors)


def place_edges(
    graph: MotionGraph, edges: np.ndarray, start: Float[np.ndarray, "3"] | None = None
) -> Float[np.ndarray, "L 3"]:
    """For each edge of a walk, the planar transform from its coordinates to the world.

    Args:
        graph: the graph.
        edges: the walk.
        start: planar frame of the body at the beginning; default: at the origin, heading +Z.
    """
    begin = np.zeros(3) if start is None else np.asarray(start, dtype=np.float64)
    first = graph.node_plane[graph.edge_source[edges[0]]].astype(np.float64)
    transform = planar.compose(begin, planar.inverse(first))
    places = []
    for edge in edges:
        places.append(transform)
        transform = planar.compose(transform, graph.edge_exit[edge].astype(np.float64))
    return np.array(places)


def sample_walk(
    graph: MotionGraph,
    walk: Walk,
    times: Float[np.ndarray, " T"],
    *,
    start: Float[np.ndarray, "3"] | None = None,
) -> Motion:
    """Poses of a walk at the given seconds, as a motion at the rate of the first two times.

    Between frames the root is interpolated linearly and rotations by slerp, also over a seam:
    each edge's last stretch leads to the pose at which the next begins. Times before the beginning
    and after the end give the first and the last pose.
    """
    begins = walk.starts(graph)
    where = np.clip(np.asarray(times, dtype=np.float64), 0.0, begins[-1])
    index = np.clip(np.searchsorted(begins, where, side="right") - 1, 0, len(walk.edges) - 1)
    edges = walk.edges[index]
    local = (where - begins[index]) / walk.scales[index] * graph.frame_rate
    local = np.clip(local, 0.0, graph.edge_frames[edges])
    step = np.minimum(np.floor(local).astype(np.int64), graph.edge_frames[edges] - 1)
    low = graph.edge_starts[edges] + step
    share = (local - step)[:, None]
    root = graph.root_translation[low] * (1 - share) + graph.root_translation[low + 1] * share
    turns = graph.local_rotations
    rotations = quaternion.slerp(
        turns[low].astype(np.float64), turns[low + 1].astype(np.float64), share
    )
    placed = place_edges(graph, walk.edges, start)[index]
    root, first = planar.apply_pose(placed, root.astype(np.float64), rotations[:, 0])
    rotations = np.concatenate([np.asarray(first)[:, None], np.asarray(rotations)[:, 1:]], axis=1)
    rate = 1 / (times[1] - times[0]) if len(times) > 1 else graph.frame_rate
    return Motion(
        root_translation=np.asarray(root, dtype=np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=float(rate),
    )


def unroll(
    graph: MotionGraph,
    edges: Sequence[int] | np.ndarray,
    *,
    start: Float[np.ndarray, "3"] | None = None,
) -> Motion:
    """The motion of a walk at the graph's rate, from its first frame to the pose it arrives at."""
    walk = make_walk(graph, edges)
    count = int(graph.edge_frames[walk.edges].sum()) + 1
    return sample_walk(graph, walk, np.arange(count) / graph.frame_rate, start=start)
