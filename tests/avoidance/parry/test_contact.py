"""First contacts: worked by hand, and against many small steps."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.parry.contact import Track, first_contact, least_gap
from mgjax.core.body.capsules import Capsules
from tests.reference import parry as reference


def forearm_and_trunk() -> Capsules:
    """Two bones: joints 0–1, of radius 4 cm, and 2–3, of 10 cm."""
    return Capsules(
        joints=np.array([[0, 1], [2, 3]]),
        radii=np.array([0.04, 0.10]),
        parts=("forearm", "torso"),
        arms=("left", ""),
    )


def flying(start: np.ndarray, stop: np.ndarray, seconds: float, radius: float = 0.12) -> Attack:
    return Attack(
        times=np.array([0.0, seconds]),
        centres=np.stack([start, stop])[:, None],
        radii=np.array([radius]),
    )


def test_a_ball_on_a_forearm_worked_by_hand() -> None:
    # The forearm lies along x at z = 1, the trunk at z = 0. The ball comes along −z from z = 3 at
    # 10 m/s, 25 cm of 50 along the forearm: they meet when its centre is at z = 1.16.
    places = np.array([[-0.25, 1, 1], [0.25, 1, 1], [0, 0.8, 0], [0, 1.4, 0.0]])
    track = Track(times=np.arange(121) / 240, positions=np.tile(places, (121, 1, 1)))
    attack = flying(np.array([0, 1, 3.0]), np.array([0, 1, -1.0]), 0.4)
    found = first_contact(forearm_and_trunk(), track, attack, 0)
    assert found is not None
    assert found.capsule == 0
    assert found.time == pytest.approx(0.184, abs=1e-6)
    assert found.share == pytest.approx(0.5, abs=1e-6)
    assert found.square == pytest.approx(1.0, abs=1e-9)
    assert found.along == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(found.place, [0, 1, 1.04], atol=1e-5)
    trunk = np.array([False, True])
    # Then it is 1.16 m from the trunk's bone, of which 22 cm are surfaces.
    gap = least_gap(forearm_and_trunk(), track, attack, 0, trunk, found.time)
    assert 0.94 - 0.003 < gap <= 0.94 + 1e-9
    assert first_contact(forearm_and_trunk(), track, attack.ended(0, 0.18), 0) is None
    second = first_contact(forearm_and_trunk(), track, attack, 0, trunk)
    assert second is not None
    assert second.time == pytest.approx((3 - 0.22) / 10, abs=1e-6)


def test_any_flight_touches_first_what_small_steps_say() -> None:
    rng = np.random.default_rng(5)
    capsules = forearm_and_trunk()
    touched = 0
    for _ in range(12):
        begin = rng.normal(scale=0.4, size=(4, 3))
        move = rng.normal(scale=1.0, size=(4, 3))
        times = np.arange(97) / 240
        track = Track(times=times, positions=begin + times[:, None, None] * move)
        start = rng.normal(size=3)
        start *= 2.5 / np.linalg.norm(start)
        attack = flying(start, -start + rng.normal(scale=0.2, size=3), 0.39)
        fine = np.linspace(0, 0.39, 2001)
        expected = reference.touched_first(
            fine, track.at(fine), capsules.joints, capsules.radii, attack.at(fine)[:, 0], 0.12
        )
        found = first_contact(capsules, track, attack, 0)
        assert (found is None) == (expected is None)
        if found is None or expected is None:
            continue
        touched += 1
        moment, capsule = expected
        assert fine[moment - 1] - 1e-6 <= found.time <= fine[moment] + 1e-6
        assert found.capsule == capsule
        other = np.arange(2) != capsule
        gap = least_gap(capsules, track, attack, 0, other, found.time)
        b = capsules.joints[1 - capsule]
        exact = min(
            reference.to_segment(attack.at(fine[k : k + 1])[0, 0], *track.at(fine[k : k + 1])[0, b])
            - capsules.radii[1 - capsule]
            - 0.12
            for k in range(moment)
        )
        assert gap <= exact + 1e-6
        assert gap > exact - 0.01
    assert touched > 3
