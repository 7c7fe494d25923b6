from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mgjax.avoidance import choose
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.coverage.report import COMPASS, bearing, coverage_report
from mgjax.avoidance.coverage.shares import cells, interval, outcomes, shares, worst_cells
from mgjax.avoidance.coverage.throws import NO_KIND, Coverage, measure_coverage
from mgjax.avoidance.many.attacks import (
    NO_PART,
    BatchSelection,
)
from mgjax.core.errors import AttackError, ConfigError, GraphError
from mgjax.graph.types import MotionGraph
from mgjax.pictures.coverage import coverage_figure

SMALL: dict[str, Any] = {
    "directions": 4, "heights": (1.4, 0.3), "arrivals": (1.2, 0.9), "nodes": 9, "seed": 3,
}  # fmt: skip
AVOIDED, HIT, NO_CANDIDATE, PARRIED = (status.code for status in Status)


def settings(**changes: Any) -> dict[str, Any]:
    return SMALL | changes


@pytest.fixture(scope="module")
def small(made_graph: MotionGraph) -> Coverage:
    return measure_coverage(made_graph, **SMALL)


def made(
    status: list[int], direction: list[int], height: list[int], *, directions: int = 2
) -> Coverage:
    """A coverage with given answers, all at one node."""
    count = len(status)
    numbers = np.array(status)
    nothing = np.full(count, np.nan)
    return Coverage(
        directions=2 * np.pi * np.arange(directions) / directions,
        heights=np.array([0.5, 1.5]),
        arrivals=np.array([1.2]),
        speed=10.0,
        window=1.0,
        node=np.zeros(count, np.int64),
        direction=np.array(direction),
        height=np.array(height),
        arrival=np.zeros(count, np.int64),
        answers=BatchSelection(
            status=numbers,
            part=np.where(numbers == AVOIDED, 0, NO_PART),
            candidates=np.where(numbers == NO_CANDIDATE, 0, 5),
            time_scale=nothing, clearance=nothing, energy=nothing, d=nothing, t_attack=nothing,
        ),
        kinds=("duck",),
        kind=np.where(numbers == AVOIDED, 0, NO_KIND),
        nearest_part=np.array([0.5, 2.0, np.inf]),
    )  # fmt: skip


def test_balls_are_dealt_evenly(small: Coverage) -> None:
    assert len(small) == 36
    np.testing.assert_allclose(small.directions, [0, np.pi / 2, np.pi, 1.5 * np.pi])
    np.testing.assert_array_equal(small.heights, [0.3, 1.4])
    np.testing.assert_array_equal(small.arrivals, [0.9, 1.2])
    nodes, counts = np.unique(small.node, return_counts=True)
    assert len(nodes) == 9
    assert set(counts) == {4}
    for direction in range(4):
        here = small.direction == direction
        assert len(np.unique(small.node[here])) == 9
        pairs = np.bincount(small.height[here] + 2 * small.arrival[here], minlength=4)
        assert pairs.min() >= 2
        assert pairs.max() <= 3


def test_answers_are_those_of_single_choices(made_graph: MotionGraph, small: Coverage) -> None:
    config = AvoidanceConfig(refine="off")
    for i in range(0, len(small), 3):
        ball = ball_from(
            float(small.directions[small.direction[i]]),
            float(small.heights[small.height[i]]),
            arrives=float(small.arrivals[small.arrival[i]]),
            speed=10.0,
        )
        wanted = choose(made_graph, int(small.node[i]), ball, config=config)
        assert tuple(Status)[small.answers.status[i]] == wanted.status
        assert small.answers.candidates[i] == wanted.candidates
        avoided = wanted.status == "avoided" and wanted.part is not None
        kind = made_graph.label_kind[wanted.part or 0] if avoided else None
        assert kind == (None if small.kind[i] == NO_KIND else small.kinds[small.kind[i]])


