"""Angles beyond what capture shows."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core import quaternion
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.quality.limits import beyond, captured_ranges
from tests.quality.moving import moving
from tests.reference import quality as reference

ARM = Skeleton(
    names=("root", "upper", "lower", "end"),
    parents=(-1, 0, 1, 2),
    offsets=np.array([[0, 0, 0], [0, 1, 0], [0, 1, 0], [0, 1, 0]], np.float32),
    end_joints=(3,),
)


def bent(degrees: np.ndarray, axis: tuple[float, float, float]) -> np.ndarray:
    """Rotations of the lower joint alone. [F, 4, 4]"""
    turns = np.tile([1.0, 0, 0, 0], (len(degrees), 4, 1))
    turns[:, 2] = quaternion.from_axis_angle(np.array(axis, float), np.radians(degrees))
    return turns


def test_a_hinge_by_hand() -> None:
    ranges = captured_ranges(ARM, bent(np.linspace(-10, 40, 51), (1, 0, 0)))
    assert np.asarray(ranges.joints).tolist() == [1, 2]
    asked = np.array([-25.0, -10, 0, 40, 52])
    got = beyond(bent(asked, (1, 0, 0)), ranges)
    np.testing.assert_allclose(got[:, 1, 0], [15, 0, 0, 0, 12], atol=1e-3)
    np.testing.assert_allclose(got[:, 0], 0, atol=1e-3)
    np.testing.assert_allclose(got[:, 1, 1], 0, atol=1e-3)
    # A turn about the bone is twist, and the capture showed none.
    twisted = quaternion.multiply(
        bent(np.array([20.0]), (1, 0, 0)), bent(np.array([7.0]), (0, 1, 0))
    )
    np.testing.assert_allclose(beyond(twisted, ranges)[0, 1], [0, 7], atol=1e-3)


def test_twist_goes_round() -> None:
    """Captured from 100° to 179°, asked at −175°, which is 185°."""
    axis = (0.0, 1.0, 0.0)
    ranges = captured_ranges(ARM, bent(np.linspace(100, 179, 80), axis))
    got = beyond(bent(np.array([-175.0, 95.0, 120.0]), axis), ranges)
    np.testing.assert_allclose(got[:, 1, 1], [6, 5, 0], atol=1e-2)
    # From the mean that is 45° and more away; with the last one near half a turn from it, too.
    far = beyond(bent(np.array([-45.0]), axis), ranges)
    assert float(far[0, 1, 1]) == pytest.approx(136, abs=0.01)


def test_against_the_definition(body: Skeleton) -> None:
    known, other = (moving(body, 1.0, seed) for seed in (1, 2))
    ranges = captured_ranges(body, np.asarray(known.local_rotations))
    assert float(np.max(beyond(np.asarray(known.local_rotations), ranges))) < 1e-3
    got = np.asarray(jax.jit(beyond)(jnp.asarray(other.local_rotations), ranges))
    limits = ranges.limits
    for row, joint in enumerate(np.asarray(ranges.joints).tolist()):
        axes = [np.asarray(a[row], np.float64) for a in (limits.centre, limits.bone, limits.across)]
        shown = [
            reference.angles(q.astype(np.float64), *axes) for q in known.local_rotations[:, joint]
        ]
        asked = [
            reference.angles(q.astype(np.float64), *axes) for q in other.local_rotations[:, joint]
        ]
        for column in (0, 1):
            seen = np.array([x[column] for x in shown])
            there = np.array([x[column] for x in asked])
            over = np.maximum(there - seen.max(axis=0), 0) + np.maximum(seen.min(axis=0) - there, 0)
            size = np.linalg.norm(over, axis=-1) if column == 0 else over
            np.testing.assert_allclose(got[:, row, column], np.degrees(size), atol=2e-2)
    assert got.max() > 1


def test_slopes(body: Skeleton, random_motion) -> None:
    """They are numbers at the centre, at the edge, and half a turn away."""
    known: Motion = moving(body, 1.0, 1)
    ranges = captured_ranges(body, np.asarray(known.local_rotations))
    rest = np.tile(np.array([1, 0, 0, 0], np.float32), (body.num_joints, 1))
    centre = rest.copy()
    centre[np.asarray(ranges.joints)] = ranges.limits.centre
    half = np.roll(centre, 2, axis=-1)
    wild = np.asarray(random_motion(body, 1).local_rotations)[0]
    total = jax.jit(jax.grad(lambda q: beyond(q, ranges).sum()))
    for pose in (rest, centre, half, wild, np.asarray(known.local_rotations)[0]):
        assert bool(jnp.isfinite(total(jnp.asarray(pose))).all())


def test_an_end_without_children_and_one_that_never_turns() -> None:
    bare = Skeleton(names=("a", "b"), parents=(-1, 0), offsets=np.zeros((2, 3), np.float32))
    still = np.tile([1.0, 0, 0, 0], (5, 2, 1))
    ranges = captured_ranges(bare, still)
    assert float(np.max(beyond(still, ranges))) == 0.0
    turned = still.copy()
    turned[:, 1] = quaternion.from_axis_angle(np.array([0, 1.0, 0]), np.array(0.1))
    assert float(np.max(beyond(turned, ranges))) == pytest.approx(np.degrees(0.1), rel=1e-4)
