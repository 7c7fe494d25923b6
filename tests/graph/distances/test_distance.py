from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from mgjax.core import planar
from mgjax.core.errors import ConfigError
from mgjax.graph.distances import distance
from mgjax.graph.distances.distance import distance_matrix
from tests.graph.made import march, places
from tests.reference import graph as reference

WINDOWS = (1, 2, 5, 10, 13)


def moved(positions: np.ndarray, transform) -> np.ndarray:
    """In float64, rounded once."""
    p = positions.astype(np.float64)
    return planar.apply(np.asarray(transform, np.float64), p).astype(np.float32)


def noise(frames: int, joints: int = 7, *, seed: int = 0) -> np.ndarray:
    """Points that are somewhere else in every frame."""
    size = (frames, joints, 3)
    return np.random.default_rng(seed).normal(scale=0.7, size=size).astype(np.float32)


def assert_close(got: np.ndarray, squared: np.ndarray) -> None:
    """Within 2e-4 m where D ≥ 0.02 m, below |ΔD²| ≤ 2e-6 m²."""
    assert got.shape == squared.shape
    want = np.sqrt(np.maximum(squared, 0))
    far = want >= 0.02
    assert np.abs(got - want)[far].max(initial=0.0) <= 2e-4
    assert np.abs(got**2 - squared)[~far].max(initial=0.0) <= 2e-6


def check(a: np.ndarray, b: np.ndarray, window: int, weights=None) -> np.ndarray:
    got = distance_matrix(a, b, window=window, weights=weights)
    assert_close(got, reference.distance_matrix(a, b, window, weights))
    return got


def test_worked_by_hand():
    # One joint, windows of two frames. A goes 2 m along z at height 1, B goes 1 m along x at
    # height 1.3. Centred: A at z = ∓1, B at x = ∓½; after the turn they are ½ m apart at both
    # ends, and 0.3 m in height: D² = 0.25 + 0.09.
    a = np.array([[[5, 1, 0]], [[5, 1, 2]]], np.float32)
    b = np.array([[[0, 1.3, 7]], [[1, 1.3, 7]]], np.float32)
    got = distance_matrix(a, b, window=2)
    assert got.shape == (1, 1)
    np.testing.assert_allclose(got, np.sqrt(0.34), atol=1e-6)
    # One frame each: the floor does not matter, only 0.3 m in height.
    np.testing.assert_allclose(distance_matrix(a, b, window=1), np.full((2, 2), 0.3), atol=1e-6)


def test_weights_worked_by_hand():
    # Two joints 1 m and 2 m from each other, the second raised by 0.4 m in B with weight ¼.
    # Weighted centres: ¼ m and ½ m from the first joint; with the best turn, D² = Σ w (r − r')²
    # = ¾·(¼ − ½)² + ¼·(¾ − 3/2)², and ¼·0.4² of height.
    a = np.array([[[0, 1, 0], [1, 1, 0]]], np.float32)
    b = np.array([[[0, 1, 0], [0, 1.4, 2]]], np.float32)
    want = 0.75 * 0.25**2 + 0.25 * 0.75**2 + 0.25 * 0.4**2
    got = distance_matrix(a, b, window=1, weights=np.array([3, 1], np.float32))
    np.testing.assert_allclose(got, [[np.sqrt(want)]], atol=1e-6)


@pytest.mark.parametrize("window", WINDOWS)
def test_smooth_motion(window):
    a = places(march(33, seed=1))
    b = places(march(27, seed=2, swing=0.5, speed=0.8, heading=1.0))
    check(a, b, window)


@pytest.mark.parametrize("window", WINDOWS)
def test_data_that_are_not_smooth(window):
    check(noise(24), noise(19, seed=1), window)


@pytest.mark.parametrize("window", WINDOWS)
def test_a_clip_with_itself(window):
    a = places(march(40, seed=3, noise=0.02))
    got = check(a, a, window)
    assert got.diagonal().max() <= np.sqrt(2e-6)


def test_clips_50_m_from_the_origin():
    a, b = places(march(30, seed=1)), places(march(30, seed=2))
    far = places(march(30, seed=2, place=(50.0, -50.0)))
    both = places(march(30, seed=1, place=(-50.0, 50.0)))
    want = check(a, b, 10)
    for x, y in ((a, far), (both, b), (both, far), (far, far)):
        check(x, y, 10)
    # Rounding of the positions themselves is 4e-6 m at 50 m.
    np.testing.assert_allclose(distance_matrix(both, far, window=10), want, atol=5e-5)


def test_clips_that_walk_10_m():
    a = places(march(61, seed=1, speed=5.0, swing=0.8))
    b = places(march(61, seed=2, speed=5.0, heading=0.7, place=(20.0, 0.0)))
    check(a[::2], b[::2], 10)
    check(a, b[20:40], 13)


def test_a_zigzag_that_keeps_all_components_of_the_path():
    # The centre of the body jumps 10 cm to and fro in every frame: no few slow components hold it.
    a, b = (places(march(30, seed=s)) for s in (1, 2))
    shift = np.zeros((30, 1, 3), np.float32)
    shift[::2, 0, 0] = 0.1
    check(a + shift, b + shift, 13)
    check(a + shift, b + shift[::-1], 10)


