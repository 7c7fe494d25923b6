from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.body.edge_tables import edge_tables
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.choice import choosing as choice
from mgjax.avoidance.choice import start
from mgjax.avoidance.choice.decision import Decision
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.index import rasterise
from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.cells import touched_cells
from mgjax.avoidance.index.index import GridIndex
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.avoidance.index.swept_cells import swept_cells
from mgjax.graph.types import MotionGraph
from tests.avoidance.index.made import (
    RATE,
    SHORT_S,
    all_of,
    ball,
    built,
    cell_set,
    cells_of,
    lookup,
    one_sphere,
    pairs,
    passing,
    paths_of,
)
from tests.avoidance.made import make_graph, random_graph, throw
from tests.reference import grid_index as reference
from tests.sized import graph_of_size


def bodies_of(graph: MotionGraph) -> reference.Bodies:
    """The bodies of a graph at the size of an adult, as an index has them."""
    adult = graph_of_size(graph, 1 / graph.body_scale)
    return reference.Bodies(adult, preset_spheres(adult.skeleton), RATE)


def counts_of(index: GridIndex) -> np.ndarray:
    """How many paths each node has within the horizon."""
    return np.array([len(paths_of(index, node)) for node in range(index.nodes)])


def check_cells(graph: MotionGraph, index: GridIndex, node: int, paths: list[int], rate: float):
    """Compares the cells of some paths of a node with the definition; returns their number."""
    walks = reference.walks_within(graph, node, index.horizon)
    assert pairs(all_of(index, node)) == walks
    bodies = bodies_of(graph)
    total = 0
    for path in paths:
        sure, perhaps = reference.cells_of_walk(bodies, *walks[path], rate)
        got = cell_set(cells_of(index, node, path))
        assert sure <= got
        assert got <= sure | perhaps
        assert len(perhaps) <= 2 + len(sure) // 20
        total += len(sure)
    return total


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rate", [30.0, 8.0])
def test_cells_are_those_of_the_definition(seed: int, rate: float) -> None:
    graph = random_graph(seed)
    index = build_index(graph, horizon=1.0, rate=rate)
    rng = np.random.default_rng(seed)
    total = 0
    for node in range(graph.num_nodes):
        count = len(paths_of(index, node))
        some = rng.choice(count, min(count, 3), replace=False).tolist()
        total += check_cells(graph, index, node, some, rate)
    assert total > 300


def test_cells_on_the_graph_of_clips(made_graph: MotionGraph, made_index: GridIndex) -> None:
    counts = counts_of(made_index)
    rng = np.random.default_rng(0)
    for node in rng.choice(np.flatnonzero((counts > 10) & (counts < 200)), 4, replace=False):
        some = rng.choice(counts[node], 3, replace=False).tolist()
        assert check_cells(made_graph, made_index, int(node), some, RATE) > 50


def test_by_hand() -> None:
    # The sphere is around the middle of cell (0, 10, 0): the cell's eight sub-points are 4.3 cm
    # from it, those of its neighbours 8.3 cm. It leaves by 20 cm. Edge 0 turns the frame by 90°
    # and moves it by 1 m, so that (0.05, y, 0.05) is at (1.05, y, −0.05) from node 0.
    graph, tables = one_sphere([(0.05, 1.05, 0.05), (0.05, 1.05, 0.05), (0.25, 1.05, 0.05)])
    index = built(graph, tables, horizon=1.0)
    times = [paths_of(index, node).time.tolist() for node in range(2)]
    assert times == [[2 * 15 + 9 + 11], [9 + 11]]  # half frames
    assert cells_of(index, 0, 0).tolist() == [[10, 10, -1]]
    assert cells_of(index, 1, 0).tolist() == [[0, 10, 0]]
    per_cell = index.paths_per_cell(1)
    assert per_cell is not None
    assert per_cell.tolist() == [1]
    assert index.paths_per_cell(1, most=0) is None
    here = np.array([[0, 10, 0], [3, 3, 3]])
    found = lookup(index, 1, here, 0.4, 0.5)
    assert found is not None
    assert pairs(found) == [((1,), 0)]
    for cells, t_attack in ((here[1:], 0.4), (here, 0.7), (here, 0.05), (here[:0], 0.4)):
        nothing = lookup(index, 1, cells, t_attack, 0.5)
        assert nothing is not None
        assert nothing.edges.shape == (0, 1)
    assert lookup(index, 1, here, 0.76, 0.5) is None  # beyond the horizon
    assert lookup(index, 1, np.array([[0, 26, 0]]), 0.4, 0.5) is None  # too high


