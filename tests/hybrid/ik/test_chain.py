from __future__ import annotations

import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given

import mgjax.hybrid
from mgjax.hybrid import (
    NOT_CONVERGED,
    REACHED,
    UNREACHABLE_FAR,
    UNREACHABLE_NEAR,
    fabrik,
)
from tests.reference import fabrik as reference

TOLERANCE = 1e-3


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def chains(count: int, joints: int = 9, *, seed: int = 0, straight: bool = False) -> tuple:
    """Chains of uneven bones from places near the origin, and generator and bone lengths."""
    rng = np.random.default_rng(seed)
    lengths = rng.uniform(0.03, 0.3, (count, joints - 1))
    bends = 0.0 if straight else 1.0
    ways = unit(rng.normal(size=(count, 1, 3)) + bends * rng.normal(size=(count, joints - 1, 3)))
    places = np.cumsum(ways * lengths[..., None], axis=1)
    start = 0.0 if straight else rng.normal(size=(count, 1, 3))
    points = np.concatenate([np.zeros((count, 1, 3)), places], axis=1) + start
    return points.astype(np.float32), lengths, rng


def targets_at(points: np.ndarray, rng: np.random.Generator, low: float, high: float):
    """Targets at a share of the way from the nearest to the farthest reach."""
    shares = rng.uniform(low, high, len(points))
    ends = np.array([reference.reach(chain) for chain in points])
    distance = ends[:, 0] + shares * (ends[:, 1] - ends[:, 0])
    return (points[:, 0] + unit(rng.normal(size=(len(points), 3))) * distance[:, None]).astype(
        np.float32
    )


def assert_solved(points, targets, found, status) -> None:
    found, status = np.asarray(found), np.asarray(status)
    assert (status == REACHED).all(), np.bincount(status)
    np.testing.assert_array_less(np.linalg.norm(found[:, -1] - targets, axis=-1), 1.5e-3)
    assert_rigid(points, found)


def assert_rigid(points, found) -> None:
    old, new = (np.linalg.norm(np.diff(p, axis=-2), axis=-1) for p in (points, found))
    np.testing.assert_allclose(new, old, atol=1e-5)
    np.testing.assert_array_equal(found[..., 0, :], points[..., 0, :])


def solve(points, targets, **options):
    return fabrik(points, targets, **{"tolerance": TOLERANCE, "max_iterations": 8} | options)


def test_two_bones_by_hand() -> None:
    # Bones of 3 and 4 along x, and 4 along y: the end is at (3, 4, 0). The target (5, 0, 0) is 5
    # away, where the angle between the bones must again be right: the elbow is at 3·3/5 along x and
    # 3·4/5 to the side. No iteration: the one inner joint closes the triangle, on its own side.
    points = np.array([[0, 0, 0], [0, -3, 0], [4, -3, 0]], np.float32)
    found, status = solve(points, np.array([5, 0, 0], np.float32), max_iterations=0)
    assert int(status) == REACHED
    np.testing.assert_allclose(found, [[0, 0, 0], [1.8, -2.4, 0], [5, 0, 0]], atol=1e-5)


def test_one_iteration_by_hand() -> None:
    # Forward: end to (0, 2); the elbow (1, 0) goes to distance 1 from it on the line, direction
    # (1, −2)/√5. Backward: it goes back to length 1 from the root, the end to length 1 from there.
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], np.float32)
    target = np.array([0, 1.5, 0], np.float32)
    elbow = target[:2] + np.array([1, -1.5]) / np.hypot(1, 1.5)
    elbow = elbow / np.linalg.norm(elbow)
    way = target[:2] - elbow
    end = elbow + way / np.linalg.norm(way)
    found, _ = solve(points, target, max_iterations=1, tolerance=0.5)
    np.testing.assert_allclose(found[1:, :2], [elbow, end], atol=1e-6)


def test_agrees_with_plain_loops() -> None:
    points, _, rng = chains(64)
    targets = targets_at(points, rng, 0.3, 0.8)
    found, _ = solve(points, targets, max_iterations=32)
    compared = 0
    for chain, target, got in zip(points, targets, np.asarray(found), strict=True):
        wanted, taken = reference.solve(chain, target, tolerance=TOLERANCE, max_iterations=32)
        if taken < 32:
            np.testing.assert_allclose(got, wanted, atol=2e-4)
            compared += 1
    assert compared > 50


