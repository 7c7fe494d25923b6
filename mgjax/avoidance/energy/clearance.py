"""How near an attack comes to a body, which sphere it is nearest to, and when; differentiable."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.rates import FAR
from mgjax.core.arrays import Array
from mgjax.core.traced import Number
from mgjax.core.xla.pytree import register

_TINY = 1e-20
"""Squared length under which two points coincide or a sphere stands still, m²."""


@register()
@dataclass(frozen=True, kw_only=True)
class Clearance:
    """How near an attack comes, and where. Only ``distance`` has derivatives.

    Attributes:
        distance: least distance of the surfaces, m; negative where they overlap, ``FAR`` where no
            time is active. With a temperature: the soft least distance.
        body_sphere: the nearest sphere of the body.
        attack_sphere: that of the attack.
        moment: when, in intervals since the first time: 2.25 is a quarter of the way from the third
            time to the fourth.
    """

    distance: Float[Array, ""]
    body_sphere: Int[Array, ""]
    attack_sphere: Int[Array, ""]
    moment: Float[Array, ""]


@jax.jit
def clearance(
    attack_centres: Float[Array, "T I 3"],
    attack_radii: Float[Array, " I"],
    body_centres: Float[Array, "T S 3"],
    body_radii: Float[Array, " S"],
    active_mask: Bool[Array, " T"] | None = None,
    *,
    temperature: Number | None = None,
    attack_present: Bool[Array, "T I"] | None = None,
) -> Clearance:
    """d of eq. 7 (Oshita & Masaoka 2011), with the pair of spheres and the moment it belongs to.

    Centres move linearly between two active times, and the least distance within the interval is
    exact, as in :func:`mgjax.avoidance.energies`, whose ``d`` this is.

    The derivative is that of the nearest pair alone, and where another becomes nearest it jumps.
    With a ``temperature`` τ the least of all distances D is −τ log Σ exp(−D/τ) instead, over all
    pairs and intervals: below d by at most τ times the logarithm of their number, d in the limit,
    and with derivatives for all that is nearly as near. Forward and reverse mode, ``jit`` and
    ``vmap``; finite also for coincident centres and spheres at rest.

    Args:
        attack_centres: centres of the attack's spheres at the evaluated times, world, m.
        attack_radii: their radii, m.
        body_centres: centres of the body's spheres at the same times, world, m.
        body_radii: their radii, m.
        active_mask: times at which the attack is there; default: all.
        temperature: τ, m, > 0; default: the least distance itself.
        attack_present: times at which each of the attack's spheres is there; default: always.
    """
    attack, body = _float32(attack_centres), _float32(body_centres)
    times, spheres = attack.shape[:2]
    there = jnp.ones((times, spheres), bool) if attack_present is None else attack_present
    if active_mask is not None:
        there = jnp.asarray(there) & jnp.asarray(active_mask)[:, None]
    before = jnp.concatenate([jnp.zeros_like(there[:1]), there[:-1]])
    now = attack[:, :, None] - body[:, None]  # [T, I, S, 3]
    back = now - jnp.concatenate([now[:1], now[:-1]])
    length = jnp.maximum(jnp.sum(back * back, axis=-1), _TINY)
    share = jnp.clip(jnp.sum(now * back, axis=-1) / length, 0.0, 1.0)
    # At the closest point the derivative by its time is zero, or the time is at an end.
    share = jax.lax.stop_gradient(jnp.where((there & before)[..., None], share, 0.0))
    apart = now - share[..., None] * back
    square = jnp.sum(apart * apart, axis=-1)
    distance = jnp.sqrt(jnp.maximum(square, _TINY))
    distance = distance - _float32(attack_radii)[None, :, None] - _float32(body_radii)[None, None]
    distance = jnp.where(there[..., None], distance, FAR).reshape(-1)
    nearest = jnp.argmin(distance)
    at, sphere, part = jnp.unravel_index(nearest, share.shape)
    least = distance[nearest]
    if temperature is not None:
        tau = _float32(temperature)
        off = (distance - jax.lax.stop_gradient(least)) / tau
        soft = jax.lax.stop_gradient(least) - tau * jnp.log(jnp.sum(jnp.exp(-off)))
        least = jnp.where(jnp.any(there), soft, FAR)
    return Clearance(
        distance=least,
        body_sphere=part,
        attack_sphere=sphere,
        moment=at.astype(jnp.float32) - share.reshape(-1)[nearest],
    )


def _float32(value: Number) -> jax.Array:
    return jnp.asarray(value, jnp.float32)