@pytest.mark.parametrize(("moved", "stays"), [(0.01, True), (0.04, False)])
def test_a_sub_point_has_to_be_left(moved: float, stays: bool) -> None:
    # Moved by d along x, the farthest sub-points are √((2.5 + d)² + 2.5² + 2.5²) cm from the
    # middle: 4.9 cm, still inside, or 7.4 cm.
    graph, tables = one_sphere([(0.05, 1.05, 0.05)] * 2 + [(0.05 + moved, 1.05, 0.05)])
    index = built(graph, tables, horizon=1.0)
    assert (len(cells_of(index, 1, 0)) == 0) == stays
    found = lookup(index, 1, np.array([[0, 10, 0]]), 0.4, 0.5)
    assert found is not None
    assert len(found.part) == (0 if stays else 1)


def test_rates_between_the_samples() -> None:
    # At 30 moments a second the part has three, at 15 only its start and end.
    away = (0.25, 1.05, 0.05)
    graph, tables = one_sphere([(0.05, 1.05, 0.05), away, (0.05, 1.05, 0.05)])
    assert len(cells_of(built(graph, tables, rate=30.0), 1, 0)) == 1
    assert len(cells_of(built(graph, tables, rate=15.0), 1, 0)) == 0


def expected(
    graph: MotionGraph,
    index: GridIndex,
    node: int,
    cells: np.ndarray,
    t_attack: float,
    window: float,
) -> list:
    """What enumeration finds, of which the index's own cells meet the given ones."""
    walks = pairs(all_of(index, node))
    meets = {
        walk
        for path, walk in enumerate(walks)
        if cell_set(cells) & cell_set(cells_of(index, node, path))
    }
    tables = edge_tables(graph, RATE)
    found = enumerate_candidates(graph, tables, node, t_attack, window=window, capacity=10**6)
    return [walk for walk in pairs(found) if walk in meets]


def test_lookup_is_the_enumeration_that_touches(
    made_graph: MotionGraph, made_index: GridIndex
) -> None:
    rng = np.random.default_rng(3)
    counts = counts_of(made_index)
    sizes = []
    for node in rng.choice(np.flatnonzero((counts > 20) & (counts < 150)), 6, replace=False):
        height = float(rng.uniform(0.9, 1.7))
        attack = throw(rng, arrives=float(rng.uniform(0.6, 0.9)), height=height)
        crop = crop_attack(attack, radius=1.0, height=2.3)
        assert crop is not None
        cells = touched_cells(attack, crop)
        assert cells is not None
        want = expected(made_graph, made_index, int(node), cells, crop.middle, 0.7003)
        for some in (cells, swept_cells(attack, crop)):
            got = lookup(made_index, int(node), some, crop.middle, 0.7003)
            assert got is not None
            assert got.overflow == 0
            assert pairs(got) == want  # also their order
        sizes.append(len(want))
    assert max(sizes) >= 5


@pytest.mark.parametrize("seed", range(3))
def test_lookup_by_the_definition(seed: int) -> None:
    graph = random_graph(seed)
    index = build_index(graph, horizon=1.0)
    bodies = bodies_of(graph)
    rng = np.random.default_rng(seed)
    met = missed = 0
    for node in range(graph.num_nodes):
        walks = reference.walks_within(graph, node, 0.98)[:12]
        cells = [reference.cells_of_walk(bodies, *walk, RATE) for walk in walks]
        some = sorted(set().union(*(sure for sure, _ in cells)))
        if not some:
            continue
        near = np.array([some[int(rng.integers(len(some)))] for _ in range(2)])
        found = lookup(index, node, near, 0.4999, 1.0)
        assert found is not None
        got, looked = set(pairs(found)), cell_set(np.unique(near, axis=0))
        for walk, (sure, perhaps) in zip(walks, cells, strict=True):
            assert (walk in got) or not looked & sure
            assert (walk not in got) or looked & (sure | perhaps)
            met += walk in got
            missed += walk not in got
    assert met > 5
    assert missed > 5


@pytest.mark.parametrize("kind", ["straight", "ballistic", "wandering", "along cells"])
def test_swept_cells_find_what_the_cells_find(made_index: GridIndex, kind: str) -> None:
    rng = np.random.default_rng(len(kind) + 1)
    busy = np.argsort(counts_of(made_index))[-200:]
    found = 0
    for _ in range(40):
        attack, crop = passing(rng, kind)
        cells, swept = touched_cells(attack, crop), swept_cells(attack, crop)
        node, t_attack = int(rng.choice(busy)), float(rng.uniform(0.2, 0.9))
        want = lookup(made_index, node, cells, t_attack, 0.7)
        got = lookup(made_index, node, swept, t_attack, 0.7)
        assert (got is None) == (want is None)
        if got is not None and want is not None:
            np.testing.assert_array_equal(got.edges, want.edges)
            assert pairs(got) == pairs(want)
            found += len(got.part)
    assert found > 20


