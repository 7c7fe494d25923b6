from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import SAG, Shots, make_shot
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.attacks.merge import merge_attacks
from mgjax.avoidance.body.chord_error import frame_chord_errors, seam_chord_errors
from mgjax.avoidance.body.device_tables import FOLLOWING
from mgjax.avoidance.body.spheres import preset_spheres, sphere_centres
from mgjax.avoidance.candidates.batch import Walks
from mgjax.avoidance.checks import bounds as module
from mgjax.avoidance.checks.bounds import MORE_LANES, Bounds, clearance_bounds
from mgjax.avoidance.checks.fast import clearance_between
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE, FAR
from mgjax.core.kinematics import forward
from mgjax.core.quaternion import slerp
from mgjax.graph.types import NO_EDGE, MotionGraph
from mgjax.graph.walk import Walk, make_walk
from tests.avoidance.made import random_graph, throw

bound = jax.jit(clearance_bounds, static_argnames="frame_rate")


def random_walks(graph: MotionGraph, rng: np.random.Generator, seconds: float) -> list[Walk]:
    """A lane's worth of walks, some of their edges slowed down or sped up."""
    walks = []
    for _ in range(MORE_LANES):
        edges, end = [int(rng.integers(graph.num_edges))], 0.0
        scales: list[float] = []
        while True:
            scales.append(float(rng.choice([1.0, rng.uniform(0.26, 3.0)])))
            end += graph.edge_frames[edges[-1]] / graph.frame_rate * scales[-1]
            if end >= seconds or len(edges) == 40:
                break
            target = int(graph.edge_target[edges[-1]])
            edges.append(int(rng.choice(graph.edges_from(target))))
        walks.append(make_walk(graph, edges, scales))
    return walks


def shot_of(attack: Attack, reach: float) -> Shots:
    """The crop only counts for energies."""
    return make_shot(attack, Crop(start=0.0, end=1.0), AvoidanceConfig(), reach)


def prepared_of(graph: MotionGraph) -> Prepared:
    return prepared_for(graph, AvoidanceConfig(body_rate=graph.frame_rate))


def exactly(graph: MotionGraph, attack: Attack, walk: Walk) -> float:
    return clearance_between(prepared_of(graph).posed, attack, walk, 0.0, attack.end)


def bounds_of(graph: MotionGraph, walks: list[Walk], attack: Attack) -> Bounds:
    prepared = prepared_of(graph)
    edges = np.full((48, MORE_LANES), NO_EDGE, np.int32)
    scales = np.ones((48, MORE_LANES), np.float32)
    length = np.zeros(MORE_LANES, np.int32)
    for lane, walk in enumerate(walks):
        length[lane] = len(walk.edges)
        edges[: length[lane], lane], scales[: length[lane], lane] = walk.edges, walk.scales
    table = np.concatenate([edges, [length], np.zeros((2, MORE_LANES), np.int32)])
    lanes = Walks(table=table, shared=True)
    shot = shot_of(attack, prepared.posed.reach)
    found = bound(prepared.device, lanes, scales, shot, frame_rate=graph.frame_rate)
    return jax.tree.map(np.asarray, found)


def whole_walk(bounds: Bounds, lane: int) -> Walk:
    edges = np.asarray(bounds.edges[lane])
    count = int((edges != NO_EDGE).sum())
    scales = np.asarray(bounds.scales[lane, :count], dtype=np.float64)
    return Walk(edges=edges[:count].astype(np.int64), scales=scales)


def zigzag(rng: np.random.Generator) -> Attack:
    """A sphere that turns sharply several times on its way through the body."""
    times = np.linspace(0.1, 1.9, 8) + rng.uniform(-0.05, 0.05, 8)
    centres = rng.normal((0.3, 1.0, 0.3), (0.6, 0.3, 0.6), size=(8, 1, 3))
    return Attack(times=times, centres=centres, radii=np.array([0.08]))


@pytest.mark.parametrize("kind", ["straight", "falling", "slow", "several", "zigzag"])
def test_the_exact_clearance_lies_within_the_bounds(any_graph: MotionGraph, kind: str) -> None:
    rng = np.random.default_rng(11)
    settled = doubted = touched = 0
    for aside in (0.0, 0.4, 0.6, 0.8):
        attack = zigzag(rng)
        if kind != "zigzag":
            speed = 2.0 if kind == "slow" else 10.0
            attack = throw(rng, speed=speed, gravity=kind == "falling", arrives=0.9)
        if kind == "several":
            attack = merge_attacks([attack, throw(rng, arrives=1.1)])
        attack = replace(attack, centres=attack.centres + np.array([aside, 0.0, aside]))
        bounds = bounds_of(any_graph, random_walks(any_graph, rng, attack.end), attack)
        for lane in range(MORE_LANES):
            exact = clearance_between(
                prepared_of(any_graph).posed, attack, whole_walk(bounds, lane), 0.0, attack.end
            )
            assert exact >= bounds.lower_bound[lane] - 1e-6
            doubted += int(bounds.lower_bound[lane] < CLEAR_M and bounds.contact_from[lane] == FAR)
            if bounds.lower_bound[lane] >= CLEAR_M:
                assert exact >= CLEAR_M
                settled += 1
            if bounds.contact_from[lane] < FAR:
                assert exact < CLEAR_M
                touched += 1
    assert settled >= 3
    assert touched >= 3
    if kind != "zigzag":
        assert settled + touched > 4 * doubted  # else they would be of no use


