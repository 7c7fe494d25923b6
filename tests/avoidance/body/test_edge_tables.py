from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.body.edge_tables import END_EFFECTORS, EdgeTables, edge_tables
from mgjax.core import planar
from mgjax.core.body.roles import require_roles
from mgjax.core.kinematics import planar_frames
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import unroll
from tests.avoidance.made import make_graph, random_graph
from tests.reference import avoidance as reference
from tests.reference import kinematics


def places(graph: MotionGraph, frame: int) -> np.ndarray:
    skeleton = graph.skeleton
    return kinematics.forward(
        skeleton.parents,
        skeleton.offsets,
        graph.root_translation[frame],
        graph.local_rotations[frame],
    )[0]


def random_walk(graph: MotionGraph, rng: np.random.Generator, length: int) -> list[int]:
    edges = [int(rng.integers(graph.num_edges))]
    while len(edges) < length:
        edges.append(int(rng.choice(graph.edges_from(int(graph.edge_target[edges[-1]])))))
    return edges


def samples(tables: EdgeTables, edge: int) -> np.ndarray:
    """[K,S,3] the stored moments of one edge."""
    first = tables.pool_first[edge]
    rows = tables.pool[first : first + tables.pool_steps[edge] + 1]
    return np.moveaxis(rows.reshape(len(rows), 3, -1), 1, -1)