@pytest.mark.parametrize("weights", [[1, 0, 0, 2, 0, 0, 1], [0, 0, 0, 0, 0, 5, 0], [1e-3] * 7])
def test_weights_with_zeros(weights):
    w = np.array(weights, np.float32)
    check(noise(16), noise(15, seed=1), 5, w)
    changed = noise(16)
    changed[:, w == 0] += 3.0
    np.testing.assert_allclose(
        distance_matrix(changed, noise(15, seed=1), window=5, weights=w),
        distance_matrix(noise(16), noise(15, seed=1), window=5, weights=w),
        atol=2e-6,
    )


@pytest.mark.parametrize("rows", [1, 127, 128, 129, 256])
def test_ends_of_the_padding(rows):
    window = 5
    a, b = noise(rows + window - 1, 3), noise(8, 3, seed=1)
    got = distance_matrix(a, b, window=window)
    turned = distance_matrix(b, a, window=window)
    assert got.shape == (rows, 4)
    np.testing.assert_allclose(got, turned.T, atol=1e-5)
    for r in {0, rows // 2, max(rows - 2, 0), rows - 1}:
        part = a[r : r + window]
        assert_close(got[r : r + 1], reference.distance_matrix(part, b, window))


@given(st.integers(0, 10**6), st.sampled_from(WINDOWS))
def test_symmetric(seed, window):
    a, b = noise(20, seed=seed), noise(16, seed=seed + 1)
    one, other = distance_matrix(a, b, window=window), distance_matrix(b, a, window=window)
    np.testing.assert_allclose(one, other.T, atol=2e-5)


@given(
    st.integers(0, 10**6),
    st.tuples(st.floats(-4, 4), st.floats(-10, 10), st.floats(-10, 10)),
)
def test_a_planar_transform_of_one_clip_changes_nothing(seed, transform):
    a, b = places(march(20, seed=seed % 50)), noise(16, 15, seed=seed)
    want = distance_matrix(a, b, window=5)
    np.testing.assert_allclose(distance_matrix(a, moved(b, transform), window=5), want, atol=1e-4)
    itself = distance_matrix(a, moved(a, transform), window=5)
    assert itself.diagonal().max() <= np.sqrt(2e-6)


def test_a_higher_or_tilted_clip_is_another():
    a = places(march(20, seed=1))
    raised = distance_matrix(a, a + np.array([0, 0.25, 0], np.float32), window=5)
    np.testing.assert_allclose(raised.diagonal(), 0.25, atol=1e-5)


@pytest.mark.parametrize("seed", range(4))
def test_reference_against_a_search_for_the_best_transform(seed):
    """The closed form of the reference is the smallest value over (θ, x, z)."""
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(12, 3)), rng.normal(size=(12, 3)) + rng.normal(scale=5, size=3)
    w = rng.uniform(size=12) * (rng.uniform(size=12) > 0.2)
    w /= w.sum()
    best = min(
        minimize(reference.misfit, [theta, 0, 0], args=(a, b, w), method="BFGS").fun
        for theta in (0.0, 2.0, 4.0)
    )
    want = reference.squared_distance(a, b, w)
    assert best == pytest.approx(want, abs=1e-7)
    assert reference.misfit(reference.align(a, b, w), a, b, w) == pytest.approx(want, abs=1e-9)


def test_no_distance_is_not_a_number():
    still = np.zeros((30, 4, 3), np.float32)  # all joints in one point: no turn is the best
    got = distance_matrix(still, still + np.float32(2), window=10)
    np.testing.assert_allclose(got, 2.0, atol=1e-6)
    assert np.isfinite(distance_matrix(still, noise(30, 4), window=10)).all()


def test_diagonal_sum():
    products = noise(17, 1)[:, 0, :1] @ noise(13, 1, seed=1)[:, 0, :1].T
    for window in (1, 2, 3, 7, 8, 13):
        got = np.asarray(distance.diagonal_sum(products, window))
        want = [
            [sum(products[r + i, c + i] for i in range(window)) for c in range(13 - window + 1)]
            for r in range(17 - window + 1)
        ]
        np.testing.assert_allclose(got, want, atol=1e-5)


@pytest.mark.parametrize("window", [0, -3, 9, 100])
def test_windows_that_do_not_fit(window):
    with pytest.raises(ConfigError, match=rf"window of {window} frames, expected 1 … 8"):
        distance_matrix(noise(12), noise(8), window=window)


@pytest.mark.parametrize(
    "weights", [[1, 1], [1] * 8, [-1, 1, 1, 1, 1, 1, 1], [0] * 7, [np.nan] + [1] * 6]
)
def test_weights_that_cannot_be_used(weights):
    with pytest.raises((ConfigError, TypeError), match=r"expected 7 numbers|weights"):
        distance_matrix(noise(8), noise(8), window=2, weights=np.array(weights, np.float32))
