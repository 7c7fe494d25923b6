from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.body.edge_tables import edge_tables
from mgjax.avoidance.body.spheres import preset_spheres, sphere_centres
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.checks.written import clearance, sphere_trajectory, write_walk
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.continuation import continue_clear
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.search import HOPELESS_M
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.avoidance.choice.start import Query
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig, SpeedConfig, for_body
from mgjax.avoidance.energy.evaluate import judge
from mgjax.avoidance.many.attacks import select_batch
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.rates import CLEAR_M, FAR
from mgjax.avoidance.timing.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE
from mgjax.core import planar
from mgjax.core.errors import AttackError, ConfigError
from mgjax.core.kinematics import forward
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk
from mgjax.io.bvh.write import save_bvh
from tests.avoidance.made import captured_motion, make_graph, throw
from tests.reference import avoidance as reference

QUICK = AvoidanceConfig(checks=12, T_wide=0.0, capacity=4096, refine="off")


@pytest.fixture(scope="module")
def answers(any_graph: MotionGraph) -> list[tuple[int, Attack, Selection]]:
    """Thirty random balls, straight and falling, at random nodes; every fifth comes very soon."""
    rng = np.random.default_rng(6)
    found = []
    for number in range(30):
        node = int(rng.integers(any_graph.num_nodes))
        soonest, latest = (0.9, 1.5) if number % 5 else (0.4, 0.6)
        attack = throw(rng, arrives=rng.uniform(soonest, latest), gravity=number % 3 == 0)
        found.append((node, attack, select(any_graph, node, attack, config=QUICK)))
    return found


def with_status(answers: list[tuple[int, Attack, Selection]], status: str) -> Iterator:
    return (answer for answer in answers if answer[2].status == status)


def judged(
    graph: MotionGraph, node: int, attack: Attack, config: AvoidanceConfig
) -> tuple[Candidates, dict[str, np.ndarray]]:
    """All candidates and their energies, as the selection sees them."""
    prepared = prepared_for(graph, config)
    config = for_body(config, graph.body_scale)
    crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
    assert crop is not None
    found = enumerate_candidates(
        graph,
        prepared.tables,
        node,
        crop.middle,
        window=config.T_window,
        capacity=config.capacity,
    )
    query = Query(prepared=prepared, config=config, node=node, attack=attack, crop=crop)
    return found, judge(
        prepared.device,
        found,
        attack,
        crop,
        config,
        frame_rate=graph.frame_rate,
        unmoved=query.unmoved,
    )


def test_every_status_occurs(answers: list) -> None:
    counts = {s: sum(a[2].status == s for a in answers) for s in ("avoided", "hit")}
    assert counts["avoided"] >= 10
    assert counts["hit"] >= 2


def test_avoided_balls_never_touch_the_written_motion(
    any_graph: MotionGraph, answers: list, tmp_path: Path
) -> None:
    # Everything anew: the file is read, solved and swept by code that shares nothing.
    spheres = preset_spheres(any_graph.skeleton)
    share = spheres.share[:, None]
    checked = 0
    for _, attack, chosen in answers:
        if chosen.status == "no_candidate":
            continue
        save_bvh(tmp_path / "motion.bvh", any_graph.skeleton, chosen.motion)
        names, times, places = reference.written_positions(tmp_path / "motion.bvh")
        order = np.array([names.index(name) for name in any_graph.skeleton.names])
        ends = places[:, order[spheres.first]], places[:, order[spheres.second]]
        body = ends[0] * (1 - share) + ends[1] * share
        assert times[-1] >= attack.end + QUICK.settle_s - 1e-6  # until the attack is over
        there = (times >= attack.start) & (times <= attack.end)
        least = reference.quick_clearance(
            attack.at(times[there]), attack.radii, body[there], spheres.radii
        )
        assert abs(least - chosen.clearance_m) < 0.005
        if chosen.status == "avoided":
            assert least > 0
            checked += 1
        else:
            assert least < 2 * CLEAR_M
    assert checked >= 10