def test_how_much_is_stored_changes_nothing(made_graph: MotionGraph, made_index: GridIndex) -> None:
    sizes, attack = [], ball((-1.0, 1.2, 0.0), (0.0, 1.2, 0.1), (1.0, 1.2, 0.2), radius=0.15)
    cells = swept_cells(*attack)
    assert cells is not None
    for capacity in (0, 10**4):
        other = build_index(made_graph, horizon=SHORT_S, capacity=capacity)
        assert other.report["paths"] == made_index.report["paths"]
        found = 0
        for node in range(0, made_graph.num_nodes, 37):
            one, two = paths_of(made_index, node), paths_of(other, node)
            np.testing.assert_array_equal(one.time, two.time)
            assert pairs(made_index.walks(one)) == pairs(other.walks(two))
            touched = other.touched_by(two, cells)
            np.testing.assert_array_equal(touched, made_index.touched_by(one, cells))
            found += int(touched.sum())
        assert found > 20
        sizes.append(other.nbytes)
    assert sizes[0] < made_index.nbytes < sizes[-1]


def test_nothing_to_index() -> None:
    graph = make_graph([(0, 1, 15), (1, 0, 30)], [])
    index = build_index(graph)
    found = lookup(index, 0, np.array([[0, 10, 0]]), 1.0, 1.0)
    assert found is not None
    assert not len(found.part)


def test_same_again_and_without_compiling(made_graph: MotionGraph, made_index: GridIndex) -> None:
    build_index(made_graph, horizon=SHORT_S)  # programs made for other tests may have been dropped
    programs: tuple[Any, ...] = (rasterise._gap,)
    sizes = [program._cache_size() for program in programs]
    assert all(sizes)
    again = build_index(made_graph, horizon=SHORT_S - 0.1)
    assert [program._cache_size() for program in programs] == sizes
    latest = (SHORT_S - 0.1) * made_index.half_frames
    counted = 0
    for node in range(0, made_index.nodes, 5):
        kept = (paths_of(made_index, node).time <= latest).sum()
        assert len(paths_of(again, node)) == kept
        counted += kept
    assert counted > 100


def test_the_choice_is_as_good_with_the_index(
    made_graph: MotionGraph, made_index: GridIndex, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(4)
    judged: list[int] = []
    real = choice.best_of

    def best_of(query: Query, candidates: Candidates) -> Decision:
        judged.append(len(candidates.length))
        return real(query, candidates)

    monkeypatch.setattr(choice, "best_of", best_of)
    monkeypatch.setattr(start, "enumerate_candidates", None)  # the index holds them all
    looked_up = rest = 0
    for node in rng.integers(made_graph.num_nodes, size=24):
        height, side = rng.uniform(0.5, 1.7), rng.uniform(0, 2 * np.pi)
        attack = ball_from(side, height, distance=3.0, arrives=SHORT_S - 0.6)
        config = AvoidanceConfig(checks=8, T_wide=0.0, refine="off")
        with monkeypatch.context() as plainly:
            plainly.setattr(start, "enumerate_candidates", enumerate_candidates)
            plain = choice.choose(made_graph, int(node), attack, config=config)
        judged.clear()
        quick = choice.choose(made_graph, int(node), attack, config=config, index=made_index)
        assert (quick.status == "avoided") == (plain.status == "avoided")
        if quick.status == "avoided" and len(judged) == 1:
            looked_up += 1
            continue
        # The rest follows: together they are all.
        assert quick.candidates == plain.candidates == sum(judged)
        rest += judged[-1]
    assert looked_up
    assert rest


def test_all_in_time_are_those_that_are_enumerated(
    made_graph: MotionGraph, made_index: GridIndex
) -> None:
    tables = edge_tables(made_graph, RATE)
    rng = np.random.default_rng(9)
    count = 0
    for _ in range(60):
        node, window = int(rng.integers(made_graph.num_nodes)), rng.uniform(0.2, 0.8)
        middle = rng.uniform(0.2, SHORT_S - window / 2)
        wanted = enumerate_candidates(
            made_graph, tables, node, middle, window=window, capacity=10**6
        )
        paths = made_index.in_time(node, middle, window)
        assert paths is not None
        assert pairs(made_index.walks(paths)) == pairs(wanted)
        count += len(paths)
    assert count > 10
    assert made_index.in_time(0, SHORT_S, 0.1) is None


def test_it_is_what_a_choice_asks_for(made_index: GridIndex) -> None:
    assert isinstance(made_index, CandidateIndex)
