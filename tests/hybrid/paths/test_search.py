from __future__ import annotations

import math
from pathlib import Path

import jax
import numpy as np
import pytest

from mgjax.clips.folder import load_clips
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core import planar
from mgjax.core.errors import ConfigError, GraphError, PathError
from mgjax.core.kinematics import global_positions, planar_frames
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.feet.course import MOST_LEAD_M
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import sample_walk
from mgjax.hybrid import follow, make_sketch
from mgjax.hybrid.config import PathConfig
from mgjax.hybrid.macro.macro_edges import MacroEdges, build_macro_edges
from mgjax.hybrid.macro.pieces import NO_PIECE
from mgjax.hybrid.paths.beam import run_beam
from mgjax.hybrid.paths.branch_and_bound import branch_and_bound
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.frontier import Frontier, Search
from mgjax.hybrid.paths.kernel import Request, extension_costs, lower_bounds, make_request
from mgjax.hybrid.paths.result import place_pieces, track_of
from mgjax.hybrid.paths.sketch import Sketch
from tests.hybrid.paths.made import walking
from tests.reference import path as reference

LINE = make_sketch([[0, 0], [0, 4]])
BENT = make_sketch([[1, 1], [1, 2], [2, 3]])


@pytest.fixture(scope="module")
def graph() -> MotionGraph:
    return walking()


def started(
    graph: MotionGraph, sketch: Sketch, config: PathConfig, node: int
) -> tuple[Search, Frontier]:
    curve = make_curve(sketch)
    search = Search(
        macro_edges=build_macro_edges(graph), request=make_request(curve, sketch, config)
    )
    state = np.zeros((1, 5), np.float32)
    state[0, :3] = curve.start()
    return search, search.begin(state, np.array([node]))


def edges_of(graph: MotionGraph, search: Search, record: int, macro_edge: int) -> list[int]:
    pieces = search.macro_edges.pieces
    _, played = search.chain(record, macro_edge)
    return [int(pieces.edge[p]) for p in played if pieces.source[p] < graph.num_nodes]