def test_the_numbers_of_a_selection(any_graph: MotionGraph, answers: list) -> None:
    radii = preset_spheres(any_graph.skeleton).radii
    for node, attack, chosen in answers:
        assert chosen.node == node
        dropped = chosen.dropped
        total = dropped.not_adjustable + dropped.time_scale + dropped.hit + dropped.overflow
        assert any_graph.edge_source[chosen.walk.edges[0]] == node
        make_walk(any_graph, chosen.walk.edges)  # raises where it is broken
        assert float(chosen.walk.starts(any_graph)[-1]) >= attack.end + QUICK.settle_s - 1e-9
        assert np.isfinite(chosen.motion.root_translation).all()
        if chosen.status == "no_candidate":
            assert chosen.part is chosen.energy is chosen.clearance_m is chosen.time_scale is None
            assert chosen.path_length == 0
            assert total == chosen.candidates
            continue
        if chosen.status == "avoided":
            assert total < chosen.candidates
            assert chosen.clearance_m >= CLEAR_M
            assert chosen.clear_until is None
        else:
            assert total == chosen.candidates
            assert chosen.clearance_m < CLEAR_M
        assert clearance(attack, chosen.trace, radii)[1] == chosen.clearance_m
        # The path ends with the edge that holds the part, which meets the attack.
        last = chosen.path_length - 1
        assert any_graph.label_edge[chosen.part] == chosen.walk.edges[last]
        np.testing.assert_array_equal(chosen.walk.scales[chosen.path_length :], 1.0)
        middle = 0.5 * (any_graph.label_starts + any_graph.label_stops)[chosen.part]
        within = (middle - any_graph.edge_starts[chosen.walk.edges[last]]) / any_graph.frame_rate
        t_avoid = chosen.walk.starts(any_graph)[last] + within * chosen.walk.scales[last]
        late = 0.5 / any_graph.frame_rate if chosen.time_scale == 1.0 else 0.0
        assert abs(t_avoid - chosen.crop.middle) <= late + 1e-4
        energy = chosen.energy
        own = QUICK.energy
        parts = energy.avoidance + energy.body + own.w_m * energy.movement + energy.timescale
        np.testing.assert_allclose(energy.total, parts, rtol=1e-5)
        assert 1 / 4 <= chosen.time_scale <= 4


def test_a_limit_on_speeding_up(any_graph: MotionGraph, answers: list) -> None:
    config = replace(QUICK, energy=replace(QUICK.energy, E_fast=1.15))
    sped_up = [a for a in with_status(answers, "avoided") if a[2].time_scale < 1 / 1.15]
    assert sped_up
    for node, attack, before in sped_up[:4]:
        chosen = select(any_graph, node, attack, config=config)
        assert chosen.dropped.time_scale >= before.dropped.time_scale
        if chosen.time_scale is None:
            continue
        assert chosen.time_scale >= 1 / 1.15 - 1e-6
        assert chosen.timing.speeds.max() <= 1.15 + 1e-6


def test_the_least_energy_that_passes_wins(any_graph: MotionGraph, answers: list) -> None:
    spheres = preset_spheres(any_graph.skeleton)
    looked_at = 0
    for node, attack, chosen in with_status(answers, "avoided"):
        candidates, values = judged(any_graph, node, attack, QUICK)
        rivals = (values["status"] == OK) & (values["d"] >= 0)
        rivals &= values["total"] < chosen.energy.total - 1e-6
        if chosen.energy.d < 0:  # only where every candidate seemed to be hit
            rivals = (values["status"] == OK) & (values["d"] >= 0)
        for index in np.flatnonzero(rivals):
            length = candidates.length[index]
            walk = make_walk(
                any_graph,
                candidates.edges[index, :length],
                values["scales"][index, :length],
            )
            end = float(walk.starts(any_graph)[-1])
            trace = sphere_trajectory(
                any_graph, spheres, captured_motion(any_graph, walk, end), stop=end
            )
            # It is hit on its path, or wherever it may lead after it.
            if clearance(attack, trace, spheres.radii)[1] >= CLEAR_M:
                played = continue_clear(prepared_for(any_graph, QUICK).posed, attack, walk, QUICK)
                if played.clear_until is None and played.clearance >= CLEAR_M:
                    # Its feet, or the rest that follows them, are touched as it is written.
                    seconds = attack.end + QUICK.settle_s
                    written = write_walk(any_graph, spheres, played.walk, seconds, None, attack)
                    assert written.clearance is not None
                    assert written.clearance < CLEAR_M
        looked_at += 1
        assert chosen.candidates == len(candidates.length) + candidates.overflow
        counts = [int((values["status"] == s).sum()) for s in (NOT_ADJUSTABLE, OUT_OF_RANGE)]
        assert counts == [chosen.dropped.not_adjustable, chosen.dropped.time_scale]
    assert looked_at >= 10


