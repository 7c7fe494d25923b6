from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.avoidance import AvoidanceConfig, choose, prepare, select_batch
from mgjax.avoidance.choice.choosing import paths_in_time
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.index.index import GridIndex
from mgjax.avoidance.many.attacks import NO_PART
from mgjax.graph.types import MotionGraph
from tests.avoidance.many.test_attacks import questions


def test_looked_up_as_one_by_one(made_graph: MotionGraph, made_index: GridIndex) -> None:
    config = AvoidanceConfig(refine="off")
    nodes, balls = questions(made_graph, 12)
    # Early enough for the horizon of the index, the last ones too late for it.
    early = [replace(ball, times=ball.times - 0.4) for ball in balls[:9]]
    balls = [*early, *balls[9:]]
    prepared = prepare(made_graph, config, index=made_index)
    got = select_batch(made_graph, nodes, balls, config=config, index=made_index)
    same = select_batch(prepared, nodes, balls, config=config)
    np.testing.assert_array_equal(got.part, same.part)
    looked_up = 0
    for i, (node, ball) in enumerate(zip(nodes, balls, strict=True)):
        wanted = choose(prepared, int(node), ball, config=config)
        assert tuple(Status)[got.status[i]] == wanted.status
        assert got.candidates[i] == wanted.candidates
        assert got.part[i] == (NO_PART if wanted.part is None else wanted.part)
        query = ask(prepared, int(node), ball, config)
        looked_up += query is not None and paths_in_time(query) is not None
    assert 0 < looked_up < 12