def walking_nodes(graph: MotionGraph, count: int) -> list[int]:
    """Nodes from which the body moves on at once."""
    tables = build_macro_edges(graph)
    way = np.maximum.reduceat(tables.arc / tables.frames, tables.first[:-1])[: graph.num_nodes]
    return np.argsort(-way)[:: max(len(way) // (3 * count), 1)][:count].tolist()


def test_strides_are_all_walks(graph: MotionGraph) -> None:
    tables = build_macro_edges(graph)
    pieces = tables.pieces
    assert pieces.frames.max() <= tables.delta
    assert (np.bincount(pieces.edge, pieces.frames) == graph.edge_frames).all()
    for stop in range(0, len(pieces.plane), 7):
        expected = set()
        stack: list[tuple[int, tuple[int, ...], int]] = [(stop, (), 0)]
        while stack:
            here, played, frames = stack.pop()
            if frames >= tables.delta:
                expected.add((played, here, frames))
                continue
            for p in pieces.out[pieces.out_first[here] : pieces.out_first[here + 1]].tolist():
                stack.append((int(pieces.target[p]), (*played, p), frames + int(pieces.frames[p])))
        found = {
            (
                tuple(p for p in tables.members[k].tolist() if p != NO_PIECE),
                int(tables.target[k]),
                int(tables.frames[k]),
            )
            for k in range(tables.first[stop], tables.first[stop + 1])
        }
        assert found == expected


def test_tracks_are_those_of_the_edges(graph: MotionGraph) -> None:
    tables = build_macro_edges(graph)
    start = np.array([0.7, 1.0, -2.0])
    for node in walking_nodes(graph, 5):
        macro_edge = int(tables.first[node])
        pieces = [int(p) for p in tables.members[macro_edge] if p != NO_PIECE]
        track = place_pieces(graph, tables.pieces, pieces, start)
        body: tuple[float, float, float] = (0.7, 1.0, -2.0)
        places: list[tuple[float, float]] = []
        for edge in dict.fromkeys(tables.pieces.edge[pieces].tolist()):
            more, body = reference.edge_track(graph, edge, *body)
            places += more
        count = len(track.places)
        np.testing.assert_allclose(track.places, np.array(places)[:count], atol=1e-4)
        own = np.asarray(tables.track)[macro_edge, :2, :count].T
        there = planar.apply(start, np.stack([own[:, 0], 0 * own[:, 0], own[:, 1]], axis=-1))
        np.testing.assert_allclose(np.asarray(there)[:, ::2], track.places, atol=1e-4)
        np.testing.assert_allclose(
            np.asarray(tables.track)[macro_edge, 2, :count], track.arc, atol=1e-4
        )
        end = planar.compose(start, tables.end[macro_edge])
        np.testing.assert_allclose(np.asarray(end), track.end, atol=1e-5)


def test_discs_hold_every_walk(graph: MotionGraph) -> None:
    tables = build_macro_edges(graph)
    rng = np.random.default_rng(0)
    ahead, track = np.asarray(tables.ahead), np.asarray(tables.track)
    for stop in rng.integers(0, len(tables.first) - 1, 40).tolist():
        one = int(rng.integers(tables.first[stop], tables.first[stop + 1]))
        after = int(tables.target[one])
        two = int(rng.integers(tables.first[after], tables.first[after + 1]))
        own = track[one, :3, : tables.frames[one]]
        moved = planar.apply(
            tables.end[one], np.stack([track[two, 0], 0 * track[two, 0], track[two, 1]], axis=-1)
        )
        rest = np.stack(
            [np.asarray(moved)[:, 0], np.asarray(moved)[:, 2], track[two, 2] + own[2, -1]]
        )
        way = np.concatenate([own, rest], axis=1)[:, : 2 * tables.delta]
        disc = ahead[stop, :, : way.shape[1]]
        off = np.linalg.norm(way[:2] - disc[:2], axis=0) + np.abs(way[2] - disc[2])
        assert (off <= disc[3] + 1e-4).all()


def extended(
    tables: MacroEdges, request: Request, arrays: tuple[np.ndarray, ...], count: int
) -> np.ndarray:
    padded = [
        np.concatenate([x, np.zeros((count - len(x), *x.shape[1:]), x.dtype)]) for x in arrays
    ]
    return np.asarray(extension_costs(tables.track, tables.speed_heading, request, *padded))[
        :, : len(arrays[0])
    ]


def test_extension_by_loops(graph: MotionGraph) -> None:
    """Costs, completion and strays are those of plain loops; padding and jit change nothing."""
    tables = build_macro_edges(graph)
    config = PathConfig(near_m=0.5)
    for sketch in (LINE, make_sketch([[1, 1], [1, 1.6]])):
        curve = make_curve(sketch)
        request = make_request(curve, sketch, config)
        nodes = walking_nodes(graph, 4)
        macro_edges = np.concatenate(
            [np.arange(tables.first[n], tables.first[n + 1]) for n in nodes]
        )
        macro_edges = macro_edges[:60].astype(np.int32)
        state = np.zeros((len(macro_edges), 5), np.float32)
        state[:, :3] = curve.start()
        frames = np.stack([tables.frames[macro_edges], np.full(len(macro_edges), 12)], axis=1)
        frames = frames.astype(np.int32)

        arrays = (state, macro_edges, frames)
        costs = extended(tables, request, arrays, 256)
        np.testing.assert_array_equal(costs, extended(tables, request, arrays, 768))
        with jax.disable_jit():
            eager = extended(tables, request, arrays, 256)
        np.testing.assert_allclose(costs, eager, rtol=1e-5, atol=1e-7)
        seen = set()
        for i, macro_edge in enumerate(macro_edges.tolist()):
            pieces = tables.members[macro_edge]
            edges = list(dict.fromkeys(tables.pieces.edge[pieces[pieces != NO_PIECE]].tolist()))
            expected, count, complete = reference.walk_cost(
                graph, edges, sketch.points, curve.start(), int(frames[i].min()), 1.0, 0.5
            )
            seen.add((complete, expected < math.inf))
            value = costs[1, i] if complete else costs[0, i]
            np.testing.assert_allclose(value, expected, rtol=1e-3, atol=2e-5)
            assert complete == (costs[1, i] < math.inf)
            if complete:
                assert (int(costs[2, i]), costs[0, i]) == (count, math.inf)
        assert (False, True) in seen


def test_bound_is_admissible(graph: MotionGraph) -> None:
    tables = build_macro_edges(graph)
    search, frontier = started(graph, BENT, PathConfig(near_m=3.0), walking_nodes(graph, 1)[0])
    rng = np.random.default_rng(1)
    for _ in range(4):
        frontier = search.expand(frontier, 1000, math.inf)[0]
        rows = rng.permutation(len(frontier.stop))[:20]
        frontier = frontier.pick(rows)
        frontier.state[:, :3] += rng.normal(0, [0.3, 0.1, 0.1], (len(rows), 3)).astype(np.float32)
        horizon = int(frontier.frames.max()) + 15
        least = search.bounds(frontier, horizon)
        for i in range(len(rows)):
            one = frontier.pick(slice(i, i + 1))
            costs = [math.inf]
            walks = one
            while len(walks.stop):
                walks, complete, reached = search.expand(walks, horizon, math.inf)
                costs += [terminal.cost for terminal in (complete, reached) if terminal is not None]
            assert least[i] <= min(costs) + 1e-5
    assert least.max() > frontier.state[:, 4].min()
    ahead = tables.ahead
    with jax.disable_jit():
        arrays = (
            frontier.state,
            frontier.stop.astype(np.int32),
            (horizon - frontier.frames).astype(np.int32),
        )
        np.testing.assert_allclose(
            least - frontier.state[:, 4],
            lower_bounds(ahead, search.request, *arrays),
            rtol=1e-4,
            atol=1e-6,
        )


@pytest.mark.parametrize("blend_weight", [0.0, 1.0])
@pytest.mark.parametrize(
    ("sketch", "horizon"), [(LINE, 30), (BENT, 38), (make_sketch([[0, 0], [0, 1]]), 45)]
)
def test_optimum_is_that_of_all_walks(
    graph: MotionGraph, sketch: Sketch, horizon: int, blend_weight: float
) -> None:
    config = PathConfig(blend_weight=blend_weight, near_m=0.6)
    curve = make_curve(sketch)
    compared = 0
    for node in walking_nodes(graph, 6):
        expected, _ = reference.exhaustive(
            graph, node, sketch.points, curve.start(), horizon, blend_weight, 0.6
        )
        search, begin = started(graph, sketch, config, node)
        terminal, proven, over = branch_and_bound(search, begin, horizon=horizon, expansions=10**6)
        assert (proven, over) == (True, False)
        if terminal is None:
            assert expected == math.inf
            continue
        compared += 1
        edges = edges_of(graph, search, terminal.record, terminal.macro_edge)
        cost, count, complete = reference.walk_cost(
            graph, edges, sketch.points, curve.start(), horizon, blend_weight, 0.6
        )
        assert cost == pytest.approx(expected, rel=1e-3, abs=2e-5)
        assert terminal.cost == pytest.approx(expected, rel=1e-2, abs=5e-5)  # P is read to 0.5 mm
        assert (count, complete) == (terminal.frames, terminal.complete)
        # A beam is never better, and as a walk to beat it does not change the optimum.
        search, begin = started(graph, sketch, config, node)
        beam = run_beam(search, begin, width=8, horizon=horizon)
        again, proven, _ = branch_and_bound(
            search, begin, horizon=horizon, best=beam.best, expansions=10**6
        )
        assert proven
        assert again is not None
        assert again.cost == pytest.approx(terminal.cost, rel=1e-6)
        assert beam.best is None or beam.best.cost >= terminal.cost - 1e-6
    assert compared >= 2


@pytest.mark.parametrize("method", ["beam", "exact"])
def test_follows(graph: MotionGraph, method: str) -> None:
    config = PathConfig(method=method)
    result = follow(graph, BENT, config=config)
    assert result.status == "followed"
    assert result.failed_at is None
    assert result.mean_distance < 0.15
    assert result.track.arc[-1] == pytest.approx(make_curve(BENT).length, abs=0.1)
    # What is reported is what is in the motion.
    positions = np.asarray(global_positions(graph.skeleton, result.motion), dtype=np.float64)
    assert len(positions) == result.frames + 1
    np.testing.assert_allclose(positions[1:, 0, ::2], result.track.places, atol=1e-4)
    bodies = np.asarray(planar_frames(graph.skeleton, positions))
    np.testing.assert_allclose(bodies[0], result.start, atol=1e-4)
    expected, count, complete = reference.walk_cost(
        graph, result.walk.edges.tolist(), BENT.points, result.start, 10**6, 0.0, math.inf
    )
    times = np.arange(result.frames + 1) / graph.frame_rate
    captured = sample_walk(graph, result.walk, times, start=result.start)
    track = track_of(graph, captured, result.track.blend)
    error = track.squares(make_curve(BENT)).sum()
    assert error == pytest.approx(expected, rel=0.03)  # seams are a few mm off
    # In the motion itself the root also follows the feet that are kept.
    led = np.linalg.norm(result.track.places - track.places, axis=1)
    assert led.max() < 1.2 * graph.body_scale * MOST_LEAD_M
    assert result.error == pytest.approx(result.track.squares(make_curve(BENT)).sum())
    assert (count, complete) == (result.frames, True)
    assert 0 <= result.slide < 0.02
    if method == "exact":
        assert 1 <= result.proven <= result.windows
    again = follow(graph, BENT, config=config)
    assert again.walk.edges.tolist() == result.walk.edges.tolist()


def test_from_a_node_and_a_place(graph: MotionGraph) -> None:
    node = walking_nodes(graph, 1)[0]
    start = np.array([0.2, 0.1, 0.0])
    result = follow(graph, LINE, config=PathConfig(method="beam"), node=node, start=start)
    assert graph.edge_source[result.walk.edges[0]] == node
    np.testing.assert_array_equal(result.start, start)


def test_wanted_speed() -> None:
    graph = walking(("walk", "walk_curve", "steps", "turns"), 5)
    speeds = {}
    for speed in (0.4, 1.1):
        result = follow(
            graph, make_sketch([[0, 0], [0, 3]], speed=speed), config=PathConfig(speed_weight=1.0)
        )
        speeds[speed] = result.track.speed.mean()
    assert speeds[0.4] < speeds[1.1] - 0.1


def test_obstacles_and_end() -> None:
    graph = walking(("walk", "walk_curve", "steps", "turns"), 5)
    sketch = make_sketch([[0, 0], [0, 4]], obstacles=[[0.2, 2.0, 0.1]], end=(0.0, 4.0, math.nan))
    result = follow(graph, sketch, config=PathConfig(method="beam", beam_width=512))
    off = np.linalg.norm(result.track.places - [0.2, 2.0], axis=1)
    assert result.status == "followed"
    assert off.min() >= 0.4 - 1e-3
    assert result.end_off[0] < 0.3
    assert math.isnan(result.end_off[1])
    free = follow(graph, make_sketch([[0, 0], [0, 4]]), config=PathConfig(method="beam"))
    assert np.linalg.norm(free.track.places - [0.2, 2.0], axis=1).min() < 0.4


@pytest.mark.parametrize("method", ["beam", "exact"])
def test_cannot_be_followed(graph: MotionGraph, method: str) -> None:
    sketch = make_sketch([[0, 0], [0, 3]], obstacles=[[0, 2.4, 1.2]])
    result = follow(graph, sketch, config=PathConfig(method=method))
    assert result.status == "lost"
    assert result.failed_at is not None
    assert result.failed_s is not None
    assert 0 < result.failed_s < 1.5
    np.testing.assert_allclose(result.failed_at, [0, result.failed_s])
    assert result.track.places[-1, 1] == pytest.approx(result.failed_s, abs=0.05)
    assert len(result.distance) == result.frames


def test_time_limit(graph: MotionGraph) -> None:
    result = follow(graph, LINE, config=PathConfig(time_limit_s=1e-9))
    assert (result.status, result.interrupted) == ("time_limit", True)
    result = follow(graph, LINE, config=PathConfig(method="beam", beam_width=1, time_limit_s=60.0))
    assert (result.status, result.interrupted) == ("followed", False)


def test_bad_requests(graph: MotionGraph) -> None:
    with pytest.raises(ConfigError, match="node"):
        follow(graph, LINE, node=10**6)
    with pytest.raises(ConfigError, match="beam_width"):
        follow(graph, LINE, config=PathConfig(beam_width=0))
    with pytest.raises(PathError, match="begins 5"):
        follow(graph, LINE, start=np.array([0.0, 5.0, 0.0]))
    with pytest.raises(PathError, match="obstacle"):
        follow(graph, make_sketch([[0, 0], [0, 3]], obstacles=[[0, 0.2, 0.1]]))


def test_without_locomotion() -> None:
    clips = [clip for clip in synthetic_clips()[0] if clip.name in ("stance", "duck")]
    standing = build_graph(clips, config=GraphConfig(threshold_m=0.05, neighbourhood=10))
    with pytest.raises(GraphError, match="without locomotion"):
        follow(standing, LINE)


def test_real_capture(capture: Path) -> None:
    clips, _ = load_clips(capture / "locomotion" / "cmu16")
    graph = build_graph(clips, config=GraphConfig(neighbourhood=5))
    angle = np.linspace(0, 2 * np.pi, 33)[:-1]
    circle = np.stack([3 - 3 * np.cos(angle), 3 * np.sin(angle)], axis=-1)
    for sketch in (make_sketch([[0, 0], [0, 10]]), make_sketch(circle, closed=True, spline=True)):
        result = follow(graph, sketch, config=PathConfig(method="beam"))
        assert result.status == "followed"
        assert result.mean_distance < 0.1
        assert result.slide < 0.01
