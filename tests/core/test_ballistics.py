from __future__ import annotations

from decimal import Decimal, getcontext

import jax
import jax.numpy as jnp
import numpy as np

from mgjax.core.ballistics import drag_factors, drag_integrals

DRAGS = (0.0, 1e-9, 1e-3, 0.2, 3.0)


def exact(t: float, drag: float) -> tuple[float, float]:
    """Both integrals of e^(−drag t) to fifty digits."""
    getcontext().prec = 50
    time, c = Decimal(t), Decimal(drag)
    if c == 0:
        return float(time), float(time * time / 2)
    first = (1 - (-c * time).exp()) / c
    return float(first), float((time - first) / c)


def test_integrals_are_smooth_across_the_series() -> None:
    for c in (0.0, 1e-7, 1e-3, 0.2, 3.0):
        t = np.linspace(0.0, 5.0, 400).astype(np.float32)
        got = drag_integrals(jnp.asarray(t), jnp.asarray(c, jnp.float32))
        x, wide = np.float64(np.float32(c)), t.astype(np.float64)
        if c < 1e-6:
            wanted = (np.ones_like(wide), wide, wide**2 / 2)
        else:
            gain = -np.expm1(-x * wide) / x
            wanted = (np.exp(-x * wide), gain, (wide - gain) / x)
        for a, b in zip(got, wanted, strict=True):
            np.testing.assert_allclose(a, b, rtol=3e-6, atol=1e-6)


def test_factors_are_exact() -> None:
    """On the host to the last digits, on either side of the series' end."""
    times = np.concatenate([np.linspace(0.0, 8.0, 81), [1e-7, 0.0199 / 0.2, 0.0201 / 0.2]])
    for drag in DRAGS:
        wanted = np.array([exact(float(t), drag) for t in times]).T
        coast, fall = drag_factors(times, drag)
        np.testing.assert_allclose(coast, wanted[0], rtol=1e-14)
        np.testing.assert_allclose(fall, wanted[1], rtol=3e-13)


def test_both_evaluations_agree() -> None:
    times = np.linspace(0.0, 8.0, 200).astype(np.float32)
    for drag in DRAGS:
        c = np.float32(drag)
        coarse = drag_integrals(jnp.asarray(times), jnp.asarray(c))
        fine = drag_factors(times.astype(np.float64), float(c))
        for a, b in zip(coarse[1:], fine, strict=True):
            np.testing.assert_allclose(a, b, rtol=3e-6, atol=1e-6)


def test_gradients_are_finite_without_drag() -> None:
    for number in range(3):
        slopes = jax.grad(lambda t, c, n=number: drag_integrals(t, c)[n], argnums=(0, 1))
        for t in (0.0, 1.0, 4.0):
            for c in (0.0, 1e-8, 0.2):
                assert np.isfinite(slopes(jnp.float32(t), jnp.float32(c))).all()
