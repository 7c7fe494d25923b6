from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.checks.written import (
    SphereTrajectory,
    clearance,
    sphere_trajectory,
    walk_motion,
    write_walk,
)
from mgjax.avoidance.rates import CHECK_RATE, EXPORT_RATE, FAR
from mgjax.core.kinematics import planar_frames
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk
from mgjax.io.bvh.write import save_bvh
from tests.reference import avoidance as reference


def some_walk(graph: MotionGraph, seed: int, length: int = 6) -> Walk:
    """A random walk, some of whose edges are stretched or shortened."""
    rng = np.random.default_rng(seed)
    edges = [int(rng.integers(graph.num_edges))]
    while len(edges) < length:
        edges.append(int(rng.choice(graph.edges_from(int(graph.edge_target[edges[-1]])))))
    return make_walk(graph, edges, rng.choice([0.6, 1.0, 1.7], length))


def random_case(seed: int) -> tuple[Attack, SphereTrajectory, np.ndarray]:
    """Knots and moments that do not coincide; the attack begins late and ends early, or not."""
    rng = np.random.default_rng(seed)
    times = np.sort(rng.uniform(-0.3, 1.3, 7)) if seed % 2 else np.linspace(0.22, 0.71, 5)
    attack = Attack(
        times=times,
        centres=rng.normal(size=(len(times), 2, 3)),
        radii=rng.uniform(0.05, 0.2, 2),
    )
    moments = np.arange(11) / 10
    trace = SphereTrajectory(
        times=moments, centres=np.cumsum(rng.normal(scale=0.3, size=(11, 4, 3)), axis=0)
    )
    return attack, trace, rng.uniform(0.05, 0.2, 4)


def dense(
    attack: Attack, trace: SphereTrajectory, radii: np.ndarray, start: float, stop: float
) -> float:
    """Clearance by dense sampling; too large by at most what moves between two samples."""
    low, high = max(start, attack.start), min(stop, attack.end)
    if low > high:
        return FAR
    times = np.linspace(low, high, 4001)
    body = np.stack(
        [
            np.stack([np.interp(times, trace.times, column) for column in sphere.T], axis=-1)
            for sphere in np.moveaxis(trace.centres, 1, 0)
        ],
        axis=1,
    )
    gap = np.linalg.norm(attack.at(times)[:, :, None] - body[:, None], axis=-1)
    return float((gap - attack.radii[:, None] - radii).min())


@pytest.mark.parametrize("seed", range(14))
def test_clearance_by_dense_sampling(seed: int) -> None:
    attack, trace, radii = random_case(seed)
    gaps, least = clearance(attack, trace, radii)
    assert gaps.shape == (len(trace.times) - 1,)
    assert least == gaps.min()
    for i, (start, stop) in enumerate(zip(trace.times[:-1], trace.times[1:], strict=True)):
        wanted = dense(attack, trace, radii, start, stop)
        assert wanted - 0.01 <= gaps[i] <= wanted + 1e-9
        if abs(gaps[i] - wanted) > 1e-4:  # the sampled one is coarse: look closer
            finer = [
                dense(attack, trace, radii, a, b)
                for a, b in zip(*(np.linspace(start, stop, 41)[k:] for k in (0, 1)), strict=False)
            ]
            assert abs(gaps[i] - min(finer)) < 1e-4


def test_clearance_by_loops() -> None:
    rng = np.random.default_rng(0)
    times = np.arange(8) / 4
    attack = Attack(times=times, centres=rng.normal(size=(8, 2, 3)), radii=np.array([0.1, 0.2]))
    trace = SphereTrajectory(times=times, centres=rng.normal(size=(8, 3, 3)))
    radii = np.array([0.1, 0.15, 0.2])
    least = clearance(attack, trace, radii)[1]
    exact = reference.swept_clearance(attack.centres, attack.radii, trace.centres, radii)
    np.testing.assert_allclose(least, exact, atol=1e-9)
    sampled = reference.swept_clearance(
        attack.centres, attack.radii, trace.centres, radii, pieces=200
    )
    assert least <= sampled <= least + 0.02
    quick = reference.quick_clearance(attack.centres, attack.radii, trace.centres, radii)
    np.testing.assert_allclose(quick, exact, atol=1e-12)


def test_between_two_moments_nothing_slips_through() -> None:
    # The attack darts in and out between two moments of the check.
    attack = Attack(
        times=np.array([0.0, 0.5, 1.0]),
        centres=np.array([[[2.0, 0, 0]], [[0.0, 0, 0]], [[2.0, 0, 0]]]),
        radii=np.array([0.1]),
    )
    trace = SphereTrajectory(times=np.array([0.0, 1.0]), centres=np.zeros((2, 1, 3)))
    np.testing.assert_allclose(clearance(attack, trace, np.array([0.2]))[1], -0.3, atol=1e-12)


