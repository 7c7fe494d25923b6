"""Coverage in rounds: the map is there after the first and becomes surer with each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.coverage.report import bearing
from mgjax.avoidance.coverage.shares import shares
from mgjax.avoidance.coverage.throws import DISTANCE_M, Coverage, measure_coverage
from mgjax.avoidance.many.attacks import BatchSelection
from mgjax.avoidance.prepared import prepared_for
from mgjax.core.errors import ConfigError
from mgjax.graph.types import MotionGraph
from mgjax.stage.apps.edit.job import Watch

HEIGHTS_M = (0.2, 0.5, 0.8, 1.1, 1.4, 1.7)
"""Of an adult; they are scaled to the body."""
ARRIVALS_S = (0.9, 1.2, 1.5)
DIRECTIONS = 16
ROUND = len(HEIGHTS_M) * len(ARRIVALS_S)
"""Nodes of a round: each height comes from each direction once per time of arrival."""
MOST_ROUNDS = 40


def cover(
    graph: MotionGraph,
    config: AvoidanceConfig,
    rounds: int,
    found: Callable[[Coverage], None],
    watch: Watch,
) -> Coverage:
    """Throws balls from all around, a few at a time.

    Args:
        graph: with labelled avoidance parts.
        config: settings of the search.
        rounds: how many times 288 balls.
        found: told what is known after each round.
        watch: told how far it is.

    Raises:
        GraphError: the graph has no avoidance parts.
    """
    if not 1 <= rounds <= MOST_ROUNDS:
        raise ConfigError(got=f"{rounds} rounds", expected=f"1 … {MOST_ROUNDS}")
    watch(0.0, "preparing the search")
    prepared = prepared_for(graph, config)
    whole: Coverage | None = None
    for number in range(rounds):
        watch((number + 0.1) / rounds, f"throwing balls: round {number + 1} of {rounds}")
        part = measure_coverage(
            prepared,
            directions=DIRECTIONS,
            heights=[graph.body_scale * height for height in HEIGHTS_M],
            arrivals=ARRIVALS_S,
            nodes=ROUND,
            seed=number,
            config=config,
        )
        whole = part if whole is None else joined(whole, part)
        found(whole)
    assert whole is not None
    return whole


def joined(a: Coverage, b: Coverage) -> Coverage:
    """The throws of two coverages of one graph with the same directions, heights and arrivals."""
    answers = BatchSelection(
        **{
            f.name: np.concatenate([getattr(a.answers, f.name), getattr(b.answers, f.name)])
            for f in fields(BatchSelection)
        }
    )
    names = ("node", "direction", "height", "arrival", "kind")
    both = {name: np.concatenate([getattr(a, name), getattr(b, name)]) for name in names}
    return replace(a, answers=answers, **both)


def coverage_map(found: Coverage) -> dict[str, Any]:
    """What the page draws: for each direction and height how many balls, and what became of them.

    Arrays are [D,H]; directions in degrees from ahead to the left.
    """
    shape = (len(found.directions), len(found.heights))
    counts = {}
    for status in Status:
        mask = found.answers.status == status.code
        count = np.zeros(shape, np.int32)
        np.add.at(count, (found.direction[mask], found.height[mask]), 1)
        counts[status.value] = count
    total = shares(found, np.ones(len(found), bool))
    low, high = total["avoided_interval"]
    kinds = sorted(total["kinds"].items(), key=lambda item: -item[1])
    return {
        "directions": np.degrees(found.directions).astype(np.float32),
        "heights": found.heights.astype(np.float32),
        "words": [bearing(float(angle)) for angle in found.directions],
        **counts,
        "sentence": f"{len(found)} balls at {found.speed:g} m/s: {total['avoided']:.0%} avoided"
        f" (95 %: {low:.0%} … {high:.0%}), {total['hit']:.0%} hit, {total['no_candidate']:.0%}"
        " without candidate" + (f", {total['parried']:.0%} parried" if total["parried"] else ""),
        "kinds": [[kind, float(share)] for kind, share in kinds if share > 0],
    }


def throw_of_cell(
    graph: MotionGraph,
    config: AvoidanceConfig,
    found: Coverage,
    direction: int,
    height: int,
    turn: int,
) -> tuple[Attack, Selection, str]:
    """One of the balls of a cell, answered once more to be seen.

    Args:
        graph: the graph.
        config: as the coverage had it.
        found: the coverage.
        direction, height: the cell.
        turn: which of its balls, in turns.

    Returns:
        The ball, the answer, and what the ball is in words.

    Raises:
        ConfigError: no ball was thrown from there.
    """
    there = np.flatnonzero((found.direction == direction) & (found.height == height))
    if not len(there):
        raise ConfigError(got="a cell without a ball", expected="one that was thrown from")
    ball = int(there[turn % len(there)])
    angle, arrives = found.directions[direction], found.arrivals[found.arrival[ball]]
    attack = ball_from(
        float(angle),
        float(found.heights[height]),
        distance=DISTANCE_M,
        speed=found.speed,
        arrives=float(arrives),
    )
    selection = select(graph, int(found.node[ball]), attack, config=config)
    words = (
        f"ball {turn % len(there) + 1} of {len(there)} from {bearing(float(angle))} at"
        f" {round(float(found.heights[height]), 2):g} m, known {arrives:g} s before"
    )
    return attack, selection, words
