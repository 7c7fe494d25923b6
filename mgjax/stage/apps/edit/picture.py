"""The graph as arrays for a picture: clips as rows, transitions as arcs between them."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Int

from mgjax.clips.types import Labels
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import NO_CLIP, MotionGraph


def graph_picture(graph: MotionGraph, labels: Labels) -> dict[str, Any]:
    """What the page draws of a graph.

    Args:
        graph: the graph.
        labels: those it was asked to hold, by clip; the ones that are not in it are drawn empty.
            They are placed by the clip's own seconds, so those of a clip that was split where it
            jumps are left out.

    Returns:
        ``rate``; ``clips`` with ``name``, ``frames`` and the frames ``from`` and ``to`` between
        which it belongs to the graph (both 0: nothing does); ``transitions`` as arrays [M]:
        ``edge``, ``from_clip``, ``from_frame`` (where it leaves), ``to_clip``, ``to_frame`` (where
        it arrives), both counted from the beginning of their clips, and ``distance`` in m;
        ``labels`` with ``clip``, ``start`` and ``stop`` (frames of the clip), ``kind``,
        ``direction``, ``genuine``, ``kept`` and ``enterable``.
    """
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    leave, arrive = graph.edge_source[edges], graph.edge_target[edges]
    frame = graph.node_frame - graph.clip_starts[graph.node_clip]
    spans = kept_spans(graph)
    return {
        "rate": graph.frame_rate,
        "clips": [
            {"name": name, "frames": int(frames), "from": int(a), "to": int(b)}
            for name, frames, (a, b) in zip(
                graph.clip_names, graph.clip_stops - graph.clip_starts, spans, strict=True
            )
        ],
        "transitions": {
            "edge": edges.astype(np.int32),
            "from_clip": graph.node_clip[leave].astype(np.int32),
            "from_frame": frame[leave].astype(np.int32),
            "to_clip": graph.node_clip[arrive].astype(np.int32),
            "to_frame": frame[arrive].astype(np.int32),
            "distance": graph.edge_distance[edges].astype(np.float32),
        },
        "labels": _kept(graph) + _lost(graph, labels),
    }


def kept_spans(graph: MotionGraph) -> Int[np.ndarray, "K 2"]:
    """First and last frame of each clip that belongs to the graph; what lies outside was pruned."""
    spans = np.zeros((len(graph.clip_names), 2), dtype=np.int64)
    for clip in range(len(spans)):
        frames = graph.node_frame[graph.node_clip == clip] - graph.clip_starts[clip]
        if len(frames):
            spans[clip] = frames.min(), frames.max()
    return spans


def whole_labels(graph: MotionGraph) -> Int[np.ndarray, "P 2"]:
    """Frames of the labels that a graph holds, with what blends overlap of them."""
    own = np.stack([graph.label_starts, graph.label_stops], axis=1)
    return np.asarray(graph.report.get("label_frames", own), dtype=np.int64).reshape(-1, 2)


def _kept(graph: MotionGraph) -> list[dict[str, Any]]:
    horizon = GraphConfig().horizon_s * graph.frame_rate
    found: list[dict[str, Any]] = []
    whole = whole_labels(graph).tolist()
    for part, (edge, (start, stop)) in enumerate(zip(graph.label_edge, whole, strict=True)):
        clip = int(graph.edge_clip[edge])
        first = int(graph.clip_starts[clip])
        found.append(
            {
                "clip": clip,
                "start": start - first,
                "stop": stop - first,
                "kind": graph.label_kind[part],
                "direction": graph.label_direction[part],
                "genuine": bool(graph.label_genuine[part]),
                "kept": True,
                "enterable": (start + stop) / 2 - int(graph.edge_starts[edge]) <= horizon,
            }
        )
    return found


def _lost(graph: MotionGraph, labels: Labels) -> list[dict[str, Any]]:
    """Labels that no piece of the graph holds, where they stand in their clips."""
    held: dict[int, list[tuple[int, int]]] = {}
    for edge, (start, stop) in zip(graph.label_edge, whole_labels(graph).tolist(), strict=True):
        clip = int(graph.edge_clip[edge])
        first = int(graph.clip_starts[clip])
        held.setdefault(clip, []).append((start - first, stop - first))
    found: list[dict[str, Any]] = []
    for clip, name in enumerate(graph.clip_names):
        for label in labels.get(name, ()):
            start, stop = (round(x * graph.frame_rate) for x in (label.start_s, label.end_s))
            if any(a < stop and start < b for a, b in held.get(clip, ())):
                continue
            found.append(
                {
                    "clip": clip,
                    "start": start,
                    "stop": stop,
                    "kind": label.kind,
                    "direction": label.direction,
                    "genuine": label.genuine,
                    "kept": False,
                    "enterable": False,
                }
            )
    return found
