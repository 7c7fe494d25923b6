from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mgjax.core import quaternion, two_bone
from tests.core.batches import (
    assert_finite_gradient,
    assert_same_everywhere,
    over_batch_shapes,
    vectors,
)
from tests.reference import kinematics as reference

HIP, KNEE, ANKLE = np.array([0, 0.9, 0]), np.array([0, 0.45, 0.05]), np.array([0.0, 0, 0])
STRAIGHT_KNEE = np.array([0, 0.45, 0.0])
AHEAD = np.array([0, 0, 1.0])


def place(hip, knee, ankle, turns) -> tuple[np.ndarray, np.ndarray]:
    """Knee and ankle after the turns, by matrices."""
    hip_turn, knee_turn = (reference.matrix(q) for q in turns)
    new_knee = hip + hip_turn @ (knee - hip)
    return new_knee, new_knee + hip_turn @ knee_turn @ (ankle - knee)


def solve(hip, knee, ankle, target, pole=AHEAD):
    turns = two_bone.solve(*(np.asarray(v, np.float64) for v in (hip, knee, ankle, target, pole)))
    for q in turns:
        assert np.linalg.norm(q) == pytest.approx(1, abs=1e-6)
    return place(hip, knee, ankle, turns)


def test_right_angle_worked_by_hand():
    # Bones of 3 and 4, target at distance 5 straight down: the knee angle is 90°. It bends
    # forward: knee at distance 3·3/5 = 1.8 along the line and 3·4/5 = 2.4 ahead of it.
    knee, ankle = solve(
        np.zeros(3), np.array([0, -3.0, 0]), np.array([0, -7.0, 0]), np.array([0, -5.0, 0])
    )
    np.testing.assert_allclose(ankle, [0, -5, 0], atol=1e-9)
    np.testing.assert_allclose(knee, [0, -1.8, 2.4], atol=1e-9)


def test_nothing_to_do():
    turns = two_bone.solve(HIP, KNEE, ANKLE, ANKLE, AHEAD)
    for q in turns:
        assert abs(q[0]) == pytest.approx(1, abs=1e-9)


@given(st.integers(0, 10**6))
def test_reachable_targets_are_met_with_rigid_bones(seed):
    rng = np.random.default_rng(seed)
    hip, knee, ankle = rng.normal(size=(3, 3))
    a, b = np.linalg.norm(knee - hip), np.linalg.norm(ankle - knee)
    assume(min(a, b) > 0.1)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    low, high = abs(a - b) * 1.002 + 2e-3, (a + b) * 0.999
    assume(low < high)
    target = hip + direction * rng.uniform(low, high)
    now = ankle - hip
    assume(direction @ now / np.linalg.norm(now) > -0.999)
    new_knee, new_ankle = solve(hip, knee, ankle, target, rng.normal(size=3))
    np.testing.assert_allclose(new_ankle, target, atol=1e-6)
    assert np.linalg.norm(new_knee - hip) == pytest.approx(a, abs=1e-9)
    assert np.linalg.norm(new_ankle - new_knee) == pytest.approx(b, abs=1e-9)


