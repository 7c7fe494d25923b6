"""Pieces of motion that are measured: seams of a graph, and uncut motion as long as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import planar
from mgjax.core.motion import Motion
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.quality.smoothness import WINDOW_S
from mgjax.quality.subject import subject_of


@dataclass(frozen=True, kw_only=True, eq=False)
class Pieces:
    """Motions of one skeleton.

    Attributes:
        motions: so many.
        spans_s: seconds between which frames count; None: all.
        rests: where toes and ankles rest, m; None: as low as they come in each.
    """

    motions: Sequence[Motion]
    spans_s: Sequence[tuple[float, float]] | None = None
    rests: Sequence[np.ndarray] | None = None

    def __len__(self) -> int:
        return len(self.motions)


def room(graph: MotionGraph) -> int:
    """Frames before and after a seam, so that all windows that touch it are whole."""
    return round(WINDOW_S * graph.frame_rate) + 2


def seam_edges(graph: MotionGraph, around: int) -> Int[np.ndarray, " M"]:
    """Transitions with so many frames of their clips before and after them."""
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    leave, arrive = _ends(graph, edges)
    first, second = _clips(graph, edges)
    ok = leave - around >= graph.clip_starts[first]
    ok &= leave + graph.window + around < graph.clip_stops[first]
    ok &= arrive - graph.window - around >= graph.clip_starts[second]
    return edges[ok & (arrive + around < graph.clip_stops[second])]


def seam_pieces(graph: MotionGraph, edges: Int[np.ndarray, " M"], around: int) -> Pieces:
    """Transitions as they are played, with so many frames of their clips before and after."""
    leave, arrive = _ends(graph, edges)
    before = leave[:, None] + np.arange(-around, 0)
    inside = graph.edge_starts[edges][:, None] + np.arange(graph.window)
    after = arrive[:, None] + np.arange(around + 1)
    plain = np.concatenate([before, inside], axis=1)
    later = graph.local_rotations[after].astype(np.float64)
    place, turn = planar.apply_pose(
        graph.edge_exit[edges][:, None].astype(np.float64),
        graph.root_translation[after].astype(np.float64),
        later[:, :, 0],
    )
    later[:, :, 0] = turn
    root = np.concatenate([graph.root_translation[plain], np.asarray(place)], axis=1)
    turns = np.concatenate([graph.local_rotations[plain], later], axis=1)
    rests = rests_of(graph)
    first, second = _clips(graph, edges)
    return Pieces(
        motions=[_motion(graph, *pose) for pose in zip(root, turns, strict=True)],
        spans_s=[_span(graph, around)] * len(edges),
        rests=list(np.maximum(rests[first], rests[second])),
    )


def uncut_pieces(graph: MotionGraph, edges: Int[np.ndarray, " M"], around: int) -> Pieces:
    """The two clips of each transition at the same places, played on: twice as many."""
    leave, arrive = _ends(graph, edges)
    starts = np.concatenate([leave, arrive - graph.window])
    frames = starts[:, None] + np.arange(-around, graph.window + around + 1)
    clip = np.searchsorted(graph.clip_starts, starts, side="right") - 1
    return Pieces(
        motions=[_frames(graph, row) for row in frames],
        spans_s=[_span(graph, around)] * len(starts),
        rests=list(rests_of(graph)[clip]),
    )


def random_pieces(graph: MotionGraph, seconds: Sequence[float], seed: int) -> list[Motion]:
    """Uncut motion of these lengths from anywhere in the clips that are long enough."""
    rng = np.random.default_rng(seed)
    lengths = graph.clip_stops - graph.clip_starts
    found: list[Motion] = []
    for wanted in seconds:
        count = min(round(wanted * graph.frame_rate), int(lengths.max()) - 1) + 1
        free = np.maximum(lengths - count + 1, 0)
        clip = rng.choice(len(free), p=free / free.sum())
        start = int(graph.clip_starts[clip] + rng.integers(free[clip]))
        found.append(_frames(graph, np.arange(start, start + count)))
    return found


def clip_motions(graph: MotionGraph) -> list[Motion]:
    """The clips of a graph, uncut."""
    spans = zip(graph.clip_starts, graph.clip_stops, strict=True)
    return [_frames(graph, np.arange(a, b)) for a, b in spans if b - a > 2]


def rests_of(graph: MotionGraph) -> Float[np.ndarray, "K 4"]:
    """The lowest 1 % of the heights of toes and ankles of each clip, m."""
    feet = np.asarray(subject_of(graph.skeleton)[0].feet)
    heights = graph.positions[:, feet, 1]
    spans = zip(graph.clip_starts, graph.clip_stops, strict=True)
    return np.stack([np.quantile(heights[a:b], 0.01, axis=0) for a, b in spans])


def _span(graph: MotionGraph, around: int) -> tuple[float, float]:
    """From the frame before a blend to that of arrival."""
    return (around - 1) / graph.frame_rate, (around + graph.window) / graph.frame_rate


def _frames(graph: MotionGraph, rows: np.ndarray) -> Motion:
    return _motion(graph, graph.root_translation[rows], graph.local_rotations[rows])


def _motion(graph: MotionGraph, root: np.ndarray, turns: np.ndarray) -> Motion:
    return Motion(
        root_translation=np.asarray(root, np.float32),
        local_rotations=np.asarray(turns, np.float32),
        frame_rate=graph.frame_rate,
    )


def _ends(graph: MotionGraph, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    nodes = graph.edge_source[edges], graph.edge_target[edges]
    return graph.node_frame[nodes[0]], graph.node_frame[nodes[1]]


def _clips(graph: MotionGraph, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    nodes = graph.edge_source[edges], graph.edge_target[edges]
    return graph.node_clip[nodes[0]], graph.node_clip[nodes[1]]
