from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables
from mgjax.avoidance.body.spheres import BodySpheres, preset_spheres
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.choice import choosing as choice
from mgjax.avoidance.choice.verify import Settled
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.index import build as grid_build
from mgjax.avoidance.index import part_volumes as grid_parts
from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.cells import COVERED, LOWEST, SPAN
from mgjax.avoidance.index.index import (
    GridIndex,
    cells_of,
    load_index,
    lookup,
    paths_in_time,
    paths_per_cell,
    save_index,
    touched_cells,
    walks_of,
)
from mgjax.avoidance.index.swept_cells import swept_cells
from mgjax.core.errors import FileFormatError
from mgjax.graph.types import MotionGraph
from mgjax.io.store import load_arrays, save_arrays
from tests.avoidance.made import make_graph, random_graph, throw
from tests.reference import grid_index as reference

RATE = 30.0
SHORT_S = 1.3


@pytest.fixture(scope="module")
def made_index(made_graph: MotionGraph) -> GridIndex:
    return build_index(made_graph, edge_tables(made_graph, RATE), horizon=SHORT_S)


def all_of(index: GridIndex, node: int) -> Candidates:
    """Every path of a node as a walk, whether or not it has cells."""
    paths = np.arange(index.node_first[node], index.node_first[node + 1])
    return walks_of(index, paths)


def pairs(candidates: Candidates) -> list[tuple[tuple[int, ...], int]]:
    rows = zip(candidates.edges, candidates.length, candidates.part, strict=True)
    return [(tuple(row[:length].tolist()), int(part)) for row, length, part in rows]


def cell_set(cells: np.ndarray) -> set:
    found = {tuple(cell) for cell in cells.tolist()}
    assert len(found) == len(cells)
    return found


def check_cells(graph: MotionGraph, index: GridIndex, node: int, paths: list[int], rate: float):
    """Compares the cells of some paths of a node with the definition; returns their number."""
    walks = reference.walks_within(graph, node, index.horizon)
    assert pairs(all_of(index, node)) == walks
    bodies = reference.Bodies(graph, preset_spheres(graph.skeleton), RATE)
    total = 0
    for path in paths:
        sure, perhaps = reference.cells_of_walk(bodies, *walks[path], rate)
        got = cell_set(cells_of(index, int(index.node_first[node]) + path))
        assert sure <= got
        assert got <= sure | perhaps
        assert len(perhaps) <= 2 + len(sure) // 20
        total += len(sure)
    return total


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rate", [30.0, 8.0])
def test_cells_are_those_of_the_definition(seed: int, rate: float) -> None:
    graph = random_graph(seed)
    index = build_index(graph, edge_tables(graph, RATE), horizon=1.0, rate=rate)
    rng = np.random.default_rng(seed)
    total = 0
    for node in range(graph.num_nodes):
        count = int(index.node_first[node + 1] - index.node_first[node])
        some = rng.choice(count, min(count, 3), replace=False).tolist()
        total += check_cells(graph, index, node, some, rate)
    assert total > 300


def test_cells_on_the_graph_of_clips(made_graph: MotionGraph, made_index: GridIndex) -> None:
    counts = np.diff(made_index.node_first)
    rng = np.random.default_rng(0)
    for node in rng.choice(np.flatnonzero((counts > 10) & (counts < 200)), 4, replace=False):
        some = rng.choice(counts[node], 3, replace=False).tolist()
        assert check_cells(made_graph, made_index, int(node), some, RATE) > 50


def one_sphere(steps: list[tuple[float, float, float]]) -> tuple[MotionGraph, EdgeTables]:
    """Edge 0 leads to edge 1, with a part of two frames; the body is one sphere of 6 cm.

    Places are those at the beginning, the middle and the end of the part.
    """
    graph = make_graph([(0, 1, 15), (1, 0, 30)], [(1, 9, 11)])
    tables = edge_tables(graph, RATE)
    zero = np.zeros(1, np.int64)
    share, radii = np.zeros(1, np.float32), np.array([0.06], np.float32)
    spheres = BodySpheres(names=("one",), first=zero, second=zero, share=share, radii=radii)
    pool = np.zeros((len(tables.pool), 3), np.float32)
    first = int(tables.pool_first[1])
    pool[first + 9 : first + 12] = steps
    step = tables.step.copy()
    step[0] = (np.pi / 2, 1.0, 0.0)
    return graph, replace(tables, spheres=spheres, pool=pool, step=step)


