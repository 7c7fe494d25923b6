from __future__ import annotations

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.core import quaternion
from tests.core.batches import (
    assert_finite_gradient,
    assert_same_everywhere,
    over_batch_shapes,
    scalars,
    unit_quaternions,
    vectors,
)
from tests.reference import kinematics as reference

S = np.sqrt(0.5)


def flat(array: np.ndarray, size: int) -> np.ndarray:
    return array.reshape(-1, size)


def assert_same_rotation(a, b, atol: float = 1e-5) -> None:
    for p, q in zip(flat(np.asarray(a), 4), flat(np.asarray(b), 4), strict=True):
        np.testing.assert_allclose(reference.matrix(p), reference.matrix(q), atol=atol)


# --- worked by hand -------------------------------------------------------------------------


def test_quarter_turn_about_z_takes_x_to_y():
    q = np.array([S, 0, 0, S])  # cos 45°, sin 45° about z
    np.testing.assert_allclose(quaternion.rotate(q, np.array([1.0, 0, 0])), [0, 1, 0], atol=1e-12)


def test_i_times_j_is_k():
    i, j, k = np.eye(4)[1:]
    np.testing.assert_allclose(quaternion.multiply(i, j), k)
    np.testing.assert_allclose(quaternion.multiply(j, i), -k)


def test_from_yaw_turns_z_to_x():
    q = quaternion.from_yaw(np.array(np.pi / 2))  # +Z turns to (sin θ, 0, cos θ)
    np.testing.assert_allclose(quaternion.rotate(q, np.array([0, 0, 1.0])), [1, 0, 0], atol=1e-12)


def test_euler_order_is_left_to_right():
    # Rz(90°)·Rx(90°) applied to y: Rx takes y to z, Rz leaves z.
    q = quaternion.from_euler(np.deg2rad([90.0, 90.0]), "ZX")
    np.testing.assert_allclose(quaternion.rotate(q, np.array([0, 1.0, 0])), [0, 0, 1], atol=1e-12)


def test_slerp_halfway_to_a_quarter_turn():
    half = quaternion.slerp(np.array([1.0, 0, 0, 0]), np.array([S, S, 0, 0]), np.array(0.5))
    angle = np.pi / 8  # half of 90° is 45°, and a quaternion holds half of that
    np.testing.assert_allclose(half, [np.cos(angle), np.sin(angle), 0, 0], atol=1e-12)


def test_angle_between_known():
    a, b = np.array([1.0, 0, 0, 0]), np.array([S, 0, -S, 0])
    assert quaternion.angle_between(a, b) == pytest.approx(np.pi / 2)
    assert quaternion.angle_between(a, -b) == pytest.approx(np.pi / 2)
    assert quaternion.angle_between(a, a) == pytest.approx(0, abs=1e-8)


# --- laws -----------------------------------------------------------------------------------


@over_batch_shapes
def test_multiply_is_composition(batch):
    a, b, v = unit_quaternions(batch, 1), unit_quaternions(batch, 2), vectors(batch, 3)
    both = quaternion.rotate(quaternion.multiply(a, b), v)
    np.testing.assert_allclose(
        both, quaternion.rotate(a, quaternion.rotate(b, v)), rtol=0, atol=1e-5
    )
    want = [
        reference.matrix(p) @ reference.matrix(q) @ x
        for p, q, x in zip(flat(a, 4), flat(b, 4), flat(v, 3), strict=True)
    ]
    np.testing.assert_allclose(flat(both, 3), want, atol=1e-5)


@over_batch_shapes
def test_conjugate_is_inverse(batch):
    q = unit_quaternions(batch, 4)
    one = quaternion.multiply(q, quaternion.conjugate(q))
    np.testing.assert_allclose(one, np.broadcast_to([1, 0, 0, 0], one.shape), atol=1e-6)


@over_batch_shapes
def test_sign_does_not_matter(batch):
    q, v = unit_quaternions(batch, 5), vectors(batch, 6)
    np.testing.assert_allclose(quaternion.rotate(q, v), quaternion.rotate(-q, v), atol=1e-6)


@over_batch_shapes
@pytest.mark.parametrize("order", ["", "X", "YX", "ZYX", "XYZ", "YZX", "XYX", "ZYXZ"])
def test_from_euler_is_the_product_of_matrices(batch, order):
    angles = vectors(batch, 7, len(order))
    got = flat(quaternion.from_euler(angles, order), 4)
    rows = angles.reshape(len(got), len(order))
    for row, q in zip(rows, got, strict=True):
        np.testing.assert_allclose(
            reference.matrix(q), reference.euler(row.astype(float), order), atol=1e-6
        )