def test_directions_turn_to_the_left() -> None:
    # Ahead is +z, the left +x; at the axis 1.2 s from now.
    ball = ball_from(np.pi / 2, 0.7, arrives=1.2, speed=10.0)
    np.testing.assert_allclose(ball.centres[0, 0], [5.0, 0.7, 0.0], atol=1e-9)
    np.testing.assert_allclose(ball.at(np.array([1.2]))[0, 0], [0.0, 0.7, 0.0], atol=1e-9)
    assert [bearing(np.radians(x)) for x in (0, 45, 180, 270, 337.5)] == [
        *("ahead", "45° to the left", "behind", "90° to the right", "22.5° to the right")
    ]


def test_report_counts(made_graph: MotionGraph, small: Coverage) -> None:
    found = coverage_report(made_graph, small)
    status = small.answers.status
    total = found["all"]
    assert total["attacks"] == found["attacks"] == 36
    assert total["avoided"] == round(float((status == AVOIDED).mean()), 4)
    assert total["avoided"] + total["hit"] + total["no_candidate"] == pytest.approx(1, abs=1e-3)
    assert sum(total["kinds"].values()) == pytest.approx(total["avoided"], abs=1e-3)
    assert sum(row["attacks"] for row in found["arrivals"]) == 36
    assert sum(row["attacks"] for row in found["clips"]) == 36
    for d in range(4):
        for h in range(2):
            here = [i for i in range(36) if small.direction[i] == d and small.height[i] == h]
            share = sum(status[i] == HIT for i in here) / len(here)
            assert found["cells"]["hit"][d][h] == round(share, 4)
    # Four directions lie on four points of the compass, the heights in two bands.
    assert {row["from"] for row in found["regions"]} == set(COMPASS[::2])
    assert {row["band"] for row in found["regions"]} == {"low", "high"}
    ranked = [row["avoided"] for row in found["directions"]]
    assert ranked == sorted(ranked)


def test_nodes_out_of_reach(made_graph: MotionGraph, small: Coverage) -> None:
    # Put three nodes of one clip far from any part, and a fourth after one that is near.
    order = np.flatnonzero(made_graph.node_clip == made_graph.node_clip[0])
    order = order[np.argsort(made_graph.node_frame[order])]
    nearest = np.full(made_graph.num_nodes, 0.4)
    nearest[order[[2, 3, 4, 6]]] = [2.0, np.inf, 1.9, 2.19]
    changed = replace(small, nearest_part=nearest)
    early, late = coverage_report(made_graph, changed)["out_of_reach"]
    assert (early["within_s"], early["nodes"]) == (1.9, 4)  # half of T_wide more
    assert [row["nodes"] for row in early["stretches"]] == [order[2:5].tolist(), [int(order[6])]]
    row = early["stretches"][0]
    assert row["clip"] == made_graph.clip_names[made_graph.node_clip[0]]
    offset = int(made_graph.clip_starts[made_graph.node_clip[0]])
    frames = (made_graph.node_frame[order[[2, 4]]] - offset).tolist()
    assert row["frames"] == frames
    assert row["seconds"] == pytest.approx([f / made_graph.frame_rate for f in frames], abs=1e-3)
    assert row["nearest_part_s"] is None
    assert early["stretches"][1]["nearest_part_s"] == 2.19
    assert (late["within_s"], late["nodes"]) == (2.2, 1)


def test_shares_by_hand() -> None:
    # Ahead and low: one of two avoided; behind and high: one hit; the rest has no ball.
    found = made([AVOIDED, NO_CANDIDATE, HIT], [0, 0, 1], [0, 0, 1])
    got = cells(found, outcomes(found)["avoided"])
    np.testing.assert_array_equal(got, [[0.5, np.nan], [np.nan, 0.0]])
    assert interval(0.8, 10) == [0.4902, 0.9433]
    assert interval(0.0, 5)[0] == 0.0
    # What is parried is told apart, and is no avoidance.
    met = made([AVOIDED, PARRIED, HIT, HIT], [0, 0, 1, 1], [0, 0, 1, 1])
    told = shares(met, np.ones(4, bool))
    assert (told["avoided"], told["parried"], told["hit"]) == (0.25, 0.25, 0.5)
    assert outcomes(met)["parried"].tolist() == [False, True, False, False]


