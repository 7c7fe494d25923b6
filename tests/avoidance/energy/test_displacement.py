"""How far bodies are from one that does not react."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from mgjax.avoidance.energy.displacement import mean_distance
from mgjax.avoidance.energy.score import movement_energy
from tests.reference import energy as reference

MOMENTS, WALKS, SPHERES = 3, 4, 5
PADDED = np.array([0.1, 0.2, 0.1, 0.3, 0.1, -1e3, -1e3], np.float32)


def bodies(seed: int, count: int) -> np.ndarray:
    """Spheres with two that pad them, of which nothing may be read. [3, T, count, 7]"""
    made = np.random.default_rng(seed).normal(size=(3, MOMENTS, count, len(PADDED)))
    made[..., SPHERES:] = 1e6
    return made.astype(np.float32)


@pytest.mark.parametrize("others", [1, WALKS])
def test_agrees_with_the_definition(others: int) -> None:
    moved, still = bodies(0, WALKS), bodies(1, others)
    got = mean_distance(moved, still, PADDED)
    jitted = jax.jit(mean_distance)(moved, still, PADDED)
    np.testing.assert_allclose(got, jitted, rtol=1e-6)
    for walk in range(WALKS):
        one, other = moved[:, :, walk, :SPHERES], still[:, :, walk % others, :SPHERES]
        wanted = reference.displacement(np.moveaxis(one, 0, -1), np.moveaxis(other, 0, -1))
        np.testing.assert_allclose(got[walk], wanted, rtol=1e-6)
        alone = mean_distance(moved[:, :, walk : walk + 1], other_of(still, walk, others), PADDED)
        np.testing.assert_allclose(got[walk], alone[0], rtol=1e-6)


def other_of(still: np.ndarray, walk: int, others: int) -> np.ndarray:
    return still[:, :, walk % others, None]


def test_by_hand() -> None:
    # Two spheres at two moments: one stays, the other is 5 m off, then 10 m: 15/4 m on average.
    still = np.zeros((3, 2, 1, 2), np.float32)
    moved = still.copy()
    moved[0, :, 0, 1], moved[2, :, 0, 1] = (3, 6), (4, 8)
    far = mean_distance(moved, still, np.ones(2, np.float32))
    np.testing.assert_allclose(far, [3.75])
    np.testing.assert_allclose(movement_energy(far, 0.3), [12.5], rtol=1e-6)


def test_gradients_are_finite_where_nothing_moves() -> None:
    still = bodies(2, 1)

    def total(moved: jax.Array) -> jax.Array:
        return mean_distance(moved, still, PADDED).sum()

    got = np.asarray(jax.grad(total)(jax.numpy.asarray(still)))
    np.testing.assert_array_equal(got, 0.0)
    moved = still + np.float32(0.1)
    got = np.asarray(jax.grad(total)(jax.numpy.asarray(moved)))
    # Each sphere is as far along each axis, so 1/√3 of the distance, a share of the mean.
    real = got[..., :SPHERES] * (MOMENTS * SPHERES)
    np.testing.assert_allclose(real, 1 / np.sqrt(3), rtol=1e-3)
    np.testing.assert_array_equal(got[..., SPHERES:], 0.0)