@pytest.mark.parametrize("share", [(0.0, 1.0), (0.94, 0.99), (0.99, 1.0), (0.0, 0.02)])
def test_reachable_targets_are_reached(share) -> None:
    points, _, rng = chains(512)
    targets = targets_at(points, rng, *share)
    assert_solved(points, targets, *solve(points, targets))


@pytest.mark.parametrize("side", [1, -1])
def test_straight_chains_with_the_target_on_their_line(side) -> None:
    points, lengths, rng = chains(512, straight=True)
    low = np.maximum(2 * lengths.max(axis=1) - lengths.sum(axis=1), 0)
    distance = low + rng.uniform(size=512) * (lengths.sum(axis=1) - low)
    ahead = unit(points[:, -1])
    targets = (side * ahead * distance[:, None]).astype(np.float32)
    assert_solved(points, targets, *solve(points, targets))


def test_out_of_reach() -> None:
    points = np.array([[1, 0, 0], [1, 3, 0], [1, 3, 1]], np.float32)
    found, status = solve(points, np.array([7, 0, 0], np.float32))
    assert int(status) == UNREACHABLE_FAR
    np.testing.assert_allclose(found, [[1, 0, 0], [4, 0, 0], [5, 0, 0]], atol=1e-6)
    # Nearer than 3 − 1 from the root the end cannot be: the short bone lies folded back.
    found, status = solve(points, np.array([1, -1, 0], np.float32))
    assert int(status) == UNREACHABLE_NEAR
    np.testing.assert_allclose(found, [[1, 0, 0], [1, -3, 0], [1, -2, 0]], atol=1e-6)


def test_one_bone_and_no_bones() -> None:
    points = np.array([[0, 0, 0], [2, 0, 0]], np.float32)
    found, status = solve(points, np.array([0, 0, 2], np.float32))
    assert int(status) == REACHED
    np.testing.assert_allclose(found[1], [0, 0, 2], atol=1e-6)
    assert int(solve(points, np.array([0, 0, 1], np.float32))[1]) == UNREACHABLE_NEAR
    nothing = np.ones((4, 3), np.float32)
    found, status = solve(nothing, np.array([5, 0, 0], np.float32))
    assert int(status) == UNREACHABLE_FAR
    np.testing.assert_array_equal(found, nothing)


def test_input_that_is_not_finite_has_a_status() -> None:
    points, _, _ = chains(1)
    assert int(solve(points[0], np.full(3, np.nan, np.float32))[1]) == NOT_CONVERGED


@given(st.integers(2, 12), st.integers(0, 10**6), st.floats(0, 1.3))
def test_random_chains(joints, seed, share) -> None:
    rng = np.random.default_rng(seed)
    bones = rng.normal(size=(joints - 1, 3)) * rng.choice([0.01, 0.3, 1.0], (joints - 1, 1))
    points = np.cumsum(np.concatenate([rng.normal(size=(1, 3)), bones]), axis=0)
    low, high = reference.reach(points)
    points = points.astype(np.float32)
    distance = share * high
    target = (points[0] + unit(rng.normal(size=3)) * distance).astype(np.float32)
    # All lengths in one compiled program: bones of no length at the end change nothing.
    padded = np.concatenate([points, np.repeat(points[-1:], 12 - joints, axis=0)])
    found, status = solve(padded, target)
    assert_rigid(padded, np.asarray(found))
    miss = float(np.linalg.norm(np.asarray(found)[-1] - target))
    out = max(distance - high, low - distance)
    assert miss <= max(out, TOLERANCE) + 1e-5 * high + 2e-6
    if out > 2 * TOLERANCE:
        assert int(status) == (UNREACHABLE_FAR if distance > high else UNREACHABLE_NEAR)
    if out < 0:
        assert int(status) == REACHED


