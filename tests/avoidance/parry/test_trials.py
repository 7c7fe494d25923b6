"""Trials in one compiled call: against forward kinematics, padded and compiled ahead."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.parry.checked import keeps_limits, track_of
from mgjax.avoidance.parry.course import course, turn_arm
from mgjax.avoidance.parry.guard import Guard, guard_of
from mgjax.avoidance.parry.lanes import Asked, lanes_of, touching
from mgjax.avoidance.parry.parry import compile_parrying
from mgjax.avoidance.parry.trials import MISS_M, PLACES, Tried, try_jitted
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph
from tests.avoidance.parry.made import ball_at_chest, standing
from tests.reference import parry as reference


@pytest.fixture(scope="module")
def attack(guarding: MotionGraph) -> Attack:
    return ball_at_chest(guarding, side=0.1)


@pytest.fixture(scope="module")
def motion(guarding: MotionGraph) -> Motion:
    return standing(guarding)


def asked_of(guard: Guard, motion: Motion, attack: Attack) -> Asked:
    track, trace = track_of(guard, motion)
    assert touching(attack, trace, guard.spheres.radii) is not None
    asked = lanes_of(guard, motion, track, trace, attack, 0)
    assert asked is not None
    return asked


@pytest.fixture(scope="module")
def asked(guarding: MotionGraph, motion: Motion, attack: Attack) -> Asked:
    return asked_of(guard_of(guarding), motion, attack)


@pytest.fixture(scope="module")
def tried(asked: Asked) -> Tried:
    return jax.tree.map(np.asarray, try_jitted(asked.body, asked.trials))


def test_good_trials_meet_the_ball_as_forward_kinematics_has_it(asked: Asked, tried: Tried) -> None:
    trials = asked.trials
    good = np.flatnonzero(tried.good & asked.real)
    assert {int(a) for a in np.asarray(trials.arm)[good]} == {0, 1}
    for k in good[:: max(len(good) // 30, 1)]:
        pose = {name: np.asarray(v)[k].astype(np.float64) for name, v in vars(trials.pose).items()}
        place = float(trials.place[k])
        point = pose["elbow"] + place * (pose["wrist"] - pose["elbow"])
        radius = float(asked.body.radii[1 if place < 1 else 2])
        if place > 1:
            point = pose["wrist"] + (place - 1) * (pose["tip"] - pose["wrist"])
        bones = pose["shoulder"], pose["elbow"]
        frames = pose["shoulder_turn"], pose["elbow_turn"], tried.turns[k].astype(np.float64)
        _, there = reference.arm_turned(*bones, point, *frames)
        # On the far side of the ball, its surface on that of the limb.
        away = there - np.asarray(trials.centre)[k]
        target = np.asarray(trials.way)[k] * (float(trials.radius) + radius)
        assert np.linalg.norm(away - target) < MISS_M + 1e-4
        hand = 0.5 if place > 1 else 0.0
        assert tried.effort[k] == pytest.approx(np.linalg.norm(tried.turns[k]) + hand, abs=1e-4)
    assert {round(float(x), 3) for x in np.asarray(trials.place)} == set(PLACES)


def test_good_trials_keep_the_limits_of_the_written_motion(
    guarding: MotionGraph, motion: Motion, asked: Asked, tried: Tried
) -> None:
    guard = guard_of(guarding)
    old = track_of(guard, motion)[0]
    times = np.arange(motion.num_frames) / EXPORT_RATE
    good = np.flatnonzero(tried.good & asked.real)
    kept = []
    for k in good[np.argsort(tried.effort[good])][:12]:
        arm = guard.arms[int(asked.trials.arm[k])]
        start, values = course(float(asked.trials.contact[k]), tried.turns[k])
        after = turn_arm(motion, arm, times, values, start)
        kept.append(keeps_limits(guard, arm, motion, after, old, track_of(guard, after)[0]))
    assert len(kept) == 12
    assert np.mean(kept) > 0.8  # they are measured 60 times a second, the motion 120


def test_one_arm_is_tried_as_if_there_were_two(
    guarding: MotionGraph, motion: Motion, attack: Attack, asked: Asked, tried: Tried
) -> None:
    whole = guard_of(guarding)
    limits = jax.tree.map(lambda x: np.asarray(x)[:2], whole.limits)
    left = asked_of(replace(whole, arms=whole.arms[:1], limits=limits), motion, attack)
    assert left.real.shape == asked.real.shape
    assert left.real.sum() == asked.real.sum() / 2
    alone = jax.tree.map(np.asarray, try_jitted(left.body, left.trials))
    half = len(left.real) // 2
    np.testing.assert_allclose(alone.turns[:half], tried.turns[:half], atol=1e-5)
    np.testing.assert_array_equal(alone.good[:half], tried.good[:half])


def test_compiled_ahead(guarding: MotionGraph, asked: Asked) -> None:
    compile_parrying(guarding)
    programs = try_jitted._cache_size()
    try_jitted(asked.body, asked.trials)
    assert try_jitted._cache_size() == programs