@pytest.mark.parametrize("rate", [30.0, 10.0, 45.0])
def test_samples_are_the_bodies_of_the_edges(any_graph: MotionGraph, rate: float) -> None:
    tables = edge_tables(any_graph, rate)
    rng = np.random.default_rng(1)
    spheres = tables.spheres
    for edge in rng.choice(any_graph.num_edges, 6, replace=False):
        got = samples(tables, edge)
        frames = any_graph.edge_frames[edge]
        steps = int(np.ceil(frames / any_graph.frame_rate * rate - 1e-6))
        assert len(got) == max(steps, 1) + 1
        plane = reference.inverse(any_graph.node_plane[any_graph.edge_source[edge]])
        for moment in {0, steps // 2, steps}:
            where = min(moment / steps * frames, frames)
            low = min(int(where + 1e-6), frames - 1)
            mixed = []
            for frame in (low, low + 1):
                pose = places(any_graph, any_graph.edge_starts[edge] + frame)
                pose = [kinematics.planar_apply(plane, point) for point in pose]
                mixed.append(
                    reference.sphere_places(spheres.first, spheres.second, spheres.share, pose)
                )
            wanted = (1 - (where - low)) * mixed[0] + (where - low) * mixed[1]
            np.testing.assert_allclose(got[moment], wanted, atol=2e-5)
            # The same through the slow way along a walk.
            seconds = moment / steps * frames / any_graph.frame_rate
            walked = reference.body_at(any_graph, spheres, [int(edge)], [1.0], seconds)
            np.testing.assert_allclose(got[moment], walked, atol=2e-5)


def test_largest_speeds(any_graph: MotionGraph) -> None:
    tables = edge_tables(any_graph, 30.0)
    joints = require_roles(any_graph.skeleton, END_EFFECTORS)
    rng = np.random.default_rng(2)
    short = np.flatnonzero(any_graph.edge_frames <= 12)
    for edge in rng.choice(short, 8, replace=False):
        start, stop = int(any_graph.edge_starts[edge]), int(any_graph.edge_stops[edge])
        fastest = 0.0
        before = places(any_graph, start)
        for frame in range(start + 1, stop + 1):
            now = places(any_graph, frame)
            for joint in joints:
                speed = float(np.linalg.norm(now[joint] - before[joint])) * any_graph.frame_rate
                fastest = max(fastest, speed)
            before = now
        np.testing.assert_allclose(tables.top_speed[edge], fastest, rtol=1e-3, atol=1e-3)


def all_nearest(graph: MotionGraph) -> np.ndarray:
    """Least seconds to the middle of a part, by relaxing every edge until nothing changes."""
    best = np.full(graph.num_nodes, np.inf)
    seconds = graph.edge_frames / graph.frame_rate
    middle = 0.5 * (graph.label_starts + graph.label_stops) - graph.edge_starts[graph.label_edge]
    for _ in range(graph.num_nodes + 1):
        for edge in range(graph.num_edges):
            here = graph.edge_source[edge]
            best[here] = min(best[here], seconds[edge] + best[graph.edge_target[edge]])
            for part in np.flatnonzero(graph.label_edge == edge):
                best[here] = min(best[here], middle[part] / graph.frame_rate)
    return best


@pytest.mark.parametrize("seed", range(5))
def test_nearest_part(seed: int) -> None:
    graph = random_graph(seed, nodes=7, edges=14, parts=2)
    np.testing.assert_allclose(edge_tables(graph, 30.0).nearest_part, all_nearest(graph))


def test_nearest_part_where_there_is_none() -> None:
    # From node 2 nothing leads to the part; of two parallel edges the shorter one counts.
    links = [(0, 1, 20), (0, 1, 6), (1, 0, 12), (2, 2, 5), (0, 2, 3)]
    graph = make_graph(links, [(2, 2, 4)])
    got = edge_tables(graph, 30.0).nearest_part
    np.testing.assert_allclose(got, [6 / 30 + 0.1, 0.1, np.inf])
    bare = make_graph(links, [])
    assert np.isinf(edge_tables(bare, 30.0).nearest_part).all()


def test_parts() -> None:
    graph = make_graph([(0, 1, 20), (1, 0, 30)], [(1, 5, 11), (0, 0, 3), (1, 20, 25)])
    tables = edge_tables(graph, 30.0)
    np.testing.assert_allclose(tables.part_start, np.array([5, 0, 20]) / 30)
    np.testing.assert_allclose(tables.part_stop, np.array([11, 3, 25]) / 30)
    np.testing.assert_allclose(tables.part_centre, np.array([8, 1.5, 22.5]) / 30)
    np.testing.assert_allclose(tables.seconds, np.array([20, 30]) / 30)
    assert [tables.part_ids[a:b].tolist() for a, b in zip(*[tables.part_first[i:] for i in (0, 1)],
            strict=False)] == [[1], [0, 2]]  # fmt: skip


def test_steps_lead_where_the_walk_leads(any_graph: MotionGraph) -> None:
    tables = edge_tables(any_graph, 30.0)
    rng = np.random.default_rng(3)
    for _ in range(5):
        edges = random_walk(any_graph, rng, 8)
        place = np.zeros(3)
        for edge in edges:
            place = reference.compose(place, tables.step[edge])
        motion = unroll(any_graph, edges)
        pose = kinematics.forward(
            any_graph.skeleton.parents,
            any_graph.skeleton.offsets,
            motion.root_translation[-1],
            motion.local_rotations[-1],
        )[0]
        arrived = np.asarray(planar_frames(any_graph.skeleton, pose))
        np.testing.assert_allclose(arrived[1:], place[1:], atol=2e-3)
        turn = (arrived[0] - place[0] + np.pi) % (2 * np.pi) - np.pi
        assert abs(turn) < 2e-3


def test_steps_of_random_exits() -> None:
    graph = random_graph(0)
    tables = edge_tables(graph, 30.0)
    for edge in range(graph.num_edges):
        source = graph.node_plane[graph.edge_source[edge]]
        target = graph.node_plane[graph.edge_target[edge]]
        wanted = reference.compose(
            reference.compose(reference.inverse(source), graph.edge_exit[edge]), target
        )
        np.testing.assert_allclose(tables.step[edge], wanted, atol=1e-6)
        np.testing.assert_allclose(
            planar.compose(wanted, reference.inverse(wanted)), 0.0, atol=1e-9
        )
