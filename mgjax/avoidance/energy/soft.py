"""The energies without their corners: blurred by a temperature, in the limit those of the paper.

The energies of eqs 4–10 have flat parts, corners and one jump, where slopes are 0, one-sided or
missing. Their soft forms have slopes everywhere, by which settings and motions can be fitted.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.clearance import clearance
from mgjax.avoidance.energy.energies import Energies
from mgjax.core.arrays import Array
from mgjax.core.traced import Number

_TINY = 1e-20
"""Squared length under which two points coincide, m²."""


@jax.jit
def soft_energies(
    attack_centres: Float[Array, "T I 3"],
    attack_radii: Float[Array, " I"],
    body_centres: Float[Array, "T S 3"],
    body_radii: Float[Array, " S"],
    start_centres: Float[Array, "S 3"],
    avoidance_mask: Bool[Array, " T"],
    active_mask: Bool[Array, " T"],
    *,
    dt: Float[Array, ""] | float,
    config: EnergyConfig,
    temperature: Number,
) -> Energies:
    """The energies of one path (eqs 4–8 of Oshita & Masaoka 2011), blurred by a temperature.

    max(0, x) becomes x σ(x/τ) with the logistic function σ, the least distance that of
    :func:`mgjax.avoidance.clearance`, and the two ends of eq. 8, between which e_body is not 1,
    become two logistic steps. As τ goes to 0 all of them go to
    :func:`mgjax.avoidance.energies`.

    Args:
        attack_centres, attack_radii, body_centres, body_radii, start_centres, avoidance_mask: see
            :func:`mgjax.avoidance.energies`.
        active_mask, dt, config: see there.
        temperature: τ, m, > 0; of energies, which have no unit, τ/``D_body``.
    """
    tau, width = _float32(temperature), _float32(config.D_body)
    attack, body, start = (_float32(x) for x in (attack_centres, body_centres, start_centres))
    radii = _float32(attack_radii), _float32(body_radii)
    avoidance, active = jnp.asarray(avoidance_mask), jnp.asarray(active_mask)
    frozen = (jnp.cumsum(avoidance) > 0)[:, None, None]
    held = jnp.where(frozen, start[None], body)
    reach = (radii[0][:, None] + radii[1][None])[None]
    far, far0 = (_distances(attack, spheres) for spheres in (body, held))
    if config.form == "overlap":
        excess = soft_positive(reach - far0, tau) - soft_positive(reach - far, tau)
    else:
        excess = far - far0
    counted = (avoidance & active)[:, None, None]
    moved = jnp.sum(jnp.where(counted, soft_positive(excess, tau), 0.0))
    penetration = moved * _float32(dt)
    d, d0 = (
        clearance(attack, radii[0], spheres, radii[1], active, temperature=tau).distance
        for spheres in (body, held)
    )
    avoided = soft_positive(1 - penetration / _float32(config.E_avoidance), tau / width)
    floor = soft_positive(d0, tau) if config.d0 == "clamped" else d0
    return Energies(
        avoidance=avoided,
        body=soft_body_energy(d - floor, width, tau),
        penetration=penetration,
        d=d,
        d0=d0,
    )


def soft_body_energy(
    excess: Float[Array, "*c"], D_body: Number, temperature: Number
) -> Float[Array, "*c"]:
    """e_body (eq. 8) of d − d0, m, with its two ends blurred by a temperature τ, m.

    The lower end, where e_body jumps, is at τ log(1 + D_body/τ) instead of 0, so that the limit on
    the jump is 1 as in the paper.
    """
    width, tau = _float32(D_body), _float32(temperature)
    low = tau * jnp.log1p(width / tau)
    inside = jax.nn.sigmoid((excess - low) / tau) * jax.nn.sigmoid((width - excess) / tau)
    return 1 - inside * (1 - excess / width)


def soft_time_scale_energy(
    s: Float[Array, "*c"] | float, E_time: Number, w_speed_up: Number, temperature: Number
) -> Float[Array, "*c"]:
    """e_timescale (eq. 9) with its corner at s = 1 blurred; the temperature has no unit."""
    scale = jnp.maximum(jnp.abs(_float32(s)), 1e-6)
    slower, faster = (soft_positive(x - 1, temperature) for x in (scale, 1 / scale))
    return (1 + slower + _float32(w_speed_up) * faster) / _float32(E_time)


def soft_positive(x: Float[Array, "*c"], temperature: Number) -> Float[Array, "*c"]:
    """x σ(x/τ): max(0, x) as τ goes to 0, and 0 at 0 and far below whatever τ is."""
    return x * jax.nn.sigmoid(x / temperature)


def _distances(attack: Array, body: Array) -> Float[Array, "T I S"]:
    apart = attack[:, :, None] - body[:, None]
    return jnp.sqrt(jnp.maximum(jnp.sum(apart * apart, axis=-1), _TINY))


def _float32(value: Number) -> jax.Array:
    return jnp.asarray(value, jnp.float32)