def test_what_follows_the_path(made_graph: MotionGraph) -> None:
    # The longest edge out of each node in turn, at natural speed, and no edge of another walk.
    rng = np.random.default_rng(2)
    walks = random_walks(made_graph, rng, 0.5)
    attack = throw(rng, arrives=0.9)
    bounds = bounds_of(made_graph, walks, attack)
    for lane, walk in enumerate(walks):
        got = whole_walk(bounds, lane)
        count = len(walk.edges)
        assert len(got.edges) == count + FOLLOWING
        np.testing.assert_array_equal(got.edges[:count], walk.edges)
        np.testing.assert_allclose(got.scales[:count], walk.scales, rtol=1e-6)
        assert (got.scales[count:] == 1).all()
        end = float((made_graph.edge_frames[walk.edges] * walk.scales).sum())
        np.testing.assert_allclose(bounds.path_end[lane], end / made_graph.frame_rate, atol=1e-4)
        for before, after in zip(got.edges[count - 1 :], got.edges[count:], strict=False):
            out = made_graph.edges_from(int(made_graph.edge_target[before]))
            assert after in out
            assert made_graph.edge_frames[after] == made_graph.edge_frames[out].max()


@pytest.mark.parametrize("kind", ["straight", "falling", "slow", "zigzag"])
def test_looking_at_every_fourth_frame_misses_nothing(
    any_graph: MotionGraph, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(6)
    attacks = [zigzag(rng) for _ in range(4)]
    if kind != "zigzag":
        speed = 2.0 if kind == "slow" else 10.0
        attacks = [
            throw(rng, speed=speed, gravity=kind == "falling", arrives=0.9) for _ in range(4)
        ]
    walks = random_walks(any_graph, rng, 1.2)
    seldom = [bounds_of(any_graph, walks, attack) for attack in attacks]
    jax.clear_caches()
    monkeypatch.setattr(module, "STRIDE", 1)
    always = [bounds_of(any_graph, walks, attack) for attack in attacks]
    jax.clear_caches()
    for few, all_ in zip(seldom, always, strict=True):
        for name in ("lower_bound", "contact_from"):
            near = all_.lower_bound < 0.1
            got, wanted = getattr(few, name)[near], getattr(all_, name)[near]
            np.testing.assert_allclose(got, wanted, atol=1e-5, err_msg=name)
        assert (few.lower_bound >= np.minimum(all_.lower_bound, 0.1) - 1e-5).all()


def test_nothing_is_certain_where_it_cannot_be(made_graph: MotionGraph) -> None:
    rng = np.random.default_rng(3)
    walks = random_walks(made_graph, rng, 1.0)
    through = throw(rng, arrives=0.6)
    # Five times as fast: a written frame may skip frames of the graph.
    quick = [replace(w, scales=np.full(len(w.scales), 0.2)) for w in walks]
    lanes = bounds_of(made_graph, quick, through)
    near = lanes.clearance < 1.0
    assert near.any()
    assert (lanes.lower_bound[near] < CLEAR_M).all()
    assert (lanes.contact_from == FAR).all()
    # A sphere that comes from afar at once and hangs in the body for longer than was foreseen.
    hang = Attack(
        times=np.array([0.0, 0.1, 1.5]),
        centres=np.array([[90.0, 1.0, 0.0], [0.3, 0.3, 0.3], [0.3, 0.3, 0.3]])[:, None],
        radii=np.array([0.05]),
    )
    lanes = bounds_of(made_graph, walks, hang)
    assert (lanes.lower_bound < CLEAR_M).all()
    assert (lanes.contact_from == FAR).all()


def test_an_attack_far_away(made_graph: MotionGraph) -> None:
    rng = np.random.default_rng(5)
    away = Attack(
        times=np.array([0.0, 1.0]), centres=np.full((2, 1, 3), 60.0), radii=np.array([0.1])
    )
    lanes = bounds_of(made_graph, random_walks(made_graph, rng, 1.2), away)
    assert (lanes.lower_bound > 10).all()


def test_corners_are_paid_for() -> None:
    # At x = 1 the sphere turns by a right angle at 1 m/s: velocities differ by √2 m/s. A straight
    # line over 1/120 s around the corner is off by √2/4/120 m at most.
    attack = Attack(
        times=np.array([0.0, 1.0, 2.0]),
        centres=np.array([[0.0, 1, 0], [1.0, 1, 0], [1.0, 1, 1]])[:, None],
        radii=np.array([0.1]),
    )
    assert np.isclose(
        float(shot_of(attack, 1.0).numbers[0, SAG]), np.sqrt(2) / 4 / EXPORT_RATE, rtol=1e-3
    )
    straight = replace(attack, centres=np.array([[0.0, 1, 0], [1, 1, 0], [2, 1, 0]])[:, None])
    assert float(shot_of(straight, 1.0).numbers[0, SAG]) == 0
    falling = throw(np.random.default_rng(0), gravity=True)
    wanted = falling.acceleration / EXPORT_RATE**2 / 8
    assert np.isclose(float(shot_of(falling, 1.0).numbers[0, SAG]), wanted, rtol=1e-3)


def test_chord_errors_cover_the_arc(made_graph: MotionGraph) -> None:
    graph = made_graph
    spheres = preset_spheres(graph.skeleton)
    rng = np.random.default_rng(0)
    edges = rng.integers(graph.num_edges, size=60)
    frames = graph.edge_starts[edges] + rng.integers(graph.edge_frames[edges])
    errors = frame_chord_errors(prepared_of(graph).posed)[frames]

    def centres(root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
        return np.asarray(sphere_centres(spheres, forward(graph.skeleton, root, rotations)[0]))

    roots = graph.root_translation[frames], graph.root_translation[frames + 1]
    turns = graph.local_rotations[frames], graph.local_rotations[frames + 1]
    ends = centres(roots[0], turns[0]), centres(roots[1], turns[1])
    worst = np.zeros(len(frames))
    for share in np.linspace(0, 1, 33):
        turned = np.asarray(slerp(*turns, np.full((1, 1), share)))
        there = centres(roots[0] * (1 - share) + roots[1] * share, turned)
        off = np.linalg.norm(there - (ends[0] * (1 - share) + ends[1] * share), axis=-1)
        worst = np.maximum(worst, off.max(axis=1))
    assert (worst <= errors).all()
    assert (errors <= 1.25 * worst + 5e-5).all()


def test_chord_errors_over_a_seam() -> None:
    # Where the next edge begins with the pose at which this one arrives a seam is a step like any.
    graph = random_graph(3)
    edge = 0
    graph.edge_exit[:] = 0
    same = seam_chord_errors(prepared_of(graph).posed, np.array([edge]), np.array([edge]))
    assert same.shape == (1,)
    assert np.isfinite(same).all()


def test_after_the_end_of_a_walk_nothing_is_certain(made_graph: MotionGraph) -> None:
    # A sphere that lasts for longer than the walk and what follows it, far from its last pose.
    rng = np.random.default_rng(8)
    walks = random_walks(made_graph, rng, 0.5)
    times = np.array([0.0, 30.0])
    away = Attack(times=times, centres=np.full((2, 1, 3), 9.0), radii=np.array([0.1]))
    lanes = bounds_of(made_graph, walks, away)
    assert (lanes.lower_bound < CLEAR_M).all()
    assert (lanes.contact_from == FAR).all()
    brief = replace(away, times=np.array([0.0, 0.4]))
    assert (bounds_of(made_graph, walks, brief).lower_bound > 1.0).all()


@pytest.mark.parametrize("stop", [0.5013, 0.5031, 0.7])
def test_a_sphere_that_lives_between_two_frames(made_graph: MotionGraph, stop: float) -> None:
    # It appears inside the body between two frames of the written motion, perhaps vanishing there.
    rng = np.random.default_rng(9)
    walks = random_walks(made_graph, rng, 1.0)
    times = np.array([0.0, 0.501, stop, 1.0])
    centres = np.tile(np.array([[[5.0, 1.0, 0.0], [0.0, 0.9, 0.0]]]), (4, 1, 1))
    attack = Attack(
        times=times,
        centres=centres,
        radii=np.array([0.1, 3.0]),
        starts=np.array([0.0, 0.501]),
        stops=np.array([1.0, stop]),
    )
    lanes = bounds_of(made_graph, walks, attack)
    for lane, walk in enumerate(walks):
        exact = clearance_between(
            prepared_of(made_graph).posed, attack, whole_walk(lanes, lane), 0.0, attack.end
        )
        if np.abs(walk.starts(made_graph)[-1]) > 0.6:
            assert exact < CLEAR_M
            assert lanes.lower_bound[lane] < CLEAR_M