def test_outside_its_life_an_attack_is_far() -> None:
    attack = Attack(times=np.array([0.4, 0.5]), centres=np.zeros((2, 1, 3)), radii=np.array([0.1]))
    # The body passes through the attack's place before it is there, and after it has gone.
    x = np.array([0.0, 0.0, 5.0, 5.0, 5.0, 5.0, 5.0, 0.0])
    trace = SphereTrajectory(
        times=np.arange(8) / 10, centres=np.stack([x, 0 * x, 0 * x], axis=-1)[:, None]
    )
    gaps, least = clearance(attack, trace, np.array([0.1]))
    np.testing.assert_allclose(least, 4.8)
    np.testing.assert_array_equal(gaps[[0, 1, 2, 5, 6]], FAR)
    late = SphereTrajectory(times=trace.times + 1, centres=trace.centres)
    assert clearance(attack, late, np.array([0.1]))[1] == FAR


def test_a_curved_flight_is_bounded() -> None:
    attack = ball_attack(
        np.array([0.0, 1.0, 4.0]), np.array([0.0, 1.2, 0.0]), speed=9.0, arrives=1.0, gravity=True
    )
    times = np.arange(241) / CHECK_RATE
    body = np.tile([[[0.1, 1.1, 0.6]]], (len(times), 1, 1))
    least = clearance(attack, SphereTrajectory(times=times, centres=body), np.array([0.1]))[1]
    exact = min(
        float(
            np.linalg.norm(
                reference.ball_place((0, 1.0, 4.0), (0, 1.2, 0), 9.0, 1.0, True, t) - body[0, 0]
            )
        )
        - 0.22
        for t in np.linspace(0.9, 1.0, 150)
    )
    assert exact - 1e-4 < least <= exact + 1e-6


def test_trace_covers_what_is_asked(made_graph: MotionGraph) -> None:
    spheres = preset_spheres(made_graph.skeleton)
    motion = walk_motion(made_graph, some_walk(made_graph, 0), 1.23)
    assert motion.frame_rate == EXPORT_RATE
    assert motion.num_frames == 149  # 1.23 s are 147.6 frames
    whole = sphere_trajectory(made_graph, spheres, motion)
    np.testing.assert_allclose(whole.times, np.arange(297) / CHECK_RATE)
    part = sphere_trajectory(made_graph, spheres, motion, start=0.501, stop=0.777)
    assert part.times[0] <= 0.501 < part.times[1]
    assert part.times[-2] < 0.777 <= part.times[-1]
    first = round(part.times[0] * CHECK_RATE)
    np.testing.assert_allclose(
        part.centres, whole.centres[first : first + len(part.times)], atol=1e-6
    )


def test_a_walk_as_it_is_written(made_graph: MotionGraph) -> None:
    walk, spheres = some_walk(made_graph, 1, 2), preset_spheres(made_graph.skeleton)
    attack = ball_attack(
        np.array([3.0, 1.2, 0.0]), np.array([0.0, 1.2, 0.0]), speed=10.0, arrives=0.3
    )
    natural = float(made_graph.edge_frames[walk.edges].sum()) / made_graph.frame_rate
    ones = np.array([1.0, 1.0])
    warp = TimeWarp(times=np.zeros(2), positions=np.array([0.0, natural]), speeds=ones)
    for how in (None, warp):  # the second begins where the walk ends
        written = write_walk(made_graph, spheres, walk, 0.5, how, attack)
        count = len(walk.edges)
        np.testing.assert_array_equal(written.walk.edges[:count], walk.edges)
        assert (len(written.walk.edges) > count) == (how is not None)
        motion = walk_motion(made_graph, written.walk, 0.5, how)
        np.testing.assert_array_equal(written.motion.root_translation, motion.root_translation)
        trace = sphere_trajectory(made_graph, spheres, motion)
        np.testing.assert_array_equal(written.trace.centres, trace.centres)
        assert written.clearance == clearance(attack, trace, spheres.radii)[1]
    assert write_walk(made_graph, spheres, walk, 0.5, None, None).clearance is None


@pytest.mark.parametrize("seed", range(3))
def test_written_motion_gives_the_same_volumes(
    any_graph: MotionGraph, tmp_path: Path, seed: int
) -> None:
    walk = some_walk(any_graph, seed)
    spheres = preset_spheres(any_graph.skeleton)
    motion = walk_motion(any_graph, walk, float(walk.starts(any_graph)[-1]))
    trace = sphere_trajectory(any_graph, spheres, motion)
    save_bvh(tmp_path / "motion.bvh", any_graph.skeleton, motion)
    names, times, places = reference.written_positions(tmp_path / "motion.bvh")
    np.testing.assert_allclose(times, trace.times, rtol=1e-6, atol=1e-9)
    order = np.array([names.index(name) for name in any_graph.skeleton.names])
    share = spheres.share[:, None]
    centres = (
        places[:, order[spheres.first]] * (1 - share) + places[:, order[spheres.second]] * share
    )
    np.testing.assert_allclose(centres, trace.centres, atol=1e-3)
    # It begins at the origin, heading +Z; the first frame of a blend is 3 % on its way already.
    begin = np.asarray(planar_frames(any_graph.skeleton, places[0][order]))
    np.testing.assert_allclose(begin, 0.0, atol=0.02)