def test_same_question_same_answer(made_graph: MotionGraph) -> None:
    rng = np.random.default_rng(3)
    for _ in range(4):
        node, attack = int(rng.integers(made_graph.num_nodes)), throw(rng)
        a, b = (select(made_graph, node, attack, config=QUICK) for _ in range(2))
        assert (a.status, a.candidates, a.dropped, a.energy) == (
            b.status,
            b.candidates,
            b.dropped,
            b.energy,
        )
        np.testing.assert_array_equal(a.walk.edges, b.walk.edges)
        np.testing.assert_array_equal(a.motion.local_rotations, b.motion.local_rotations)


def test_a_ball_that_stays_far_away(made_graph: MotionGraph) -> None:
    far = ball_attack(np.array([9.0, 1.0, 5.0]), np.array([9.0, 1.0, 0.0]), speed=10.0, arrives=1.0)
    chosen = select(made_graph, 3, far)
    assert (chosen.status, chosen.candidates, chosen.crop) == ("no_candidate", 0, None)
    # What is played then depends on the seed only.
    edges = [select(made_graph, 3, far, seed=s).walk.edges.tolist() for s in (0, 0, 1, 2, 3)]
    assert edges[0] == edges[1]
    assert len({tuple(e) for e in edges}) > 1


def test_no_part_in_time(made_graph: MotionGraph) -> None:
    nearest = edge_tables(made_graph, 30.0).nearest_part
    node = int(np.argmax(nearest))
    attack = throw(np.random.default_rng(0), arrives=0.3)
    assert nearest[node] > 0.9
    chosen = select(made_graph, node, attack)
    assert chosen.status == "no_candidate"
    assert chosen.crop is not None


def test_an_attack_that_is_over(made_graph: MotionGraph) -> None:
    attack = Attack(
        times=np.array([-2.0, -1.0]),
        centres=np.array([[[0.0, 1, 3]], [[0.0, 1, 2]]]),
        radii=np.array([0.1]),
    )
    assert select(made_graph, 0, attack).status == "no_candidate"


def body_now(graph: MotionGraph, node: int) -> tuple[np.ndarray, np.ndarray]:
    spheres = preset_spheres(graph.skeleton)
    frame = graph.node_frame[node]
    pose = forward(graph.skeleton, graph.root_translation[frame], graph.local_rotations[frame])[0]
    inverse = reference.inverse(graph.node_plane[node])
    centres = np.asarray(sphere_centres(spheres, np.asarray(pose, np.float64)))
    return np.asarray(planar.apply(inverse, centres)), spheres.radii


def test_an_attack_inside_the_body(any_graph: MotionGraph) -> None:
    centres, radii = body_now(any_graph, 7)
    head = preset_spheres(any_graph.skeleton).names.index("head-head_end 0.50")
    at = np.array([0.0, 1.0, 0.0])
    with pytest.raises(AttackError, match=r"inside the body \(") as caught:
        select(any_graph, 7, ball_attack(centres[head], at, speed=5.0, arrives=1.0))
    assert "\n" not in str(caught.value)
    # Just outside of every sphere is legal.
    above = centres[head] + [0, radii[head] + 0.12 + 0.005, 0]
    gap = np.linalg.norm(centres - above, axis=1) - radii - 0.12
    assert gap.min() > 0
    select(any_graph, 7, ball_attack(above, at, speed=5.0, arrives=1.0), config=QUICK)
    # A ball that is already under way counts from where it is now.
    inside = ball_attack(np.array([0.0, 1.2, 4.0]), centres[head], speed=10.0, arrives=0.005)
    with pytest.raises(AttackError, match="inside the body"):
        select(any_graph, 7, inside)


