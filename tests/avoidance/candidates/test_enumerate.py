from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.body.edge_tables import edge_tables
from mgjax.avoidance.candidates import enumerate as module
from mgjax.avoidance.candidates.enumerate import (
    Candidates,
    enumerate_candidates,
    enumerate_nodes,
)
from mgjax.graph.types import NO_EDGE, MotionGraph
from tests.avoidance.made import make_graph, random_graph
from tests.reference import avoidance as reference


def found_by(graph: MotionGraph, node: int, t_attack: float, **settings: float) -> Candidates:
    given = {"window": 1.0, "capacity": 100_000} | settings
    return enumerate_candidates(graph, edge_tables(graph, 30.0), node, t_attack, **given)


def pairs(candidates: Candidates) -> list[tuple[tuple[int, ...], int]]:
    """(walk, part) of each candidate; checks the padding on the way."""
    found = []
    for row, length, part in zip(candidates.edges, candidates.length, candidates.part, strict=True):
        assert 1 <= length <= len(row)
        assert (row[:length] >= 0).all()
        assert (row[length:] == NO_EDGE).all()
        found.append((tuple(int(e) for e in row[:length]), int(part)))
    return found


def middles(graph: MotionGraph) -> np.ndarray:
    """Seconds from the beginning of its edge to the middle of each part."""
    frames = 0.5 * (graph.label_starts + graph.label_stops) - graph.edge_starts[graph.label_edge]
    return frames / graph.frame_rate


def searched(graph: MotionGraph, node: int, t_attack: float, window: float = 1.0) -> set:
    """The same by the plain recursive search."""
    out: dict[int, list[int]] = {n: [] for n in range(graph.num_nodes)}
    for edge, source in enumerate(graph.edge_source.tolist()):
        out[source].append(edge)
    parts: dict[int, list[tuple[int, float]]] = {}
    for part, (edge, middle) in enumerate(zip(graph.label_edge, middles(graph), strict=True)):
        parts.setdefault(int(edge), []).append((part, float(middle)))
    seconds = (graph.edge_stops - graph.edge_starts) / graph.frame_rate
    return reference.candidates(
        out, graph.edge_target.tolist(), seconds, parts, node, t_attack, window
    )


@pytest.mark.parametrize("seed", range(12))
def test_same_set_as_a_recursive_search(seed: int) -> None:
    graph = random_graph(seed)
    total = 0
    for node in range(graph.num_nodes):
        for t_attack, window in ((0.3001, 1.0), (0.8003, 1.0), (1.4007, 0.5)):
            got = found_by(graph, node, t_attack, window=window)
            found = pairs(got)
            assert got.overflow == 0
            assert len(set(found)) == len(found)
            assert set(found) == searched(graph, node, t_attack, window)
            total += len(found)
    assert total > 20


def test_same_set_on_graphs_of_clips(any_graph: MotionGraph) -> None:
    nearest = edge_tables(any_graph, 30.0).nearest_part
    rng = np.random.default_rng(0)
    sizes = []
    for node in rng.choice(np.flatnonzero((nearest > 0.5) & (nearest < 0.9)), 6, replace=False):
        t_attack = float(nearest[node]) + 0.3507
        found = pairs(found_by(any_graph, int(node), t_attack, window=0.8))
        assert len(set(found)) == len(found)
        assert set(found) == searched(any_graph, int(node), t_attack, 0.8)
        sizes.append(len(found))
    assert min(sizes) >= 1
    assert max(sizes) >= 5