def test_batch_is_the_loop_and_jit_is_eager() -> None:
    points, _, rng = chains(6)
    targets = targets_at(points, rng, 0, 1)
    shaped = solve(points.reshape(3, 1, 2, 9, 3), targets.reshape(3, 1, 2, 3))
    assert shaped[1].shape == (3, 1, 2)
    one_by_one = [solve(p, t) for p, t in zip(points, targets, strict=True)]
    mapped = jax.vmap(lambda p, t: solve(p, t))(points, targets)
    for k, (joints, status) in enumerate(one_by_one):
        for other in (shaped[0].reshape(6, 9, 3)[k], mapped[0][k]):
            np.testing.assert_allclose(other, joints, atol=2e-5)
        assert int(shaped[1].reshape(6)[k]) == int(mapped[1][k]) == int(status)
    with jax.disable_jit():
        eager = mgjax.hybrid.fabrik(points[:1, :3], targets[:1], max_iterations=1)
    jitted = solve(points[:1, :3], targets[:1], max_iterations=1)
    np.testing.assert_allclose(eager[0], jitted[0], atol=2e-5)


def test_batches_that_do_not_fill_their_tiles() -> None:
    points, _, rng = chains(300)
    targets = targets_at(points, rng, 0, 1)
    found, _ = solve(points, targets)
    again, _ = solve(points[44:], targets[44:])
    np.testing.assert_allclose(found[44:], again, atol=2e-5)
    assert solve(points[:0], targets[:0])[0].shape == (0, 9, 3)


def test_long_chains() -> None:
    points, _, rng = chains(4, joints=65)
    targets = targets_at(points, rng, 0, 1)
    assert_solved(points, targets, *solve(points, targets))


def degenerate() -> tuple[np.ndarray, np.ndarray]:
    """256 cases: bent chains, straight ones with targets on their line, both limits of reach."""
    points, _, rng = chains(256)
    targets = targets_at(points, rng, -0.1, 1.1)
    line, lengths, rng = chains(256, straight=True)
    ahead = unit(line[:, -1])
    on_line = ahead * (rng.uniform(-1, 1, 256) * lengths.sum(axis=1))[:, None]
    points[:128], targets[:128] = line[:128], on_line[:128]
    points[200:210, 4:] = points[200:210, 3:4]
    points[210:215] = points[210:215, :1]
    targets[215:220] = points[215:220, 0]
    targets[220:225] = points[220:225, -1]
    even = np.linspace(0, 1, 9, dtype=np.float32)[:, None] * np.eye(3, dtype=np.float32)[1]
    points[128:160] = even
    targets[128:160] = np.linspace(-1, 1, 32)[:, None] * np.eye(3)[1]
    return points, targets.astype(np.float32)


@jax.jit
def gradients(points, targets, weights):
    return jax.value_and_grad(lambda p, t: jnp.sum(weights * solve(p, t)[0]), argnums=(0, 1))(
        points, targets
    )


def test_gradients_are_finite_and_values_agree() -> None:
    points, targets = degenerate()
    weights = np.random.default_rng(0).normal(size=points.shape).astype(np.float32)
    value, found = gradients(points, targets, weights)
    for gradient in found:
        assert np.isfinite(gradient).all()
    joints, _ = solve(points, targets)
    np.testing.assert_allclose(value, np.sum(weights * np.asarray(joints)), rtol=1e-4, atol=1e-2)


def test_gradients_are_those_of_small_changes() -> None:
    points, _, rng = chains(256, seed=3)
    targets = targets_at(points, rng, 0.4, 0.7)
    weights = rng.normal(size=points.shape).astype(np.float32)
    _, (_, by_target) = gradients(points, targets, weights)
    step = 2e-4 * unit(rng.normal(size=targets.shape)).astype(np.float32)

    def values(at: np.ndarray) -> np.ndarray:
        return np.sum(weights * np.asarray(solve(points, at)[0]), axis=(1, 2))

    slope = (values(targets + step) - values(targets - step)) / 2
    wanted = np.sum(np.asarray(by_target) * step, axis=-1)
    # A chain that takes one more iteration after the change has no slope to compare.
    close = np.abs(slope - wanted) < 0.05 * np.abs(slope) + 2e-5
    assert close.mean() > 0.8