NAN = float("nan")
BAD_SETTINGS = [
    ("T_window", AvoidanceConfig(T_window=0.0)),
    ("T_window", AvoidanceConfig(T_window=NAN)),
    ("T_wide", AvoidanceConfig(T_wide=-1.0)),
    ("crop_radius_m", AvoidanceConfig(crop_radius_m=-1.0)),
    ("crop_height_m", AvoidanceConfig(crop_height_m=float("inf"))),
    ("body_rate", AvoidanceConfig(body_rate=0.0)),
    ("evaluation_step_s", AvoidanceConfig(evaluation_step_s=1e-9)),
    ("settle_s", AvoidanceConfig(settle_s=-0.1)),
    ("capacity", AvoidanceConfig(capacity=0)),
    ("checks", AvoidanceConfig(checks=0)),
    ("speed.V_fast", AvoidanceConfig(speed=SpeedConfig(V_fast=-1.0))),
    ("speed.V_still", AvoidanceConfig(speed=SpeedConfig(V_still=NAN))),
]


BAD_ENERGIES = [
    ("E_avoidance", 0.0),
    ("D_body", -0.3),
    ("D_body", "wide"),
    ("E_time", NAN),
    ("E_time", 0.5),
    ("w_a", -1.0),
    ("w_b", float("inf")),
    ("w_t", None),
]


@pytest.mark.parametrize(("name", "value"), BAD_ENERGIES)
def test_bad_energies_are_named(made_graph: MotionGraph, name: str, value: Any) -> None:
    config = AvoidanceConfig(energy=EnergyConfig(**{name: value}))
    with pytest.raises(ConfigError, match=rf"got energy.{name} = .*, expected [0-9.e+-]+ (…|or)"):
        select(made_graph, 0, throw(np.random.default_rng(0)), config=config)


@pytest.mark.parametrize(("key", "config"), BAD_SETTINGS, ids=lambda x: str(x)[:20])
def test_bad_settings_are_named(made_graph: MotionGraph, key: str, config: AvoidanceConfig) -> None:
    attack = throw(np.random.default_rng(0))
    with pytest.raises(ConfigError, match=rf"got {key} = .*, expected [0-9.e+-]+ (…|or more)"):
        select(made_graph, 0, attack, config=config)


def test_bad_nodes_and_forms(made_graph: MotionGraph) -> None:
    attack = throw(np.random.default_rng(0))
    for node in (-1, made_graph.num_nodes):
        with pytest.raises(ConfigError, match=f"got node {node}, expected 0 …"):
            select(made_graph, node, attack)
    energy = EnergyConfig()
    object.__setattr__(energy, "form", "neither")
    with pytest.raises(
        ConfigError, match=r"got energy.form = 'neither', expected overlap or paper"
    ):
        select(made_graph, 0, attack, config=AvoidanceConfig(energy=energy))
    bad = replace(attack, radii=np.array([-0.1]))
    with pytest.raises(AttackError, match="radius"):
        select(made_graph, 0, bad)


def test_unchecked_candidates_are_not_called_hit(any_graph: MotionGraph, answers: list) -> None:
    # Called hit is what is looked at and touched, and what the samples show deep in the attack.
    config = replace(QUICK, checks=1)
    seen = 0
    for node, attack, chosen in with_status(answers, "hit"):
        one = select(any_graph, node, attack, config=config)
        if one.status != "hit":
            continue
        _, found = judged(any_graph, node, attack, config)
        usable = found["status"] == OK
        deep = int((usable & (found["d"] < -HOPELESS_M)).sum())
        looked_at = max(min(int(usable.sum()) - deep, 1), 0)
        assert one.dropped.hit >= looked_at
        assert abs(one.dropped.hit - max(deep + looked_at, 1)) <= 1  # rounding
        total = chosen.dropped.hit + chosen.dropped.overflow
        assert one.dropped.hit + one.dropped.overflow == total
        seen += 1
    assert seen