@given(st.floats(0.3, 0.89), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_float32_is_exact_to_a_tenth_of_a_millimetre(depth, x, z):
    target = HIP + np.array([x, -depth, z])
    assume(np.linalg.norm(target - HIP) < 0.89)
    for knee in (KNEE, STRAIGHT_KNEE):
        turns = two_bone.solve(
            *(np.asarray(v, np.float32) for v in (HIP, knee, ANKLE, target, AHEAD))
        )
        np.testing.assert_allclose(place(HIP, knee, ANKLE, turns)[1], target, atol=1e-4)


@pytest.mark.parametrize("pole", [AHEAD, -AHEAD, np.array([1.0, 0, 0]), np.array([5.0, 3, 5])])
def test_a_straight_leg_bends_towards_the_pole(pole):
    knee, ankle = solve(HIP, STRAIGHT_KNEE, ANKLE, np.array([0, 0.3, 0]), pole)
    np.testing.assert_allclose(ankle, [0, 0.3, 0], atol=1e-6)
    assert (knee - HIP) @ (pole * [1, 0, 1]) > 0.1


@pytest.mark.parametrize("pole", [np.zeros(3), np.array([0, 1.0, 0]), np.array([0, -3.0, 0])])
def test_a_straight_leg_with_a_useless_pole_still_arrives(pole):
    _, ankle = solve(HIP, STRAIGHT_KNEE, ANKLE, np.array([0.1, 0.3, 0]), pole)
    np.testing.assert_allclose(ankle, [0.1, 0.3, 0], atol=1e-6)


def test_short_straight_bones_bend_too():
    # A finger: 2 cm and 2 cm.
    hip, knee, ankle = np.zeros(3), np.array([0, -0.02, 0]), np.array([0, -0.04, 0])
    _, end = solve(hip, knee, ankle, np.array([0, -0.03, 0]))
    np.testing.assert_allclose(end, [0, -0.03, 0], atol=1e-5)


def test_out_of_reach_is_approached():
    _, far = solve(HIP, KNEE, ANKLE, np.array([0, -5.0, 0]))
    length = np.linalg.norm(HIP - KNEE) + np.linalg.norm(KNEE - ANKLE)
    np.testing.assert_allclose(far, HIP - [0, length * 0.9995, 0], atol=1e-6)
    # Bones of 3 and 1: nearer than 2 cannot be.
    _, near = solve(
        np.zeros(3), np.array([0, -3.0, 0]), np.array([0, -3.0, 1]), np.array([0, -1.0, 0])
    )
    np.testing.assert_allclose(near, [0, -2, 0], atol=5e-3)


@over_batch_shapes
def test_numpy_jax_jit_and_vmap_agree(batch):
    arrays = [vectors(batch, s) for s in range(5)]
    assert_same_everywhere(two_bone.solve, *arrays, atol=1e-3)


DEGENERATE = {
    "straight leg": (HIP, STRAIGHT_KNEE, ANKLE, np.array([0, 0.3, 0])),
    "straight leg, target where it is": (HIP, STRAIGHT_KNEE, ANKLE, ANKLE),
    "target on the hip": (HIP, KNEE, ANKLE, HIP),
    "straight leg, target on the hip": (HIP, STRAIGHT_KNEE, ANKLE, HIP),
    "target opposite": (HIP, KNEE, ANKLE, np.array([0, 1.6, 0])),
    "target far away": (HIP, KNEE, ANKLE, np.array([0, -50.0, 0])),
    "ankle on the hip": (HIP, KNEE, HIP, ANKLE),
    "shin of no length": (HIP, KNEE, KNEE, ANKLE),
    "thigh of no length": (HIP, HIP, ANKLE, KNEE),
    "all in one place": (HIP, HIP, HIP, HIP),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_legs_have_finite_gradients(name):
    for pole in (AHEAD, np.zeros(3), np.array([0, 1.0, 0])):
        assert_finite_gradient(two_bone.solve, *DEGENERATE[name], pole)
        turns = two_bone.solve(*DEGENERATE[name], pole)
        assert all(np.isfinite(q).all() for q in turns)


@pytest.mark.parametrize("between", [False, True])
def test_local_rotations_put_the_bones_where_the_turns_say(between):
    """World rotations rebuilt from the local ones, with and without twist bones in between."""
    rng = np.random.default_rng(3)
    hip_turn, knee_turn, above, hip, knee, ankle, twist = (
        q / np.linalg.norm(q) for q in rng.normal(size=(7, 4))
    )
    matrix = reference.matrix
    over_knee = np.asarray(quaternion.multiply(hip, twist)) if between else hip
    over_ankle = np.asarray(quaternion.multiply(knee, twist)) if between else knee
    local = two_bone.local_rotations(
        hip_turn, knee_turn, (above, over_knee, over_ankle), (hip, knee, ankle)
    )
    step = matrix(twist) if between else np.eye(3)
    thigh = matrix(above) @ matrix(local[0])
    shin = thigh @ step @ matrix(local[1])
    foot = shin @ step @ matrix(local[2])
    np.testing.assert_allclose(thigh, matrix(hip_turn) @ matrix(hip), atol=1e-12)
    np.testing.assert_allclose(
        shin, matrix(hip_turn) @ matrix(knee_turn) @ matrix(knee), atol=1e-12
    )
    np.testing.assert_allclose(foot, matrix(ankle), atol=1e-12)
