from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.avoidance.graphs import with_parts
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.coverage.connected import answers_to, avoidable_cells, connected
from mgjax.avoidance.coverage.throws import Coverage, measure_coverage
from mgjax.avoidance.many.attacks import select_batch
from mgjax.avoidance.prepared import prepared_for
from mgjax.graph.types import MotionGraph
from tests.avoidance.coverage.test_throws import AVOIDED, HIT, SMALL, made


@pytest.fixture(scope="module")
def small(made_graph: MotionGraph) -> Coverage:
    return measure_coverage(made_graph, **SMALL)


def test_avoidable_cells_by_hand() -> None:
    # Ahead and low nine of ten, ahead and high eight of nine, behind and low one of one.
    status = [AVOIDED] * 9 + [HIT] + [AVOIDED] * 8 + [HIT, AVOIDED]
    found = made(status, [0] * 19 + [1], [0] * 10 + [1] * 9 + [0])
    assert avoidable_cells(found) == pytest.approx(2 / 3)


def test_parts_are_those_that_could_avoid(made_graph: MotionGraph, small: Coverage) -> None:
    """A part that alone avoids a ball is counted for it."""
    config = AvoidanceConfig(T_wide=0.0, refine="off")
    few = with_parts(made_graph, np.arange(3))
    balls = np.arange(2, len(small), 5)
    answers = answers_to(prepared_for(few, config), small, balls, config)
    alone = np.zeros((3, len(balls)), bool)
    for part in range(3):
        prepared = prepared_for(with_parts(few, np.array([part])), config)
        answered = select_batch(
            prepared, small.node[balls], [thrown(small, i) for i in balls], config=config
        )
        alone[part] = answered.status == AVOIDED
    assert (answers.parts >= alone.sum(axis=0)).all()
    assert answers.parts.max() <= 3
    assert alone.any()


def thrown(result: Coverage, number: int) -> Attack:
    return ball_from(
        float(result.directions[result.direction[number]]),
        float(result.heights[result.height[number]]),
        speed=result.speed,
        arrives=float(result.arrivals[result.arrival[number]]),
    )


def test_connected(made_graph: MotionGraph, small: Coverage) -> None:
    found = connected(made_graph, small, sampled=12)
    assert found["sampled_balls"] == 12
    assert (
        0
        <= found["clear_parts"]["p10"]
        <= found["clear_parts"]["p50"]
        <= len(made_graph.label_edge)
    )
    assert 0 < found["dead_frames"] < 1
    assert found == connected(made_graph, small, sampled=12)
    more = connected(made_graph, small, sampled=36)
    assert more["dead_frames"] <= 1
    assert more["avoidable_cells"] == round(avoidable_cells(small), 4)
    assert more["time_to_part_s"] == made_graph.report["connectivity"]["time_to_part_s"]
    assert avoidable_cells(replace(small, answers=replace(
        small.answers, status=np.full(len(small), AVOIDED)))) == 1.0  # fmt: skip
