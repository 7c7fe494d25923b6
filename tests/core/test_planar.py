from __future__ import annotations

import numpy as np
import pytest

from mgjax.core import planar, quaternion
from tests.core.batches import (
    assert_finite_gradient,
    assert_same_everywhere,
    over_batch_shapes,
    unit_quaternions,
    vectors,
)
from tests.reference import kinematics as reference


def test_quarter_turn_worked_by_hand():
    # θ = 90°: x ← z, z ← −x; then 10 is added to x and 20 to z.
    transform = np.array([np.pi / 2, 10.0, 20.0])
    np.testing.assert_allclose(planar.apply(transform, np.array([1.0, 2, 3])), [13, 2, 19])


def test_heading_worked_by_hand():
    root, left, right = np.array([5.0, 1, 7]), np.array([0.1, 1, 0]), np.array([-0.1, 1, 0])
    # Left hip at +X: the body looks along +Z. Left hip at −Z: it looks along +X.
    np.testing.assert_allclose(planar.frame_of(root, left, right), [0, 5, 7])
    left, right = np.array([0, 1, -0.1]), np.array([0, 1, 0.1])
    np.testing.assert_allclose(planar.frame_of(root, left, right), [np.pi / 2, 5, 7])


@over_batch_shapes
def test_apply_matches_reference(batch):
    t, p = vectors(batch, 1), vectors(batch, 2)
    got = planar.apply(t, p).reshape(-1, 3)
    want = [
        reference.planar_apply(a, b)
        for a, b in zip(t.reshape(-1, 3), p.reshape(-1, 3), strict=True)
    ]
    np.testing.assert_allclose(got, want, atol=2e-6)


@over_batch_shapes
def test_compose_inverse_and_identity(batch):
    a, b, p = vectors(batch, 3), vectors(batch, 4), vectors(batch, 5)
    chained = planar.apply(a, planar.apply(b, p))
    np.testing.assert_allclose(planar.apply(planar.compose(a, b), p), chained, atol=5e-6)
    back = planar.apply(planar.inverse(a), planar.apply(a, p))
    np.testing.assert_allclose(back, p, atol=2e-6)
    nothing = planar.compose(planar.inverse(a), a)
    np.testing.assert_allclose(nothing, np.zeros_like(a), atol=1e-6)
    np.testing.assert_array_equal(planar.apply(planar.identity(p), p), p)


@over_batch_shapes
def test_apply_pose_turns_like_apply(batch):
    t, root, q, v = vectors(batch, 6), vectors(batch, 7), unit_quaternions(batch, 8), vectors(batch)
    place, turn = planar.apply_pose(t, root, q)
    np.testing.assert_allclose(
        place + quaternion.rotate(turn, v),
        planar.apply(t, root + quaternion.rotate(q, v)),
        atol=5e-6,
    )


@over_batch_shapes
def test_frame_follows_the_body(batch):
    root, left, right, t = (vectors(batch, s) for s in (9, 10, 11, 12))
    frame = planar.frame_of(root, left, right)
    want = [
        reference.heading(a, b)
        for a, b in zip(left.reshape(-1, 3), right.reshape(-1, 3), strict=True)
    ]
    np.testing.assert_allclose(frame.reshape(-1, 3)[:, 0], want, atol=1e-5)
    moved = planar.frame_of(*(planar.apply(t, p) for p in (root, left, right)))
    difference = moved - planar.compose(t, frame)
    np.testing.assert_allclose(np.sin(difference[..., 0]), 0, atol=1e-5)
    np.testing.assert_allclose(difference[..., 1:], 0, atol=5e-6)
    # In its own frame every body looks along +Z from the origin.
    own = planar.compose(planar.inverse(frame), frame)
    np.testing.assert_allclose(own, np.zeros_like(own), atol=1e-6)


def everything(t, u, p, q):
    return (
        planar.apply(t, p),
        planar.compose(t, u),
        planar.inverse(t),
        planar.apply_pose(t, p, q),
        planar.frame_of(t, u, p),
    )


@over_batch_shapes
def test_numpy_jax_jit_and_vmap_agree(batch):
    arrays = [vectors(batch, s) for s in (1, 2, 3)]
    assert_same_everywhere(everything, *arrays, unit_quaternions(batch), atol=1e-5)


@pytest.mark.parametrize("left", [np.zeros(3), np.array([0, 0.3, 0]), np.array([0, -1.0, 0])])
def test_hips_above_one_another(left):
    assert_finite_gradient(planar.frame_of, np.ones(3), left, np.zeros(3))
    np.testing.assert_allclose(planar.frame_of(np.ones(3), left, np.zeros(3)), [0, 1, 1])
