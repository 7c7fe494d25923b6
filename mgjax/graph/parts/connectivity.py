"""How well a graph is connected: how soon an avoidance part comes from wherever a body stands."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from mgjax.graph.types import NO_CLIP, MotionGraph

SOONEST_S = 1e-9
"""Shortest time of a way: a sparse matrix has no entries of 0."""


def nearest_part(graph: MotionGraph, wanted: Bool[np.ndarray, " P"]) -> Float[np.ndarray, " N"]:
    """Least time from each node to the middle of any of the wanted parts, s; inf without a way.

    Shortest paths over edges at natural speed, from one sink that stands for all the middles.
    """
    part = np.flatnonzero(wanted)
    edge, sink = graph.label_edge[part], graph.num_nodes
    middle = 0.5 * (graph.label_starts + graph.label_stops)[part] - graph.edge_starts[edge]
    ways = np.concatenate([graph.edge_frames, middle]) / graph.frame_rate
    # Backwards, from the sink; scipy adds parallel edges up, so only the shortest stays.
    source = np.concatenate([graph.edge_target, np.full(len(part), sink)])
    target = np.concatenate([graph.edge_source, graph.edge_source[edge]])
    order = np.lexsort((ways, target, source))
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(source[order]) != 0) | (np.diff(target[order]) != 0)
    kept = order[first]
    matrix = csr_array(
        (np.maximum(ways[kept], SOONEST_S), (source[kept], target[kept])),
        shape=(sink + 1, sink + 1),
    )
    return np.asarray(dijkstra(matrix, directed=True, indices=sink))[:sink]


def time_to_part(graph: MotionGraph, wanted: Bool[np.ndarray, " P"]) -> Float[np.ndarray, " F"]:
    """Least time to the middle of any of the wanted parts, s, from every frame of the clips.

    A body in the midst of a piece of a clip plays it to its end, unless a part's middle comes
    first. Frames of the clips that are not in the graph are NaN; inf without a way.
    """
    times = np.full(int(graph.clip_stops.max(initial=0)), np.nan)
    pieces = np.flatnonzero(graph.edge_clip != NO_CLIP)
    ends = nearest_part(graph, wanted)[graph.edge_target[pieces]]
    counts = graph.edge_frames[pieces]
    frames = np.repeat(graph.edge_starts[pieces], counts)
    frames += np.arange(len(frames)) - np.repeat(np.cumsum(counts) - counts, counts)
    left = np.repeat(graph.edge_stops[pieces], counts) - frames
    times[frames] = left / graph.frame_rate + np.repeat(ends, counts)
    for part in np.flatnonzero(wanted):
        middle = 0.5 * (graph.label_starts[part] + graph.label_stops[part])
        begin = int(graph.edge_starts[graph.label_edge[part]])
        before = np.arange(begin, int(np.floor(middle)) + 1)
        times[before] = np.minimum(times[before], (middle - before) / graph.frame_rate)
    return times


def connectivity(graph: MotionGraph) -> dict[str, Any]:
    """What a build reports: time to a part from every frame of the graph, of any kind and of each.

    ``p50`` and ``p95`` are seconds; None where that many frames have no way.
    """
    wanted = {"any": np.ones(len(graph.label_edge), dtype=bool), "genuine": graph.label_genuine}
    wanted |= {kind: np.array(graph.label_kind) == kind for kind in sorted(set(graph.label_kind))}
    return {
        "time_to_part_s": {
            name: _quantiles(time_to_part(graph, mask))
            for name, mask in wanted.items()
            if mask.any()
        }
    }


def _quantiles(times: Float[np.ndarray, " F"]) -> dict[str, float | None]:
    known = times[~np.isnan(times)]
    values = np.quantile(known, (0.5, 0.95), method="higher").tolist() if len(known) else []
    return {
        name: round(value, 4) if np.isfinite(value) else None
        for name, value in zip(("p50", "p95"), values, strict=False)
    }