def test_by_hand() -> None:
    # The sphere is around the middle of cell (0, 10, 0): the cell's eight sub-points are 4.3 cm
    # from it, those of its neighbours 8.3 cm. It leaves by 20 cm. Edge 0 turns the frame by 90°
    # and moves it by 1 m, so that (0.05, y, 0.05) is at (1.05, y, −0.05) from node 0.
    graph, tables = one_sphere([(0.05, 1.05, 0.05), (0.05, 1.05, 0.05), (0.25, 1.05, 0.05)])
    index = build_index(graph, tables, horizon=1.0)
    assert index.node_first.tolist() == [0, 1, 2]
    assert index.time.tolist() == [2 * 15 + 9 + 11, 9 + 11]  # half frames
    assert cells_of(index, 0).tolist() == [[10, 10, -1]]
    assert cells_of(index, 1).tolist() == [[0, 10, 0]]
    assert paths_per_cell(index, 1).tolist() == [1]
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
    index = build_index(graph, tables, horizon=1.0)
    assert (len(cells_of(index, 1)) == 0) == stays
    found = lookup(index, 1, np.array([[0, 10, 0]]), 0.4, 0.5)
    assert found is not None
    assert len(found.part) == (0 if stays else 1)


def test_rates_between_the_samples() -> None:
    # At 30 moments a second the part has three, at 15 only its start and end.
    away = (0.25, 1.05, 0.05)
    graph, tables = one_sphere([(0.05, 1.05, 0.05), away, (0.05, 1.05, 0.05)])
    assert len(cells_of(build_index(graph, tables, rate=30.0), 1)) == 1
    assert len(cells_of(build_index(graph, tables, rate=15.0), 1)) == 0


@pytest.mark.parametrize("gravity", [False, True])
def test_touched_cells(gravity: bool) -> None:
    rng = np.random.default_rng(int(gravity))
    for _ in range(6):
        attack = throw(rng, gravity=gravity)
        if gravity:  # the pieces themselves, without the margin for their curvature
            attack = replace(attack, acceleration=0.0)
        crop = crop_attack(attack, radius=1.0, height=2.3)
        assert crop is not None
        got = touched_cells(attack, crop)
        assert got is not None
        sure, perhaps = reference.touched(attack, crop.start, crop.end)
        assert sure <= cell_set(got) <= sure | perhaps
        assert len(sure) > 100


def ball(*places: tuple[float, float, float], radius: float) -> tuple[Attack, Crop]:
    times = np.arange(float(len(places)))
    attack = Attack(times=times, centres=np.array(places)[:, None], radii=np.array([radius]))
    return attack, Crop(start=0.0, end=float(times[-1]))


def test_touched_cells_by_hand() -> None:
    still = touched_cells(*ball((0.05, 1.05, 0.05), (0.05, 1.05, 0.05), radius=0.04))
    assert still is not None
    assert still.tolist() == [[0, 10, 0]]
    over = touched_cells(*ball((0.05, 1.05, 0.05), (0.05, 1.05, 0.05), radius=0.06))
    assert over is not None
    assert len(over) == 7  # the cell and its six neighbours; edges are 7.1 cm away
    along = touched_cells(*ball((-0.25, 1.05, 0.05), (0.25, 1.05, 0.05), radius=0.04))
    assert along is not None
    assert along.tolist() == [[i, 10, 0] for i in range(-3, 3)]
    there_and_back = touched_cells(
        *ball((0.05, 1.05, 0.05), (0.35, 1.05, 0.05), (0.05, 1.05, 0.05), radius=0.04)
    )
    assert there_and_back is not None
    assert there_and_back.tolist() == [[i, 10, 0] for i in range(4)]
    two = Attack(
        times=np.array([0.0, 1.0]),
        centres=np.array([[[0.05, 1.05, 0.05], [-1.05, 1.05, 0.05]]] * 2),
        radii=np.array([0.04, 0.01]),
    )
    both = touched_cells(two, Crop(start=0.0, end=1.0))
    assert both is not None
    assert both.tolist() == [[-11, 10, 0], [0, 10, 0]]


@pytest.mark.parametrize("radius", [1e-6, 0.3, 1.0, 50.0, 1000.0])
def test_touched_cells_of_strange_balls(radius: float) -> None:
    for places in (((0.0, 1.1, 0.0),) * 2, ((0.0, 1.2, 0.0), (0.0, 1.4, 0.0), (1.0, 1.2, 1.0))):
        attack, crop = ball(*places, radius=radius)
        got = touched_cells(attack, crop)
        assert (got is None) == (radius > 1.1)
        if got is not None:
            sure, perhaps = reference.touched(attack, crop.start, crop.end)
            assert sure <= cell_set(got) <= sure | perhaps
        instant = touched_cells(attack, Crop(start=1.0, end=1.0))
        assert (instant is None) == (radius > 1.1)