@over_batch_shapes
def test_axis_angle_matches_rodrigues(batch):
    axis = vectors(batch, 8)
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = scalars(batch, 9)
    got = quaternion.from_axis_angle(axis, angle)
    for q, x, a in zip(flat(got, 4), flat(axis, 3), angle.reshape(-1), strict=True):
        np.testing.assert_allclose(
            reference.matrix(q), reference.turn_about(x.astype(float), float(a)), atol=1e-6
        )


@over_batch_shapes
def test_rotation_vectors(batch):
    vector = vectors(batch, 10)
    angle = np.linalg.norm(vector, axis=-1)
    turned = quaternion.exp(vector)
    wanted = quaternion.from_axis_angle(vector / angle[..., None], angle)
    np.testing.assert_allclose(turned, wanted, atol=1e-6)
    back = quaternion.log(-turned)  # the same rotation
    short = np.where(
        (angle > np.pi)[..., None], vector * (1 - 2 * np.pi / angle)[..., None], vector
    )
    np.testing.assert_allclose(back, short, atol=1e-5)
    for tiny in (0.0, 1e-13, 1e-5):
        small = np.array([tiny, 0.0, 0.0])
        np.testing.assert_allclose(quaternion.exp(small), [1.0, tiny / 2, 0.0, 0.0], atol=1e-10)
        np.testing.assert_allclose(quaternion.log(quaternion.exp(small)), small, atol=1e-12)
    half = quaternion.log(np.array([0.0, 0.0, 1.0, 0.0]))
    np.testing.assert_allclose(half, [0.0, np.pi, 0.0], atol=1e-12)


@over_batch_shapes
def test_slerp_matches_reference_and_ends(batch):
    a, b = unit_quaternions(batch, 10), unit_quaternions(batch, 11)
    t = scalars(batch, 12, 0, 1)
    got = quaternion.slerp(a, b, t)
    for q, p, r, s in zip(flat(got, 4), flat(a, 4), flat(b, 4), t.reshape(-1), strict=True):
        np.testing.assert_allclose(reference.matrix(q), reference.slerp(p, r, float(s)), atol=1e-5)
    assert_same_rotation(quaternion.slerp(a, b, 0 * t), a)
    assert_same_rotation(quaternion.slerp(a, b, 0 * t + 1), b)
    assert_same_rotation(quaternion.slerp(a, -b, t), got)


@over_batch_shapes
def test_swing_turns_a_to_b_by_the_smallest_angle(batch):
    a, b = vectors(batch, 13), vectors(batch, 14)
    q = quaternion.from_two_vectors(a, b)
    turned = quaternion.rotate(q, a)
    turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
    np.testing.assert_allclose(turned, b / np.linalg.norm(b, axis=-1, keepdims=True), atol=1e-5)
    cosine = np.sum(turned * a, axis=-1) / np.linalg.norm(a, axis=-1)
    one = np.broadcast_to(np.array([1, 0, 0, 0], np.float32), q.shape)
    np.testing.assert_allclose(quaternion.angle_between(one, q), np.arccos(cosine), atol=1e-3)


@given(st.integers(0, 10**6), st.floats(-np.pi, np.pi), st.floats(-np.pi / 2, np.pi / 2))
def test_euler_angles_come_back(seed, outer, pitch):
    roll = np.random.default_rng(seed).uniform(-np.pi, np.pi)
    q = quaternion.from_euler(np.array([outer, pitch, roll]), "ZYX")
    angles = quaternion.to_euler_zyx(q)
    assert_same_rotation(quaternion.from_euler(angles, "ZYX"), q, atol=3e-6)
    assert np.abs(angles).max() <= np.pi + 1e-9


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-6, 1e-5, 1e-4, 4e-4, 1e-3])
def test_euler_angles_are_exact_near_the_poles(sign, gap):
    angles = np.array([1.1, sign * (np.pi / 2 - gap), -0.7])
    q = quaternion.from_euler(angles, "ZYX").astype(np.float32).astype(np.float64)
    back = quaternion.to_euler_zyx(q)
    # 1e-4 m at the end of a body of 2 m is 5e-5 rad.
    assert_same_rotation(quaternion.from_euler(back, "ZYX"), q, atol=5e-6)
    if gap == 0:
        exact = quaternion.to_euler_zyx(quaternion.from_euler(angles, "ZYX"))
        np.testing.assert_allclose(exact, [1.1 + sign * 0.7, sign * np.pi / 2, 0], atol=1e-6)


def test_normalise():
    q = quaternion.normalise(np.array([[0.0, 3, 0, 4], [0, 0, 0, 0]]))
    np.testing.assert_allclose(q, [[0, 0.6, 0, 0.8], [0, 0, 0, 0]])


