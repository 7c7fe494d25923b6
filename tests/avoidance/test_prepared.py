"""The state that searches share: explicit or kept, the same answers, and gone with its graph."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance import build_index, choose, prepare, select, select_batch
from mgjax.avoidance import prepared as module
from mgjax.avoidance.config import AvoidanceConfig, SpeedConfig
from mgjax.avoidance.prepared import prepared_for
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.errors import ConfigError, GraphError
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph
from tests.avoidance.made import make_graph, throw
from tests.sized import graph_of_size

CONFIG = AvoidanceConfig()


def test_explicit_and_kept_state_answer_alike(made_graph: MotionGraph) -> None:
    prepared = prepare(made_graph, CONFIG)
    rng = np.random.default_rng(2)
    for _ in range(3):
        node, attack = int(rng.integers(made_graph.num_nodes)), throw(rng)
        kept = choose(made_graph, node, attack, config=CONFIG)
        given = choose(prepared, node, attack, config=CONFIG)
        assert (given.status, given.energy, given.dropped) == (
            kept.status,
            kept.energy,
            kept.dropped,
        )
        np.testing.assert_array_equal(given.walk.edges, kept.walk.edges)
    written = select(prepared, node, attack), select(made_graph, node, attack)
    np.testing.assert_array_equal(*(s.motion.local_rotations for s in written))
    both = (select_batch(g, [node], [attack]) for g in (prepared, made_graph))
    assert len({tuple(answers.clearance.tolist()) for answers in both}) == 1


def test_the_settings_it_was_made_for(made_graph: MotionGraph) -> None:
    prepared = prepare(made_graph, CONFIG)
    attack = throw(np.random.default_rng(0))
    for other, text in (
        (replace(CONFIG, body_rate=10.0), r"got body_rate = 10.0, expected 30.0"),
        (replace(CONFIG, speed=SpeedConfig(V_slow=1.0)), "which the graph is prepared for"),
        (replace(CONFIG, culling="binned"), "prepared without slices"),
    ):
        with pytest.raises(ConfigError, match=text):
            choose(prepared, 0, attack, config=other)
    assert prepare(small(), replace(CONFIG, culling="binned")).slices is not None


def small() -> MotionGraph:
    return make_graph([(0, 1, 30), (1, 0, 20)], [(0, 6, 12)], sway=0.01)


def test_its_memory_goes_with_the_graph() -> None:
    graph = small()
    prepared = prepared_for(graph, replace(CONFIG, culling="paper"))
    assert prepared.slices is not None
    arrays = [prepared.tables.pool, prepared.device.pool, prepared.posed.poses.rotations]
    dead = [weakref.ref(x) for x in (graph, prepared.tables, prepared.device, *arrays)]
    choose(graph, 0, throw(np.random.default_rng(1)), config=CONFIG)
    del graph, prepared, arrays
    gc.collect()
    assert [reference() for reference in dead] == [None] * len(dead)


def test_six_graphs_in_turn_are_prepared_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[MotionGraph] = []
    real = module._make

    def count(graph: MotionGraph, config: AvoidanceConfig) -> object:
        made.append(graph)
        return real(graph, config)

    monkeypatch.setattr(module, "_make", count)
    graphs = [small() for _ in range(6)]
    for _ in range(3):
        for graph in graphs:
            prepared_for(graph, CONFIG)
    assert len(made) == 6
    first, again = (prepared_for(graphs[0], CONFIG) for _ in range(2))
    assert first.device is again.device
    assert isinstance(first.device.pool, jax.Array)


def test_the_index_of_another_graph(made_graph: MotionGraph) -> None:
    other = graph_of_size(made_graph, 2.0)
    index = build_index(other, horizon=0.5)
    attack = throw(np.random.default_rng(0))
    for searched in (made_graph, prepare(made_graph)):
        with pytest.raises(ConfigError, match="got the index of another graph, expected"):
            select(searched, 0, attack, index=index)
    with pytest.raises(ConfigError, match="got the index of another graph, expected"):
        prepare(made_graph, index=index)


def test_a_graph_without_avoidance_parts() -> None:
    clips, _ = synthetic_clips()
    graph = build_graph(clips[:2], config=GraphConfig(threshold_m=0.05))
    with pytest.raises(GraphError, match="got a graph without avoidance parts, expected labelled"):
        select(graph, 0, throw(np.random.default_rng(0)))
