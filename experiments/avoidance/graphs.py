"""Graphs for the experiments: given, built from clips, or that of the embedded clips."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from mgjax.clips.folder import load_clips
from mgjax.clips.labels import load_labels
from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip, Label
from mgjax.core import planar
from mgjax.core.kinematics import forward
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.files import load_graph
from mgjax.graph.types import NO_CLIP, MotionGraph

EMBEDDED_M = 0.05
"""Threshold for the embedded clips: at the automatic one an avoidance part is hardly ever near."""


@lru_cache(maxsize=2)
def clips_of(folder: str, exclude: tuple[str, ...]) -> tuple[list[Clip], Mapping[str, tuple]]:
    """The clips below a folder with the labels of its ``labels.json``; "" means the embedded."""
    labels: Mapping[str, tuple[Label, ...]]
    if not folder:
        return synthetic_clips()
    clips, _ = load_clips(folder, exclude=exclude)
    labels = load_labels(Path(folder) / "labels.json", clips, folder)
    return clips, labels


@lru_cache(maxsize=4)
def built(
    clips: str = "",
    exclude: tuple[str, ...] = (),
    *,
    threshold_m: float | None = EMBEDDED_M,
    mirror: bool = False,
) -> MotionGraph:
    """The graph of a folder of clips, "" for the embedded ones; built once in a process.

    Without a threshold at the automatic one.
    """
    named, labels = clips_of(clips, exclude)
    config = GraphConfig(threshold_m=threshold_m, mirror=mirror)
    return build_graph(named, labels=labels, config=config)


def graph_of(
    path: str | Path | None, clips: str = "", exclude: tuple[str, ...] = ()
) -> MotionGraph:
    """The graph of a folder of clips at the automatic threshold, or the one in a folder.

    Without either that of the embedded clips.
    """
    if clips:
        return built(clips, exclude, threshold_m=None)
    return load_graph(path) if path else built()


def with_parts(graph: MotionGraph, wanted: np.ndarray) -> MotionGraph:
    """The same graph with some of its labelled parts, chosen by a mask or by their numbers."""
    kept = np.arange(len(graph.label_edge))[wanted]
    return replace(
        graph,
        label_edge=graph.label_edge[kept],
        label_starts=graph.label_starts[kept],
        label_stops=graph.label_stops[kept],
        label_kind=tuple(graph.label_kind[i] for i in kept),
        label_direction=tuple(graph.label_direction[i] for i in kept),
        label_genuine=graph.label_genuine[kept],
    )


def speed_changes(graph: MotionGraph) -> tuple[np.ndarray, np.ndarray]:
    """How abruptly joints change their velocity, m/s from one frame interval to the next.

    Returns:
        For each transition the largest change of any joint, from the frame before it to the frame
        after it, both seams included; and for each captured frame with two neighbours the largest
        change there, to compare with.
    """
    positions, _ = forward(graph.skeleton, graph.root_translation, graph.local_rotations)
    places = np.asarray(positions, dtype=np.float64)
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    leave, arrive = (
        graph.node_frame[nodes[edges]] for nodes in (graph.edge_source, graph.edge_target)
    )
    inside = graph.edge_starts[edges, None] + np.arange(1 + int(graph.edge_frames[edges].max()))
    # A clip's last frame has none after it: the pose at which the edge arrives stands still there.
    last = np.isin(arrive + 1, graph.clip_stops)
    after = np.asarray(
        planar.apply(graph.edge_exit[edges, None].astype(np.float64), places[arrive + ~last])
    )
    before = places[np.maximum(leave - 1, 0)]
    track = np.concatenate([before[:, None], places[inside], after[:, None]], axis=1)
    change = _changes(np.moveaxis(track, 1, 0), graph.frame_rate)
    change[-1, last] = 0.0
    captured = [
        _changes(places[a:b], graph.frame_rate).ravel()
        for a, b in zip(graph.clip_starts, graph.clip_stops, strict=True)
        if b - a > 2
    ]
    return change.max(axis=0), np.concatenate(captured)


def _changes(track: np.ndarray, rate: float) -> np.ndarray:
    """Largest change of velocity of any joint, m/s; [T, …, J, 3] → [T − 2, …]."""
    return np.linalg.norm(np.diff(track, n=2, axis=0), axis=-1).max(axis=-1) * rate
