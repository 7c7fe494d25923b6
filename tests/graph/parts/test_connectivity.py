from __future__ import annotations

import heapq
from dataclasses import replace

import numpy as np
import pytest

from mgjax.graph.parts.connectivity import connectivity, nearest_part, time_to_part
from mgjax.graph.types import NO_CLIP, MotionGraph
from tests.avoidance.made import make_graph, random_graph


def shortest(graph: MotionGraph, wanted: np.ndarray, edge: int, frame: int) -> float:
    """Frames from one frame that an edge plays to the middle of a part, by Dijkstra's loop."""
    best, queue = np.inf, [(0.0, edge, frame)]
    seen: set[tuple[int, int]] = set()
    while queue:
        time, edge, frame = heapq.heappop(queue)
        if (edge, frame) in seen:
            continue
        seen.add((edge, frame))
        for part in np.flatnonzero(wanted & (graph.label_edge == edge)):
            middle = (graph.label_starts[part] + graph.label_stops[part]) / 2
            if middle >= frame:
                best = min(best, time + middle - frame)
        end = time + float(graph.edge_stops[edge] - frame)
        if end < best:
            for other in graph.edges_from(int(graph.edge_target[edge])):
                heapq.heappush(queue, (end, int(other), int(graph.edge_starts[other])))
    return best


@pytest.mark.parametrize("seed", range(6))
def test_shortest_paths_from_every_frame(seed):
    graph = random_graph(seed)
    wanted = np.random.default_rng(seed).random(len(graph.label_edge)) < 0.6
    got = time_to_part(graph, wanted)
    for edge in range(graph.num_edges):
        for frame in range(int(graph.edge_starts[edge]), int(graph.edge_stops[edge])):
            want = shortest(graph, wanted, edge, frame) / graph.frame_rate
            assert got[frame] == pytest.approx(want, abs=1e-6)
        # The last frame is only a pose to arrive at, and begins no edge here.
        assert np.isnan(got[graph.edge_stops[edge]])
    nodes = nearest_part(graph, wanted)
    for edge in range(graph.num_edges):
        assert got[graph.edge_starts[edge]] >= nodes[graph.edge_source[edge]] - 1e-9


def test_worked_by_hand():
    # 0 → 1 in 30 frames, 1 → 0 in 60 with a duck at 20 … 40; a way on from 1 to 2, which stays.
    graph = make_graph([(0, 1, 30), (1, 0, 60), (1, 2, 10), (2, 2, 5)], [(1, 20, 40)])
    wanted = np.ones(1, bool)
    np.testing.assert_allclose(nearest_part(graph, wanted), [2.0, 1.0, np.inf], atol=1e-6)
    times = time_to_part(graph, wanted)
    begins = graph.edge_starts
    assert times[begins[0]] == pytest.approx(2.0)
    assert times[begins[0] + 15] == pytest.approx(1.5)
    assert times[begins[1] + 30] == 0.0
    # Just after the middle: to the end of the edge, and once around.
    assert times[begins[1] + 31] == pytest.approx(29 / 30 + 2.0)
    assert np.isinf(times[begins[2]])
    none = connectivity(graph)["time_to_part_s"]
    assert none == dict.fromkeys(("any", "genuine", "duck"), none["any"])
    assert none["any"]["p95"] is None


def test_transitions_do_not_count(made_graph):
    found = connectivity(made_graph)["time_to_part_s"]
    assert set(found) == {"any", "genuine", "duck"}
    times = time_to_part(made_graph, np.ones(len(made_graph.label_edge), bool))
    pieces = made_graph.edge_clip != NO_CLIP
    assert np.isfinite(times).sum() == made_graph.edge_frames[pieces].sum()
    known = np.sort(times[np.isfinite(times)])
    assert found["any"]["p50"] == pytest.approx(known[(len(known) - 1 + 1) // 2], abs=0.034)
    assert found["any"]["p95"] <= found["genuine"]["p95"]
    unlabelled = replace(made_graph, label_edge=made_graph.label_edge[:0], label_kind=(),
                         label_starts=made_graph.label_starts[:0],
                         label_stops=made_graph.label_stops[:0],
                         label_genuine=made_graph.label_genuine[:0])  # fmt: skip
    assert connectivity(unlabelled) == {"time_to_part_s": {}}
