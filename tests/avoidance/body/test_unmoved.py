"""What is played without a reaction."""

from __future__ import annotations

import numpy as np

from mgjax.avoidance.body.edge_tables import edge_tables
from mgjax.avoidance.body.unmoved import (
    bodies_onward,
    edges_onward,
    spheres_onward,
    walk_onward,
)
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.graph.walk import make_walk
from tests.reference import avoidance as reference


def test_the_clip_goes_on_as_long_as_it_can(any_graph: MotionGraph) -> None:
    onward = edges_onward(any_graph)
    rng = np.random.default_rng(0)
    for node in rng.choice(any_graph.num_nodes, 12, replace=False).tolist():
        walk = walk_onward(any_graph, onward, node, 1.7)
        assert walk.edges.tolist() == reference.edges_onward(any_graph, node, 1.7)
        make_walk(any_graph, walk.edges)  # each begins where the last ends
        assert walk.starts(any_graph)[-2] < 1.7 <= walk.starts(any_graph)[-1]
    ends = [
        node
        for node in range(any_graph.num_nodes)
        if (any_graph.edge_clip[any_graph.edges_from(node)] == NO_CLIP).all()
    ]
    assert ends, "some clip ends"
    for node in ends[:5]:
        assert onward[node] == any_graph.edges_from(node)[0]


def test_the_body_is_that_of_the_walk(any_graph: MotionGraph) -> None:
    tables = edge_tables(any_graph, 10.0)
    times = np.array([0.11, 0.5, 1.3])
    rng = np.random.default_rng(1)
    for node in rng.choice(any_graph.num_nodes, 3, replace=False).tolist():
        got = spheres_onward(any_graph, tables.onward, tables.spheres, node, times)
        edges = reference.edges_onward(any_graph, node, times[-1])
        for moment, time in enumerate(times):
            wanted = reference.body_at(any_graph, tables.spheres, edges, [1.0] * len(edges), time)
            np.testing.assert_allclose(got[moment], wanted, atol=1e-4)


def test_many_bodies_are_what_each_is_alone(any_graph: MotionGraph) -> None:
    tables = edge_tables(any_graph, 10.0)
    rng = np.random.default_rng(2)
    nodes = rng.choice(rng.integers(any_graph.num_nodes, size=12), 40)
    times = np.sort(rng.uniform(-0.1, 2.0, (40, 4)), axis=1)
    got = bodies_onward(any_graph, tables.onward, tables.spheres, nodes, times)
    for body, node, own in zip(got, nodes.tolist(), times, strict=True):
        wanted = spheres_onward(any_graph, tables.onward, tables.spheres, node, own)
        np.testing.assert_allclose(np.moveaxis(body, 0, 2), wanted, rtol=0, atol=1e-12)
