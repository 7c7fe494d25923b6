"""The sweep that shares nothing with the check finds what the check finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.benchmarks.random_attacks import least_distance
from mgjax.avoidance.attacks.merge import merge_attacks
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig
from tests.avoidance.refinement.made import still_graph
from tests.avoidance.refinement.test_refine import ball_into_head


@pytest.mark.parametrize("depth", [0.05, 0.01, -0.02])
def test_a_ball_at_the_head_is_as_deep_as_it_was_thrown(depth: float) -> None:
    graph, off = still_graph(), AvoidanceConfig(refine="off")
    attack = ball_into_head(graph, depth)
    found = select(graph, 0, attack, config=off)
    swept = least_distance(graph, attack, found.motion)
    assert found.clearance_m is not None
    assert swept == pytest.approx(found.clearance_m, abs=1e-4)
    assert swept == pytest.approx(-depth, abs=3e-3)
    # A sphere that is not there yet touches nothing.
    later = replace(attack, times=attack.times + 0.5)
    both = merge_attacks([attack, replace(later, radii=np.array([1.0]))])
    assert least_distance(graph, both, found.motion) < swept
    early = replace(found.motion, root_translation=found.motion.root_translation[:60],
                    local_rotations=found.motion.local_rotations[:60])  # fmt: skip
    assert least_distance(graph, replace(attack, times=attack.times + 9.0), early) == np.inf