def passing(rng: np.random.Generator, kind: str) -> tuple[Attack, Crop]:
    """An attack past the character, and a crop of it."""
    if kind in ("straight", "ballistic"):
        attack = throw(rng, gravity=kind == "ballistic", height=float(rng.uniform(0.3, 1.7)))
        crop = crop_attack(attack, radius=float(rng.uniform(0.4, 1.0)), height=2.3)
        assert crop is not None
        return attack, crop
    knots, spheres = int(rng.integers(1, 30)), int(rng.integers(1, 4))
    step = rng.normal(size=(knots, spheres, 3)) * rng.uniform(0, 0.1)
    if kind == "along cells":  # on their faces, so that it depends on the last bit
        step = np.round(step, 1) * rng.integers(0, 2, 3)
    centres = np.cumsum(step, axis=0) + np.round(rng.uniform((-0.3, 0.5, -0.3), (0.3, 1.7, 0.3)), 1)
    attack = Attack(
        times=np.sort(rng.uniform(0, 1, knots)),
        centres=centres,
        radii=rng.integers(1, 6, spheres) / 20,
        acceleration=float(rng.choice([0.0, 9.8])),
    )
    return attack, Crop(start=float(rng.uniform(0, 0.3)), end=float(rng.uniform(0.3, 1)))


@pytest.mark.parametrize("kind", ["straight", "ballistic", "wandering", "along cells"])
def test_swept_cells_are_the_touched_cells(kind: str) -> None:
    rng = np.random.default_rng(len(kind))
    seen = 0
    for _ in range(60):
        attack, crop = passing(rng, kind)
        cells, swept = touched_cells(attack, crop), swept_cells(attack, crop)
        if cells is None or (cells < COVERED[0]).any() or (cells >= COVERED[1]).any():
            assert swept is None
            continue
        assert swept is not None
        column = (cells[:, 0] + SPAN // 2) * SPAN + cells[:, 2] + SPAN // 2 - swept.first
        bit = np.uint32(1) << (cells[:, 1] - LOWEST).astype(np.uint32)
        assert (swept.perhaps()[column] & bit).all()
        image = np.zeros_like(swept.sure)
        np.bitwise_or.at(image, column, bit)
        assert not (swept.sure & ~image).any()
        around = np.unique(cells[rng.integers(len(cells), size=80)], axis=0)
        around = np.unique(around + rng.integers(-1, 2, (len(around), 3)), axis=0)
        around = around[((around >= COVERED[0]) & (around < COVERED[1])).all(axis=1)]
        known = cell_set(cells)
        assert swept.touches(around).tolist() == [tuple(c) in known for c in around.tolist()]
        seen += 1
    assert seen > 20


def test_swept_cells_outside_the_covered_space() -> None:
    # As with the cells: a centimetre of a sphere under the lowest cells or beyond the last ones.
    for place, inside in (((0, 0.01, 0), True), ((0, -0.09, 0), False), ((12.75, 1, 0), False)):
        attack, crop = ball(place, place, radius=0.12)
        assert (swept_cells(attack, crop) is not None) == inside


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
        if cell_set(cells) & cell_set(cells_of(index, int(index.node_first[node]) + path))
    }
    tables = edge_tables(graph, RATE)
    found = enumerate_candidates(graph, tables, node, t_attack, window=window, capacity=10**6)
    return [walk for walk in pairs(found) if walk in meets]


def test_lookup_is_the_enumeration_that_touches(
    made_graph: MotionGraph, made_index: GridIndex
) -> None:
    rng = np.random.default_rng(3)
    counts = np.diff(made_index.node_first)
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
    index = build_index(graph, edge_tables(graph, RATE), horizon=1.0)
    bodies = reference.Bodies(graph, preset_spheres(graph.skeleton), RATE)
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
    busy = np.argsort(np.diff(made_index.node_first))[-200:]
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


def test_capacity_is_said_and_kept(made_graph: MotionGraph, made_index: GridIndex) -> None:
    tables = edge_tables(made_graph, RATE)
    small = build_index(made_graph, tables, horizon=SHORT_S, capacity=8)
    counts = np.diff(small.node_first)
    assert counts.max() <= 8 < np.diff(made_index.node_first).max()
    limited = np.flatnonzero(small.node_limit < SHORT_S * small.half_frames)
    assert 100 < len(limited) == small.report["nodes_limited"] < made_graph.num_nodes
    cells = np.array([[i, j, k] for i in range(-3, 3) for j in range(3, 17) for k in range(-3, 3)])
    found = 0
    for node in [*limited[:60].tolist(), *range(20)]:
        until = (small.node_limit[node] + 1) / small.half_frames
        assert lookup(small, node, cells, until - 0.3 + 1e-6, 0.6) is None
        if until - 0.3 > 0:
            high = min(until, SHORT_S) - 0.3 - 1e-6
            few, all_ = (lookup(i, node, cells, high, 0.6) for i in (small, made_index))
            assert few is not None
            assert all_ is not None
            assert pairs(few) == pairs(all_)
            found += len(few.part)
    assert found > 20