def test_broadcasting_on_numpy():
    a, b = unit_quaternions((5, 1), 15), unit_quaternions((7,), 16)
    assert quaternion.multiply(a, b).shape == (5, 7, 4)
    assert quaternion.rotate(a, vectors((7,), 17)).shape == (5, 7, 3)
    assert quaternion.slerp(a, b, np.array(0.5, np.float32)).shape == (5, 7, 4)


# --- one function, three libraries ----------------------------------------------------------


def everything(a, b, t, u, v):
    return (
        quaternion.multiply(a, b),
        quaternion.conjugate(a),
        quaternion.rotate(a, u),
        quaternion.normalise(2.0 * a),
        quaternion.from_axis_angle(u, t),
        quaternion.exp(u),
        quaternion.log(a),
        quaternion.from_yaw(t),
        quaternion.from_euler(u, "ZXY"),
        quaternion.from_two_vectors(u, v),
        quaternion.slerp(a, b, t),
        quaternion.angle_between(a, b),
        quaternion.to_euler_zyx(a),
    )


@over_batch_shapes
def test_numpy_jax_jit_and_vmap_agree(batch):
    assert_same_everywhere(
        everything,
        unit_quaternions(batch, 1),
        unit_quaternions(batch, 2),
        scalars(batch, 3, 0, 1),
        vectors(batch, 4),
        vectors(batch, 5),
        atol=1e-5,
    )


# --- degenerate points ----------------------------------------------------------------------

ONE = np.array([1.0, 0, 0, 0])
X = np.array([1.0, 0, 0])


@pytest.mark.parametrize(
    ("a", "b", "t"),
    [(ONE, ONE, 0.3), (ONE, -ONE, 0.3), (ONE, np.eye(4)[1], 0.5), (ONE, ONE, 0.0), (ONE, ONE, 1.0)],
)
def test_slerp_of_equal_and_opposite(a, b, t):
    assert_finite_gradient(quaternion.slerp, a, b, np.array(t))
    q = quaternion.slerp(a, b, np.array(t))
    assert np.linalg.norm(q) == pytest.approx(1, abs=1e-6)
    if abs(a @ b) == 1:
        assert_same_rotation(q, a)


@pytest.mark.parametrize("scale", [1e-3, 1e-4, 1e-5])
def test_slerp_of_nearly_equal(scale):
    b = np.array([np.cos(scale), np.sin(scale), 0, 0], np.float32)
    q = quaternion.slerp(ONE.astype(np.float32), b, np.array(0.25, np.float32))
    assert q[1] == pytest.approx(0.25 * scale, rel=1e-3)


@pytest.mark.parametrize("v", [X, -X, np.zeros(3), 1e-4 * X, np.array([-1.0, 1e-4, 0])])
def test_swing_of_parallel_opposite_and_zero(v):
    assert_finite_gradient(quaternion.from_two_vectors, X, v)
    assert_finite_gradient(quaternion.from_two_vectors, v, X)
    q = quaternion.from_two_vectors(X, v)
    assert np.linalg.norm(q) == pytest.approx(1, abs=1e-6)
    if np.linalg.norm(v) > 0:
        want = v / np.linalg.norm(v)
        np.testing.assert_allclose(quaternion.rotate(q, X), want, atol=2e-3)
    else:
        np.testing.assert_allclose(q, ONE)


@pytest.mark.parametrize("axis", [*np.eye(3), np.array([0.6, -0.64, 0.48])])
def test_swing_of_opposite_is_a_half_turn_about_a_square_axis(axis):
    q = quaternion.from_two_vectors(axis, -axis)
    np.testing.assert_allclose(quaternion.rotate(q, axis), -axis, atol=1e-9)
    assert q[0] == pytest.approx(0, abs=1e-9)
    assert q[1:] @ axis == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("b", [ONE, -ONE, np.eye(4)[2]])
def test_angle_between_has_finite_gradient(b):
    assert_finite_gradient(quaternion.angle_between, ONE, b)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2, 0.0])
def test_euler_at_the_pole_has_finite_gradient(pitch):
    q = quaternion.from_euler(np.array([0.4, pitch, 0.3]), "ZYX")
    assert_finite_gradient(quaternion.to_euler_zyx, q)


def test_normalise_and_axis_angle_of_nothing_have_finite_gradients():
    assert_finite_gradient(quaternion.normalise, np.zeros(4))
    assert_finite_gradient(quaternion.from_axis_angle, X, np.array(0.0))
    assert_finite_gradient(quaternion.exp, np.zeros(3))
    assert_finite_gradient(quaternion.log, ONE)


def test_shapes_are_checked():
    with pytest.raises(Exception, match=r"(?i)type"):
        quaternion.multiply(np.zeros(3), np.zeros(4))
    with pytest.raises(Exception, match=r"(?i)type"):
        jax.eval_shape(quaternion.rotate, np.zeros((2, 4)), np.zeros((2, 4)))
