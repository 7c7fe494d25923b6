from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core.timing.easing import plateau, smoothstep


def test_smoothstep_by_hand() -> None:
    share = np.array([-1.0, 0.0, 0.25, 0.5, 1.0, 2.0])
    assert np.asarray(smoothstep(share)).tolist() == [0, 0, 0.15625, 0.5, 1, 1]
    traced = jax.jit(smoothstep)(jnp.asarray(share, jnp.float32))
    assert np.asarray(traced).tolist() == [0, 0, 0.15625, 0.5, 1, 1]
    slope = jax.vmap(jax.grad(smoothstep))(jnp.array([-0.5, 0.0, 0.5, 1.0, 1.5]))
    assert np.asarray(slope) == pytest.approx([0, 0, 1.5, 0, 0])


def test_plateau_by_hand() -> None:
    weight = plateau(np.arange(10), 4, 5, 4, 2)
    assert weight.tolist() == [0, 0.15625, 0.5, 0.84375, 1, 1, 0.5, 0, 0, 0]


def test_at_once() -> None:
    assert plateau(np.arange(6), 2, 3, 0, 0).tolist() == [0, 0, 1, 1, 0, 0]
    assert plateau(np.arange(4), -2, 9, 0, 0).tolist() == [1, 1, 1, 1]