def test_a_wider_window_where_nothing_is_clear(any_graph: MotionGraph, answers: list) -> None:
    """What avoids stays; elsewhere the choice is that of the wider window, or touched less."""
    wide = replace(QUICK, T_wide=2.0)
    only = replace(QUICK, T_window=2.0)
    plain = [(n, a, choose(any_graph, n, a, config=QUICK)) for n, a, _ in answers]
    asked = [a for a in plain if a[2].status != "avoided"][:3]
    asked += [a for a in plain if a[2].status == "avoided"][:1]
    batch = select_batch(any_graph, [a[0] for a in asked], [a[1] for a in asked], config=wide)
    for i, (node, attack, before) in enumerate(asked):
        got = choose(any_graph, node, attack, config=wide)
        assert tuple(Status)[batch.status[i]] == got.status
        assert batch.candidates[i] == got.candidates
        if before.status == "avoided":
            path, same = (x.walk.edges[: x.path_length] for x in (got, before))
            np.testing.assert_array_equal(path, same)
            continue
        other = choose(any_graph, node, attack, config=only)
        assert got.candidates == other.candidates
        assert got.status == other.status
        if got.status == "hit":
            narrow = choose(any_graph, node, attack, config=QUICK)
            least = max(other.clearance_m, narrow.clearance_m or -np.inf)
            assert got.clearance_m >= least - 1e-6


def test_capacity_is_counted(any_graph: MotionGraph, answers: list) -> None:
    node, attack, chosen = next(
        a for a in answers if a[2].status != "no_candidate" and a[2].candidates > 8
    )
    small = select(any_graph, node, attack, config=replace(QUICK, capacity=4))
    assert small.candidates == chosen.candidates
    assert small.dropped.overflow >= chosen.candidates - 4


def wall(start: float, stop: float) -> Attack:
    """A large sphere that is everywhere near the body from ``start`` to ``stop``, seconds."""
    return Attack(
        times=np.array([start, stop]),
        centres=np.array([[[0.0, 1.0, 0.0]]] * 2),
        radii=np.array([50.0]),
    )


def test_clear_until() -> None:
    # The path is an edge of 1 s; all that can follow runs into a sphere that is everywhere later.
    graph = make_graph([(0, 1, 30), (1, 0, 20), (1, 1, 25)], [(0, 6, 12)], sway=0.003)
    attack = wall(1.2, 2.0)
    path = make_walk(graph, [0])
    posed = prepared_for(graph, QUICK).posed
    played = continue_clear(posed, attack, path, QUICK)
    assert played.clear_until == 1.0
    assert played.walk.edges[0] == 0
    assert float(played.walk.starts(graph)[-1]) >= 2.2
    # A path that is touched itself is not continued with care.
    touched = continue_clear(posed, wall(0.5, 2.0), path, QUICK)
    assert touched.clearance < 0
    assert touched.clear_until is None
    # However far ahead: clear until the edge during which it comes.
    far = continue_clear(posed, wall(3.5, 6.0), path, QUICK)
    assert far.clear_until is not None
    assert 2.5 < far.clear_until <= 3.5 + 1e-9


def test_goes_on_where_it_is_clear() -> None:
    # Two edges can follow the path; a small ball stands where one of them will have a limb.
    graph = make_graph([(0, 1, 30), (1, 0, 40), (1, 0, 41)], [(0, 6, 12)], sway=0.05)
    spheres = preset_spheres(graph.skeleton)
    posed = prepared_for(graph, QUICK).posed
    walks = [make_walk(graph, [0, edge]) for edge in (1, 2)]
    traces = [
        sphere_trajectory(graph, spheres, captured_motion(graph, walk, 2.3)) for walk in walks
    ]
    late = 2 * 240
    for own, other in ((0, 1), (1, 0)):
        apart = traces[own].centres[late][:, None] - traces[other].centres[late][None]
        free = (np.linalg.norm(apart, axis=-1) - spheres.radii).min(axis=1)
        place = traces[own].centres[late][np.argmax(free)]
        attack = Attack(
            times=np.array([1.98, 2.02]),
            centres=np.tile(place, (2, 1, 1)),
            radii=np.array([0.01]),
        )
        assert clearance(attack, traces[own], spheres.radii)[1] < 0
        assert CLEAR_M < clearance(attack, traces[other], spheres.radii)[1] < FAR
        played = continue_clear(posed, attack, make_walk(graph, [0]), QUICK)
        assert played.clear_until is None
        assert played.walk.edges[:2].tolist() == [0, 1 + other]
        assert CLEAR_M < played.clearance < FAR
