"""Flight under gravity and linear drag, a = g − c · v, in closed form.

After t seconds a ball launched with v₀ has moved by v₀ P + g Q and has the velocity v₀ e + g P,
with e = e^(−ct), P = (1 − e)/c and Q = (t − P)/c; without drag they are 1, t and t²/2. Where c · t
is small the fractions lose their digits and a series takes over.

Deviation: there are two evaluations of the same integrals. What is flown in float32 on the device
wants one division for all times and derivatives that are finite at c = 0 (:func:`drag_integrals`);
what is aimed on the host in float64 wants the last digit, and so ``expm1`` and a narrow series
(:func:`drag_factors`). They agree to the rounding of the coarser one.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.core.arrays import Array

_SERIES_BELOW = 0.5
"""drag · t below which :func:`drag_integrals` takes its series."""

_FACTOR_SERIES_BELOW = 0.02
"""drag · t up to which :func:`drag_factors` takes its series: there seven terms are exact."""


def drag_integrals(t: Float[Array, "*n"], drag: Float[Array, "*m"]) -> tuple[Array, Array, Array]:
    """e^(−drag t) and its first and second integral from 0 to t, also for drag = 0; traced.

    With linear drag v(t) = v₀ e₀ − g e₁ and x(t) = x₀ + v₀ e₁ − g e₂, where g points down.

    Args:
        t: s.
        drag: 1/s, ≥ 0.
    """
    x = drag * t
    small = jnp.abs(x) < _SERIES_BELOW
    near = jnp.where(small, x, 0.0)
    series = jnp.full_like(near, 1 / 362880)  # Σ (−x)^k / (k+2)!, from the smallest term on
    for factor in (40320, 5040, 720, 120, 24, 6, 2):
        series = 1 / factor - near * series
    e2 = t * t * series
    e1 = t - drag * e2
    e0 = 1 - drag * e1
    per_drag = 1 / jnp.where(drag > 1e-6, drag, 1.0)  # one division, whatever the number of times
    f0 = jnp.exp(-jnp.where(small, 0.0, x))
    f1 = (1 - f0) * per_drag
    f2 = (t - f1) * per_drag
    return jnp.where(small, e0, f0), jnp.where(small, e1, f1), jnp.where(small, e2, f2)


def drag_factors(
    t: Float[np.ndarray, " T"], drag: float
) -> tuple[Float[np.ndarray, " T"], Float[np.ndarray, " T"]]:
    """Factors of launch velocity and of gravity in the way covered in t seconds; float64, host.

    They are P = (1 − e^−ct)/c and Q = (ct − 1 + e^−ct)/c².

    Args:
        t: s, ≥ 0.
        drag: 1/s, ≥ 0.
    """
    u = drag * t
    safe = np.where(u > 0, u, 1.0)
    coast = np.where(u > 0, -np.expm1(-u) / safe, 1.0)
    series = np.polyval([1 / 40320, -1 / 5040, 1 / 720, -1 / 120, 1 / 24, -1 / 6, 1 / 2], u)
    fall = np.where(u > _FACTOR_SERIES_BELOW, (u + np.expm1(-u)) / safe**2, series)
    return t * coast, t * t * fall
