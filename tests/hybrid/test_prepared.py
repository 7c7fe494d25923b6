"""The state of the room: explicit, of one graph, and gone with it."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest

import mgjax.hybrid
import mgjax.hybrid.prepared as module
from mgjax.core.errors import ConfigError
from mgjax.graph.types import MotionGraph
from mgjax.hybrid import PathConfig, ReachConfig, follow, make_sketch, make_target, prepare, reach
from mgjax.hybrid.prepared import prepared_for
from tests.hybrid.paths.made import walking

LINE = make_sketch([[0, 0], [0, 2]])
BEAM = PathConfig(method="beam")


@pytest.fixture(scope="module")
def graph() -> MotionGraph:
    return walking()


def test_passed_state_gives_the_same_walk(graph: MotionGraph) -> None:
    assert mgjax.hybrid.prepare is prepare
    own = follow(graph, LINE, config=BEAM, prepared=prepare(graph))
    kept = follow(graph, LINE, config=BEAM)
    np.testing.assert_array_equal(own.walk.edges, kept.walk.edges)
    np.testing.assert_array_equal(own.motion.local_rotations, kept.motion.local_rotations)
    assert own.plants.shape == (own.frames + 1, 2)


def test_state_of_another_graph_is_refused(graph: MotionGraph) -> None:
    with pytest.raises(ConfigError, match="another graph"):
        follow(graph, LINE, config=BEAM, prepared=prepare(replace(graph)))


def test_state_that_lacks_the_body_is_refused(graph: MotionGraph) -> None:
    target = make_target("head", place=[0, 1.5, 1], when="passing")
    with pytest.raises(ConfigError, match="walking alone"):
        reach(graph, LINE, (target,), path=BEAM, prepared=prepare(graph))
    loose = prepare(graph, ReachConfig(limits=False))
    with pytest.raises(ConfigError, match="without limits"):
        prepared_for(graph, ReachConfig(), loose)
    assert prepared_for(graph, ReachConfig(limits=False), loose) is loose


def test_memory_goes_with_the_graph(graph: MotionGraph) -> None:
    copy = replace(graph, root_translation=graph.root_translation.copy())
    state = prepared_for(copy, ReachConfig())
    limits = state.reach_body.limits
    assert limits is not None
    parts = (copy, state, state.plants, state.macro_edges.end, state.macro_edges, limits)
    dead = [weakref.ref(part) for part in parts]
    del copy, state, limits, parts
    gc.collect()
    assert [reference() for reference in dead] == [None] * len(dead)


def test_six_graphs_in_turn_are_prepared_once(
    graph: MotionGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    built = []
    real = module.build_macro_edges
    monkeypatch.setattr(module, "build_macro_edges", lambda g: built.append(id(g)) or real(g))
    graphs = [replace(graph) for _ in range(6)]
    for _ in range(3):
        for one in graphs:
            prepared_for(one)
            prepared_for(one, ReachConfig())
    assert len(built) == 6
