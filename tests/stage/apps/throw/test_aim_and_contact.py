from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import BodySpheres
from mgjax.stage.apps.throw.aim import BESIDE_M, passing_point, thrown_along, thrown_at_random
from mgjax.stage.apps.throw.contact import RESTITUTION, first_contact, part_of, track
from mgjax.stage.apps.throw.settings import BallSettings

FAR_EYE, NEAR_EYE = np.array([0.0, 1.4, 20.0]), np.array([0.0, 1.4, 4.0])
GOAL = np.array([0.0, 1.4, 0.0])
SETTINGS = BallSettings(speed=8.0, notice=1.25)


def test_a_ball_flies_along_the_ray_to_the_goal():
    ball = thrown_along(FAR_EYE, GOAL, GOAL, 3.0, SETTINGS)
    assert ball.start == pytest.approx(3.0)
    np.testing.assert_allclose(ball.at(np.array([3.0]))[0, 0], [0, 1.4, 10.0], atol=1e-6)
    np.testing.assert_allclose(ball.at(np.array([4.25]))[0, 0], GOAL, atol=1e-6)


def test_a_ball_from_behind_the_eye_passes_beside_it():
    ball = thrown_along(NEAR_EYE, GOAL, GOAL, 0.0, SETTINGS)
    moments = np.linspace(ball.start, ball.end, 500)
    places = ball.at(moments)[:, 0]
    nearest = np.linalg.norm(places - NEAR_EYE, axis=1).min()
    assert nearest > 0.8 * BESIDE_M
    at = places[np.argmin(np.abs(places[:, 2] - NEAR_EYE[2]))]
    # The eye looks along −Z, so its right is +X.
    assert at[0] > 0.4 and at[1] > NEAR_EYE[1]  # noqa: PT018
    np.testing.assert_allclose(ball.at(np.array([1.25]))[0, 0], GOAL, atol=0.05)


def test_gravity_still_arrives():
    ball = thrown_along(FAR_EYE, GOAL, GOAL, 0.0, replace(SETTINGS, gravity=9.8, speed=12.0))
    np.testing.assert_allclose(ball.at(np.array([1.25]))[0, 0], GOAL, atol=1e-3)


def test_goals_at_the_floor_are_over_it():
    ball = thrown_along(FAR_EYE, np.zeros(3), np.zeros(3), 0.0, SETTINGS)
    assert ball.centres[..., 1].min() >= SETTINGS.radius - 1e-3


def test_random_balls_arrive_at_the_axis():
    rng = np.random.default_rng(0)
    for _ in range(20):
        centre = rng.uniform(-5, 5, 3)
        ball = thrown_at_random(rng, centre, 7.0, SETTINGS)
        there = ball.at(np.array([8.25]))[0, 0]
        np.testing.assert_allclose(there[[0, 2]], centre[[0, 2]], atol=1e-6)
        assert 0.4 < there[1] < 1.7
        assert ball.start == pytest.approx(7.0)


def test_where_a_ray_passes_an_axis():
    place = passing_point(np.array([0.0, 2.0, 4.0]), np.array([0.0, 1.5, 2.0]), np.zeros(3))
    np.testing.assert_allclose(place, [0, 1.0, 0], atol=1e-9)
    up = passing_point(np.array([0.0, 2.0, 4.0]), np.array([0.0, 9.0, 2.0]), np.zeros(3))
    assert up[1] == 2.3


BODY = BodySpheres(
    names=("left_elbow-left_wrist 0.00",),
    first=np.array([0]),
    second=np.array([0]),
    share=np.zeros(1, np.float32),
    radii=np.array([0.3], np.float32),
)


def flying(height: float = 1.0) -> Attack:
    """A ball of 0.2 m that flies from x = 5 m along −X at 5 m/s."""
    centres = np.array([[[5.0, height, 0.0]], [[-5.0, height, 0.0]]])
    return Attack(times=np.array([0.0, 2.0]), centres=centres, radii=np.array([0.2]))


def test_a_contact_by_hand():
    times = np.array([0.0, 2.0])
    centres = np.zeros((2, 1, 3))
    centres[..., 1] = 1.0
    contact = first_contact(flying(), BODY, times, centres)
    assert contact is not None
    # Surfaces meet at x = 0.5, after 4.5 m at 5 m/s.
    assert contact.time == pytest.approx(0.9, abs=1 / 240 + 1e-6)
    assert contact.part == "left forearm"
    np.testing.assert_allclose(contact.velocity, [5.0 * RESTITUTION, 0, 0], atol=0.05)
    times, places = track(flying(), contact, 0.2)
    assert (np.diff(times) > 0).all()
    np.testing.assert_allclose(places[1], contact.place)
    assert (places[:, 0] >= contact.place[0] - 1e-6).all()
    assert places[:, 1].min() >= 0.2 - 1e-3


def test_a_ball_that_passes():
    centres = np.zeros((2, 1, 3))
    assert first_contact(flying(), BODY, np.array([0.0, 2.0]), centres) is None
    assert first_contact(flying(), BODY, np.array([3.0, 4.0]), centres) is None
    times, places = track(flying(), None, 0.2)
    assert times[1] == 2.0
    assert places[-1, 1] == pytest.approx(0.2, abs=0.4)


def test_parts_in_words():
    names = ("head-head_end 0.50", "root-chest 0.00", "right_ankle-right_toe 1.00")
    body = replace(BODY, names=names)
    assert [part_of(body, i) for i in range(3)] == ["head", "pelvis", "right foot"]
