from __future__ import annotations

import math

import jax
import numpy as np
import pytest

from mgjax.core import quaternion
from mgjax.core.body.joint_limits import (
    clamp,
    from_swing_twist,
    joint_limits,
    random_rotations,
    swing_twist,
)
from tests.core.batches import unit_quaternions

UP = np.array([[0.0, 1.0, 0.0]])
X = [[1.0, 0.0, 0.0]]


def turn(axis, degrees: float) -> np.ndarray:
    q = quaternion.from_axis_angle(np.array(axis, np.float64), np.array(math.radians(degrees)))
    return np.asarray(q, np.float32)[None]


def hinge(low: float, high: float):
    swing = [[math.radians(low), math.radians(high), 0.0, 0.0]]
    return joint_limits(UP, swing=swing, twist=[[0.0, 0.0]], across=X)


def same(a, b, atol=1e-5) -> None:
    assert np.max(quaternion.angle_between(np.asarray(a), np.asarray(b))) < atol


def test_a_hinge_by_hand() -> None:
    # An elbow that bends 0 … 150° about x. The bone points up.
    elbow = hinge(0, 150)
    inside = turn([1, 0, 0], 90)
    np.testing.assert_array_equal(clamp(inside, elbow), inside)
    same(clamp(turn([1, 0, 0], 170), elbow), turn([1, 0, 0], 150), 1e-3)
    same(clamp(turn([1, 0, 0], -20), elbow), turn([1, 0, 0], 0), 1e-3)
    # A twist about the bone is taken out, and so is a bend to the side.
    both = quaternion.multiply(inside, turn([0, 1, 0], 40))
    same(clamp(both, elbow), inside, 1e-3)
    same(clamp(turn([0, 0, 1], 30), elbow), turn([1, 0, 0], 0), 1e-3)


def test_a_cone_with_four_angles_by_hand() -> None:
    # About x −20 … 60°, about bone × x = −z −30 … 40°.
    cone = joint_limits(
        UP, swing=np.radians([[-20, 60, -30, 40]]).tolist(), twist=[[-0.5, 0.5]], across=X
    )
    for axis, degrees, held in (
        ([1, 0, 0], 90, 60),
        ([1, 0, 0], -90, -20),
        ([0, 0, -1], 90, 40),
        ([0, 0, -1], -90, -30),
        ([0, 1, 0], 90, math.degrees(0.5)),
    ):
        same(clamp(turn(axis, degrees), cone), turn(axis, held), 2e-3)


def test_angles_there_and_back() -> None:
    limits = joint_limits(
        np.random.default_rng(0).normal(size=(5, 3)),
        swing=[[-2.0, 2.0, -2.0, 2.0]] * 5,
        twist=[[-3.0, 3.0]] * 5,
        centre=unit_quaternions((5,), 1),
    )
    rotations = unit_quaternions((40, 5))
    swing, twist = swing_twist(rotations, limits)
    same(from_swing_twist(swing, twist, limits), rotations, 2e-3)
    held = clamp(rotations, limits)
    same(clamp(held, limits), held, 2e-3)
    swing, twist = swing_twist(held, limits)
    assert (np.sum((swing / 2) ** 2, axis=-1) < 1.001).all()
    assert (np.abs(twist) < 3.001).all()
    same(jax.jit(clamp)(rotations, limits), held, 2e-3)


@pytest.mark.parametrize("axis", [[1.0, 0, 0], [0, 0, 1.0], [0, 1.0, 0]])
def test_half_turns_are_finite(axis) -> None:
    for degrees in (180, -180, 0, 360):
        held = clamp(turn(axis, degrees), hinge(-10, 10))
        assert np.isfinite(held).all()
        np.testing.assert_allclose(np.linalg.norm(held, axis=-1), 1, atol=1e-5)


def test_random_rotations_are_inside() -> None:
    limits = joint_limits(UP, swing=[[-0.3, 1.0, -0.2, 0.5]], twist=[[-0.1, 0.4]])
    rotations = random_rotations(np.random.default_rng(0), 200, limits)
    same(clamp(rotations, limits), rotations, 2e-3)