def test_by_hand() -> None:
    # Node 0 –(0: 15 frames)→ 1 –(1: 30 frames, parts in the middle at 9 and 27)→ 0; edge 2 is a
    # shortcut 0 → 1 of 6 frames. At 30 Hz the middles come at 0.8 and 1.4 s, or at 0.5 and 1.1 s.
    graph = make_graph([(0, 1, 15), (1, 0, 30), (0, 1, 6)], [(1, 6, 12), (1, 24, 30)])
    assert set(pairs(found_by(graph, 0, 1.0))) == {
        ((0, 1), 0),
        ((0, 1), 1),
        ((2, 1), 1),
    }  # ((2, 1), 0) comes exactly T/2 too early: the window is open
    assert set(pairs(found_by(graph, 0, 0.999))) >= {((2, 1), 0)}
    # Earlier parts may be passed; a second lap takes 0.2 + 1 + 0.2 s to its edge 1.
    again = ((2, 1, 2, 1), 0)
    assert set(pairs(found_by(graph, 0, 1.301))) == {((0, 1), 1), ((2, 1), 1), again}
    assert set(pairs(found_by(graph, 1, 0.2))) == {((1,), 0)}


def test_beyond_capacity_the_nearest_are_kept() -> None:
    graph = random_graph(3)
    node, t_attack = 1, 1.3003
    full = found_by(graph, node, t_attack, window=2.0)
    everything = pairs(full)
    assert len(everything) > 12
    seconds = (graph.edge_stops - graph.edge_starts) / graph.frame_rate
    late = {
        (walk, part): abs(seconds[list(walk[:-1])].sum() + middles(graph)[part] - t_attack)
        for walk, part in everything
    }
    got = found_by(graph, node, t_attack, window=2.0, capacity=10)
    assert len(got.length) == 10
    assert got.overflow == len(everything) - 10
    worst_kept = max(late[pair] for pair in pairs(got))
    left_out = set(everything) - set(pairs(got))
    assert worst_kept <= min(late[pair] for pair in left_out) + 1e-9


def test_too_many_unfinished_walks_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = random_graph(3)
    full = set(pairs(found_by(graph, 1, 1.8003)))
    monkeypatch.setattr(module, "MAX_WALKS", 3)
    got = found_by(graph, 1, 1.8003)
    assert got.overflow > 0
    assert set(pairs(got)) < full


def test_no_candidate() -> None:
    graph = make_graph([(0, 1, 15), (1, 0, 30)], [(1, 6, 12)])
    got = found_by(graph, 0, 0.1, window=0.2)
    assert (len(got.length), len(got.part), got.overflow) == (0, 0, 0)
    assert got.edges.shape[0] == 0
    # Without any part at all the search ends at once.
    bare = make_graph([(0, 1, 15), (1, 0, 30)], [])
    assert len(found_by(bare, 0, 5.0).length) == 0


def test_a_long_time_ahead_is_bounded(real_graph: MotionGraph) -> None:
    got = found_by(real_graph, 0, 6.0, capacity=100)
    assert len(got.length) == 100
    assert got.overflow > 1000


def test_nodes_together_are_nodes_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = random_graph(3)
    tables = edge_tables(graph, 30.0)
    rng = np.random.default_rng(0)
    nodes = rng.permutation(graph.num_nodes)
    low = rng.uniform(0.2, 0.8, len(nodes)) + 3e-5
    high = low + rng.uniform(0.1, 1.0, len(nodes))
    alone = [
        enumerate_candidates(
            graph, tables, int(node), (a + b) / 2, window=b - a, capacity=1_000_000
        )
        for node, a, b in zip(nodes, low, high, strict=True)
    ]
    assert sum(len(own.length) for own in alone) > 20
    assert any(len(own.length) == 0 for own in alone)

    def same() -> None:
        together = enumerate_nodes(graph, tables, nodes, low, high)
        for node, wanted in enumerate(alone):
            rows = np.arange(*together.first[node : node + 2])
            got = together.some(rows, together.overflow.item(node))
            for name in ("edges", "length", "part"):
                np.testing.assert_array_equal(getattr(got, name), getattr(wanted, name))
            assert got.overflow == 0

    same()
    # Without room for all of them at once they grow in halves.
    walks = max(len(own.length) for own in alone)
    monkeypatch.setattr(module, "MAX_WALKS", 4 * walks)
    same()
