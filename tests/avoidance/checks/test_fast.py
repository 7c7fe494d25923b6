from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.checks.fast import clearance_between
from mgjax.avoidance.checks.written import clearance, sphere_trajectory
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.rates import FAR
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk
from tests.avoidance.made import captured_motion

FRAME = 1 / 120


def scaled_walk(graph: MotionGraph, seed: int, edges: int = 8) -> Walk:
    rng = np.random.default_rng(seed)
    node, chosen = int(rng.integers(graph.num_nodes)), []
    for _ in range(edges):
        chosen.append(int(rng.choice(graph.edges_from(node))))
        node = int(graph.edge_target[chosen[-1]])
    return make_walk(graph, chosen, rng.uniform(0.6, 1.5, edges))


def hovering(place: tuple[float, float, float], seconds: float) -> Attack:
    """A ball that stays where it is, so that every moment of the motion counts."""
    return Attack(
        times=np.array([0.0, seconds]),
        centres=np.tile(np.array(place, dtype=float), (2, 1, 1)),
        radii=np.array([0.12]),
    )


def by_check(graph: MotionGraph, attack: Attack, walk: Walk, start: float, stop: float) -> float:
    """The clearance of the motion as captured, without the jitted code."""
    spheres = preset_spheres(graph.skeleton)
    motion = captured_motion(graph, walk, float(walk.starts(graph)[-1]) + 0.1)
    trace = sphere_trajectory(graph, spheres, motion, start=start + 1e-9, stop=stop - 1e-9)
    return clearance(attack, trace, spheres.radii)[1]


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_the_written_motion_at_every_seam(any_graph: MotionGraph, seed: int) -> None:
    posed = prepared_for(any_graph, AvoidanceConfig()).posed
    walk = scaled_walk(any_graph, seed)
    starts = walk.starts(any_graph)
    attack = hovering((0.3, 1.0, 0.3), float(starts[-1]))
    for seam in starts[1:-1]:
        # Two written frames before the seam and one after, in whole frames.
        first = max(int(np.floor(seam / FRAME)) - 2, 0)
        span = first * FRAME, (first + 4) * FRAME
        if span[1] > starts[-1]:
            break
        got = clearance_between(
            posed,
            attack,
            walk,
            span[0] + 1e-9,
            span[1] - 1e-9,
        )
        if got < FAR:
            wanted = by_check(any_graph, attack, walk, *span)
            np.testing.assert_allclose(got, wanted, atol=2e-5)


@pytest.mark.parametrize("seed", range(4))
def test_agrees_on_the_whole_walk(any_graph: MotionGraph, seed: int) -> None:
    posed = prepared_for(any_graph, AvoidanceConfig()).posed
    walk = scaled_walk(any_graph, seed)
    end = np.floor(float(walk.starts(any_graph)[-1]) / FRAME) * FRAME
    attack = hovering((0.2, 1.2, 0.2), end)
    got = clearance_between(posed, attack, walk, 0.0, end)
    np.testing.assert_allclose(got, by_check(any_graph, attack, walk, 0.0, end), atol=2e-5)


def test_nothing_without_attack(any_graph: MotionGraph) -> None:
    posed = prepared_for(any_graph, AvoidanceConfig()).posed
    walk = scaled_walk(any_graph, 0)
    assert (
        clearance_between(
            posed,
            hovering((0, 1, 0), 0.2),
            walk,
            0.3,
            0.4,
        )
        == FAR
    )
    assert (
        clearance_between(
            posed,
            hovering((50, 1, 0), 1.0),
            walk,
            0.0,
            1.0,
        )
        == FAR
    )
