"""Candidates that come a little earlier or later."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.choice.search import search_input, search_shifted
from mgjax.avoidance.choice.shifts import OF_A_PART, Miss, apart, misses
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.choice.verify import Bounded, walk_of
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.timing.walk_warps import linear_warp, part_moments
from mgjax.graph.types import MotionGraph
from tests.avoidance.made import throw

CONFIG = AvoidanceConfig()


def miss(part: int, shift: float, clearance: float = -0.05) -> Miss:
    none = np.zeros(0, np.int64)
    lane = Bounded(0, 1, none, none.astype(np.float64), clearance, clearance, 0.0, 1.0)
    return Miss(lane=lane, part=part, shift=shift, path=b"", values={})


def test_timings_of_one_part_are_apart() -> None:
    found = [miss(1, 0.05), miss(1, 0.0), miss(2, 0.05), miss(1, -0.05), miss(1, 0.15)]
    found += [miss(1, 0.2), miss(1, -0.15), miss(2, -0.2)]
    assert apart(found) == [found[k] for k in (0, 2, 3, 4, 7)]
    assert OF_A_PART == 3


def test_of_two_touched_alike_the_one_on_time_comes_first() -> None:
    assert miss(1, 0.0, -0.05).worth > miss(1, 0.05, -0.05).worth
    assert miss(1, 0.05, -0.02).worth > miss(1, 0.0, -0.05).worth


@pytest.mark.parametrize("shift", [-0.1, 0.0, 0.05])
def test_parts_come_so_much_later(made_graph: MotionGraph, shift: float) -> None:
    attack = throw(np.random.default_rng(6), arrives=1.2)
    query = ask(prepared_for(made_graph, CONFIG), 0, attack, CONFIG)
    assert query is not None
    candidates = query.in_time
    padded = search_input(query, candidates)
    scales = np.asarray(search_shifted(query, padded, shift).scales)
    seen = 0
    for near in misses(query, candidates, 10.0):
        if near.shift != shift:
            continue
        walk = walk_of(query, near.lane)
        length = near.lane.length
        np.testing.assert_allclose(walk.scales[:length], scales[:length, near.lane.number])
        middle = part_moments(made_graph, walk, length, near.part)[1:2]
        time = float(linear_warp(made_graph, walk).when(middle)[0])
        assert time == pytest.approx(query.crop.middle + shift, abs=0.51 / made_graph.frame_rate)
        seen += 1
    assert seen
