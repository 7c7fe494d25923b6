"""Walks: sequences of edges, laid out in the world and played as one motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import planar, quaternion
from mgjax.core.errors import MotionError
from mgjax.core.motion import Motion
from mgjax.core.shown import Shown, made_of
from mgjax.graph.types import MotionGraph


@dataclass(frozen=True, kw_only=True, eq=False)
class Walk(Shown):
    """Edges that follow one another, each with the factor by which its duration is stretched.

    Attributes:
        edges: [L].
        scales: duration of each edge divided by its natural one. [L]
    """

    edges: Int[np.ndarray, " L"]
    scales: Float[np.ndarray, " L"]

    def starts(self, graph: MotionGraph) -> Float[np.ndarray, " L1"]:
        """Seconds at which each edge begins, and at which the walk ends."""
        durations = graph.edge_frames[self.edges] / graph.frame_rate * self.scales
        return np.concatenate([[0.0], np.cumsum(durations)])


def make_walk(
    graph: MotionGraph,
    edges: Sequence[int] | np.ndarray,
    scales: Sequence[float] | np.ndarray | None = None,
) -> Walk:
    """A walk from its edges; :class:`MotionError` if one does not begin where the last ends."""
    chosen = np.asarray(edges, dtype=np.int64)
    if not len(chosen):
        raise MotionError("got a walk without edges, expected at least one")
    unknown = chosen[(chosen < 0) | (chosen >= graph.num_edges)]
    if unknown.size:
        raise MotionError(f"got edge {unknown[0]}, expected one of 0 … {graph.num_edges - 1}")
    broken = np.flatnonzero(graph.edge_target[chosen[:-1]] != graph.edge_source[chosen[1:]])
    if broken.size:
        i = int(broken[0])
        raise MotionError(f"got edge {chosen[i + 1]} after {chosen[i]}, expected one from its end")
    factors = np.ones(len(chosen)) if scales is None else np.asarray(scales, dtype=np.float64)
    if factors.shape != chosen.shape or not ((factors > 0) & (factors < np.inf)).all():
        raise MotionError(
            f"got scales {factors.tolist()!s:.80}, expected {len(chosen)} numbers above 0"
        )
    return made_of(Walk(edges=chosen, scales=factors), graph)


def random_walk(graph: MotionGraph, node: int, seconds: float, seed: int) -> Walk:
    """Edges drawn at random from a node on, until they last so long.

    Raises:
        MotionError: there is no such node.
    """
    if not 0 <= node < graph.num_nodes:
        raise MotionError(got=f"node {node}", expected=f"0 … {graph.num_nodes - 1}")
    rng = np.random.default_rng(seed)
    edges = [int(rng.choice(graph.edges_from(node)))]
    end = graph.edge_frames[edges[0]] / graph.frame_rate
    while end < seconds:
        edges.append(int(rng.choice(graph.edges_from(int(graph.edge_target[edges[-1]])))))
        end += graph.edge_frames[edges[-1]] / graph.frame_rate
    return make_walk(graph, edges)


def extend(graph: MotionGraph, walk: Walk, until: float) -> Walk:
    """The walk with first out-edges appended until it lasts ``until`` seconds."""
    edges, scales = list(walk.edges), list(walk.scales)
    end = float(walk.starts(graph)[-1])
    while end < until:
        edge = int(graph.edges_from(int(graph.edge_target[edges[-1]]))[0])
        edges.append(edge)
        scales.append(1.0)
        end += graph.edge_frames[edge] / graph.frame_rate
    return made_of(Walk(edges=np.array(edges), scales=np.array(scales)), graph)


def place_edges(
    graph: MotionGraph, edges: np.ndarray, start: Float[np.ndarray, "3"] | None = None
) -> Float[np.ndarray, "L 3"]:
    """For each edge of a walk, the planar transform from its coordinates to the world.

    Args:
        graph: the graph.
        edges: the walk.
        start: planar frame of the body at the beginning; default: at the origin, heading +Z.
    """
    # Plain numbers: a walk has a dozen edges, and the search lays out many walks.
    turn, x, z = graph.node_plane[graph.edge_source[edges[0]]].tolist()
    c, s = math.cos(turn), math.sin(turn)
    here = [-turn, z * s - x * c, -x * s - z * c]
    if start is not None:
        here = _composed([float(v) for v in start], *here)
    places: list[list[float]] = []
    for exit_ in graph.edge_exit[edges].tolist():
        places.append(here)
        here = _composed(here, *exit_)
    return np.array(places)


def _composed(outer: list[float], turn: float, x: float, z: float) -> list[float]:
    """:func:`mgjax.core.planar.compose` of plain numbers."""
    c, s = math.cos(outer[0]), math.sin(outer[0])
    return [outer[0] + turn, x * c + z * s + outer[1], z * c - x * s + outer[2]]


@dataclass(frozen=True, kw_only=True, eq=False)
class WalkFrames:
    """The two frames of a graph that each of some poses of a walk lies between.

    Attributes:
        low, high: the frames. [T]
        edge_low, edge_high: which edges of the walk play them, counted from 0. [T]
        share: how far from ``low`` to ``high``, 0 … 1. [T]
    """

    low: Int[np.ndarray, " T"]
    high: Int[np.ndarray, " T"]
    edge_low: Int[np.ndarray, " T"]
    edge_high: Int[np.ndarray, " T"]
    share: Float[np.ndarray, " T"]


def frames_at(graph: MotionGraph, walk: Walk, times: Float[np.ndarray, " T"]) -> WalkFrames:
    """The frames that a walk plays at the given seconds, also over a seam.

    The pose after the last one that an edge plays is the first of the next edge. Times before the
    beginning and after the end give the first and the last pose.
    """
    begins = walk.starts(graph)
    within = np.minimum(np.maximum(np.asarray(times, dtype=np.float64), 0.0), begins[-1])
    index = np.minimum(begins.searchsorted(within, side="right") - 1, len(walk.edges) - 1)
    edges = walk.edges[index]
    counts = graph.edge_frames[edges]
    local = (within - begins[index]) / walk.scales[index] * graph.frame_rate
    local = np.minimum(np.maximum(local, 0.0), counts)
    step = np.minimum(local.astype(np.int64), counts - 1)
    crosses = (step == counts - 1) & (index + 1 < len(walk.edges))
    after = np.minimum(index + crosses, len(walk.edges) - 1)
    low = graph.edge_starts[edges] + step
    return WalkFrames(
        low=low,
        high=np.where(crosses, graph.edge_starts[walk.edges[after]], low + 1),
        edge_low=index,
        edge_high=after,
        share=local - step,
    )


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
    played = frames_at(graph, walk, times)
    share = played.share[:, None]
    placed = place_edges(graph, walk.edges, start)

    def pose(frames: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rotations = graph.local_rotations[frames].astype(np.float64)
        root, turn = planar.apply_pose(
            place, graph.root_translation[frames].astype(np.float64), rotations[:, 0]
        )
        rotations[:, 0] = turn
        return np.asarray(root), rotations

    root_low, turns_low = pose(played.low, placed[played.edge_low])
    root_high, turns_high = pose(played.high, placed[played.edge_high])
    root = root_low * (1 - share) + root_high * share
    rotations = np.asarray(quaternion.slerp(turns_low, turns_high, share))
    rate = 1 / (times[1] - times[0]) if len(times) > 1 else graph.frame_rate
    motion = Motion(
        root_translation=np.asarray(root, dtype=np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=float(rate),
    )
    return made_of(motion, graph.skeleton)


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
