from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core.arrays import Array
from mgjax.core.timing.time_warp import TimeWarp, even_warp, scaled_warp


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


DURATIONS, SCALES = np.array([0.4, 0.7, 0.5]), np.array([1.0, 0.8, 1.5])
ASKED = np.array([-0.2, 0.3, 0.4, 0.7, 1.0, 1.5, 2.5])
"""Before, inside, at a knot, after."""


def test_scaled_pieces_are_played_at_one_speed_each() -> None:
    warp = scaled_warp(DURATIONS, SCALES)
    ends = np.cumsum(DURATIONS * SCALES)  # 0.4, 0.96, 1.71
    np.testing.assert_allclose(warp.at(ends), np.cumsum(DURATIONS), atol=1e-12)
    shown = warp.at(np.array([0.2, 0.68, 1.335, 2.71]))
    np.testing.assert_allclose(shown, [0.2, 0.75, 1.35, 2.6], atol=1e-12)


def test_in_jax_as_in_numpy() -> None:
    for warp in (
        scaled_warp(DURATIONS, SCALES),
        even_warp(np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 0.5, 0.5, 2.0])),
    ):
        there = jax.tree.map(jnp.asarray, warp)
        for name in ("at", "speed", "when"):
            wanted = getattr(warp, name)(ASKED)
            assert isinstance(wanted, np.ndarray)
            assert wanted.dtype == np.float64
            found = jax.jit(lambda w, x, name=name: getattr(w, name)(x))(there, jnp.asarray(ASKED))
            np.testing.assert_allclose(found, wanted, atol=1e-6)
            each = jax.vmap(lambda x, w=there, name=name: getattr(w, name)(x[None])[0])
            np.testing.assert_allclose(each(jnp.asarray(ASKED)), wanted, atol=1e-6)


@pytest.mark.parametrize("name", ["at", "when"])
def test_slopes_are_finite_differences(name: str) -> None:
    """With respect to what is asked, durations and scales; at a knot they are finite."""

    def shown(asked: Array, durations: Array, scales: Array) -> Array:
        return getattr(scaled_warp(durations, scales), name)(asked)

    with jax.enable_x64(True):
        arguments = tuple(map(jnp.asarray, (ASKED, DURATIONS, SCALES)))
        forward = jax.jacfwd(shown, argnums=(0, 1, 2))(*arguments)
        reverse = jax.jacrev(shown, argnums=(0, 1, 2))(*arguments)
        inside = ASKED != 0.4
        for number, (one, other) in enumerate(zip(forward, reverse, strict=True)):
            np.testing.assert_allclose(one, other, atol=1e-12)
            assert np.isfinite(one).all()
            for k in range(len(arguments[number])):
                values = []
                for step in (1e-6, -1e-6):
                    changed = list(arguments)
                    changed[number] = changed[number].at[k].add(step)
                    values.append(shown(*changed))
                measured = np.asarray(values[0] - values[1]) / 2e-6
                np.testing.assert_allclose(one[inside, k], measured[inside], atol=1e-6)
