from __future__ import annotations

import numpy as np
import pytest

from mgjax.core.timing.time_warp import TimeWarp, even_warp


def test_by_hand() -> None:
    # From 1 s on twice as fast for 1 s, then slower and slower for 2 s until it is natural.
    warp = TimeWarp(
        times=np.array([1.0, 1.0, 2.0, 4.0]),
        positions=np.array([1.0, 1.0, 3.0, 6.0]),
        speeds=np.array([1.0, 2.0, 2.0, 1.0]),
    )
    times = np.array([0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0])
    shown = np.array([0.0, 1.0, 2.0, 3.0, 4.75, 6.0, 7.0])
    np.testing.assert_allclose(warp.at(times), shown, atol=1e-12)
    np.testing.assert_allclose(warp.speed(times), [1.0, 2.0, 2.0, 2.0, 1.5, 1.0, 1.0])
    np.testing.assert_allclose(warp.when(shown), times, atol=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_an_even_warp_is_what_interpolation_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.sort(rng.integers(0, 40, 6)).astype(np.float64)
    positions = np.cumsum(rng.integers(0, 9, 6)).astype(np.float64)
    positions = positions[np.searchsorted(times, times, side="right") - 1]  # equal at equal times
    warp = even_warp(times, positions)
    asked = rng.uniform(times[0], times[-1], 100)
    np.testing.assert_array_equal(warp.at(asked), np.interp(asked, times, positions))
    np.testing.assert_array_equal(warp.at(times), positions)
    for off in (0.25, 3.0):  # outside at natural speed
        outside = warp.at(np.array([times[0] - off, times[-1] + off]))
        np.testing.assert_allclose(outside, [positions[0] - off, positions[-1] + off])
    assert (warp.speeds >= 0).all()


def test_the_inverse_of_an_even_warp() -> None:
    times, positions = np.array([0.0, 2.0, 3.0, 9.0]), np.array([1.0, 2.0, 6.0, 7.5])
    asked = np.linspace(-2, 12, 57)
    warp, inverse = even_warp(times, positions), even_warp(positions, times)
    np.testing.assert_allclose(inverse.at(warp.at(asked)), asked, atol=1e-12)
    np.testing.assert_allclose(warp.when(warp.at(asked)), asked, atol=1e-12)
    still = even_warp(np.arange(4.0), np.array([0.0, 1.0, 1.0, 2.0]))
    np.testing.assert_array_equal(still.at(np.array([0.5, 1.5, 2.5, 4.0])), [0.5, 1.0, 1.5, 3.0])