def test_attacks_at_one_node_count_less() -> None:
    # Four nodes with ten balls each. All alike at a node: four outcomes, less one degree of freedom
    # for the mean; mixed: each ball counts.
    node, direction = np.repeat(np.arange(4), 10), [0] * 40
    alike = replace(made([AVOIDED] * 20 + [HIT] * 20, direction, direction), node=node)
    mixed = replace(made([AVOIDED, HIT] * 20, direction, direction), node=node)
    everything = np.ones(40, bool)
    assert shares(alike, everything)["avoided_interval"] == interval(0.5, 3)
    assert shares(mixed, everything)["avoided_interval"] == interval(0.5, 40)
    none = replace(made([HIT] * 40, direction, direction), node=node)
    assert shares(none, everything)["avoided_interval"] == interval(0.0, 4)


def test_worst_cells_are_not_bad_luck() -> None:
    # 40 balls each: 90, 90, 45 and 10 % avoided; 58.75 % of all. The third is below, not clearly.
    counts = (36, 36, 18, 4)
    status = [AVOIDED if i < count else HIT for count in counts for i in range(40)]
    direction = [0] * 80 + [1] * 80
    height = ([0] * 40 + [1] * 40) * 2
    found = made(status, direction, height)
    assert interval(18 / 40, 40)[1] > 94 / 160
    assert worst_cells(found) == [(1, 1)]


def test_same_seed_same_answers(made_graph: MotionGraph, small: Coverage) -> None:
    again = measure_coverage(made_graph, **SMALL)
    assert coverage_report(made_graph, again) == coverage_report(made_graph, small)
    other = measure_coverage(made_graph, **settings(seed=4))
    assert (other.node != small.node).any()


def test_more_nodes_than_there_are(made_graph: MotionGraph) -> None:
    nodes = made_graph.num_nodes + 2
    one = settings(directions=1, heights=[1.4], arrivals=[0.2], nodes=nodes)
    found = measure_coverage(made_graph, **one)
    counts = np.bincount(found.node)
    assert counts.min() == 1
    assert (counts == 2).sum() == 2


def test_figures_of_few_and_many(made_graph: MotionGraph, small: Coverage) -> None:
    figure = coverage_figure(made_graph, small)
    figure.canvas.draw()
    lonely = made([HIT], [0], [0], directions=1)
    lonely = replace(lonely, nearest_part=np.full(made_graph.num_nodes, np.inf))
    coverage_figure(made_graph, lonely).canvas.draw()
    coverage_report(made_graph, lonely)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"directions": 0}, "got 0 directions, expected at least 1"),
        ({"nodes": -2}, "got -2 nodes, expected at least 1"),
        ({"nodes": 10**6}, "at most 1000000 balls"),
        ({"heights": ()}, "got no height, expected at least one"),
        ({"heights": (0.5, np.nan)}, "got height nan, expected 0 … 2.3"),
        ({"heights": (9.0,)}, "got height 9, expected 0 … 2.3"),
        ({"arrivals": (-1.0,)}, "got arrival -1, expected 0.001 … 50"),
        ({"speed": 0.0}, "got speed 0 m/s, expected more than 0"),
        ({"seed": -1}, "got seed -1, expected 0 or more"),
    ],
)
def test_bad_settings(made_graph: MotionGraph, wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError) as refused:
        measure_coverage(made_graph, **settings(**wrong))
    assert words in str(refused.value)


def test_bad_graph_and_balls(made_graph: MotionGraph) -> None:
    unlabelled = replace(
        made_graph,
        label_edge=made_graph.label_edge[:0],
        label_starts=made_graph.label_starts[:0],
        label_stops=made_graph.label_stops[:0],
        label_kind=(),
        label_direction=(),
        label_genuine=made_graph.label_genuine[:0],
    )
    with pytest.raises(GraphError, match="got a graph without avoidance parts, expected"):
        measure_coverage(unlabelled, **SMALL)
    with pytest.raises(AttackError, match="inside the body"):
        measure_coverage(made_graph, **settings(heights=(1.1,), arrivals=(0.001,)))