def test_saved_and_loaded(tmp_path: Path) -> None:
    graph = random_graph(1)
    index = build_index(graph, edge_tables(graph, RATE), horizon=0.8)
    save_index(tmp_path, index)
    again = load_index(tmp_path, graph)
    for field in fields(index):
        a, b = getattr(index, field.name), getattr(again, field.name)
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)
        else:
            assert a == b
    assert again.nbytes == index.nbytes > 0


def test_a_stale_or_damaged_index_is_refused(tmp_path: Path) -> None:
    graph = random_graph(1)
    with pytest.raises(FileFormatError, match="no such file"):
        load_index(tmp_path, graph)
    save_index(tmp_path, build_index(graph, edge_tables(graph, RATE), horizon=0.8))
    moved = replace(graph, root_translation=graph.root_translation + np.float32(0.01))
    named = replace(graph, label_starts=graph.label_starts + 0, label_stops=graph.label_stops + 1)
    for other in (random_graph(2), moved, named):
        with pytest.raises(FileFormatError, match=r"another graph, expected .* build it anew$"):
            load_index(tmp_path, other)
    file = tmp_path / "grid_index.safetensors"
    arrays, metadata = load_arrays(file, "grid index")
    worse = {
        "follow": {"follow": arrays["follow"] + np.uint32(9)},
        "short": {"code": arrays["code"][:-1]},
        "first": {"node_first": arrays["node_first"][::-1].copy()},
        "edge": {"edge": arrays["edge"] + np.uint8(100)},
    }
    for change in worse.values():
        save_arrays(file, arrays | change, metadata)
        with pytest.raises(FileFormatError, match="do not fit"):
            load_index(tmp_path, graph)
    save_arrays(file, {k: v for k, v in arrays.items() if k != "masks"}, metadata)
    with pytest.raises(FileFormatError, match="incomplete"):
        load_index(tmp_path, graph)
    save_arrays(file, arrays, metadata | {"format_version": 99})
    with pytest.raises(FileFormatError, match="format 99"):
        load_index(tmp_path, graph)
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(FileFormatError, match="damaged"):
        load_index(tmp_path, graph)


def test_nothing_to_index() -> None:
    graph = make_graph([(0, 1, 15), (1, 0, 30)], [])
    index = build_index(graph, edge_tables(graph, RATE))
    found = lookup(index, 0, np.array([[0, 10, 0]]), 1.0, 1.0)
    assert found is not None
    assert not len(found.part)


def test_same_again_and_without_compiling(made_graph: MotionGraph, made_index: GridIndex) -> None:
    programs = (grid_build._read, grid_parts._gap, grid_parts._sub_points)
    sizes = [program._cache_size() for program in programs]
    tables = edge_tables(made_graph, RATE)
    again = build_index(made_graph, tables, horizon=SHORT_S - 0.1)
    assert [program._cache_size() for program in programs] == sizes
    kept = made_index.time <= (SHORT_S - 0.1) * made_index.half_frames
    assert again.report["paths"] == kept.sum()
    np.testing.assert_array_equal(again.column_count, made_index.column_count[kept])


def test_the_choice_is_as_good_with_the_index(
    made_graph: MotionGraph, made_index: GridIndex, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(4)
    judged: list[int] = []
    real = choice.best_of

    def best_of(*given: Any) -> Settled:
        judged.append(len(given[4].length))
        return real(*given)

    monkeypatch.setattr(choice, "best_of", best_of)
    monkeypatch.setattr(choice, "enumerate_candidates", None)  # the index holds them all
    looked_up = rest = 0
    for node in rng.integers(made_graph.num_nodes, size=24):
        at = np.array([0.0, rng.uniform(0.5, 1.7), 0.0])
        side = rng.uniform(0, 2 * np.pi)
        start = at + 3 * np.array([np.sin(side), 0, np.cos(side)])
        attack = ball_attack(start, at, speed=10.0, arrives=SHORT_S - 0.6)
        config = AvoidanceConfig(checks=8)
        with monkeypatch.context() as plainly:
            plainly.setattr(choice, "enumerate_candidates", enumerate_candidates)
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
        paths = paths_in_time(made_index, node, middle, window)
        assert paths is not None
        assert pairs(walks_of(made_index, paths)) == pairs(wanted)
        count += len(paths)
    assert count > 10
    assert paths_in_time(made_index, 0, SHORT_S, 0.1) is None
