"""The energies of candidate paths: how well each one avoids an attack, and how modestly.

One kernel (:mod:`mgjax.avoidance.energy.kernel`) judges many candidates; :func:`energies` is the
same kernel with one candidate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float

from mgjax.avoidance.config import EnergyConfig, Number
from mgjax.avoidance.energy.kernel import Paths, over_attack
from mgjax.avoidance.energy.score import avoidance_energy, body_energy
from mgjax.core.arrays import Array
from mgjax.core.errors import ConfigError
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True)
class Energies:
    """What one path, or each of many, is worth. Smaller energies are better.

    Attributes:
        avoidance: e_avoidance (eq. 6), 0 … 1.
        body: e_body (eq. 8), 0 … 1.
        penetration: e' (eq. 4), m·s: what the avoidance moved out of the attack's way.
        d: least clearance of attack and body (eq. 7), m; negative where the body is hit. ``FAR``
            where no time is active.
        d0: the same had the body frozen when the avoidance began, m; never clamped here.
    """

    avoidance: Float[Array, "*c"]
    body: Float[Array, "*c"]
    penetration: Float[Array, "*c"]
    d: Float[Array, "*c"]
    d0: Float[Array, "*c"]


@jax.jit
def energies(
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
    attack_present: Bool[Array, "T I"] | None = None,
) -> Energies:
    """Energies of one path against one attack (eqs 4–8); see :func:`energies_batch`.

    Args:
        attack_centres: centres of the attack's spheres at the evaluated times, world, m.
        attack_radii: their radii, m.
        body_centres: centres of the body's spheres at the same times, world, m.
        body_radii: their radii, m.
        start_centres: centres of the body's spheres at t0, the start of the avoidance part, m.
        avoidance_mask: times inside the avoidance part.
        active_mask: times at which the attack is there.
        dt: interval of the evaluated times, s.
        config: forms, scales and weights.
        attack_present: times at which each of the attack's spheres is there; default: always.

    Returns:
        Energies with scalar fields.
    """
    batch = energies_batch(
        jnp.moveaxis(jnp.asarray(attack_centres), -1, 0),
        attack_radii,
        jnp.moveaxis(jnp.asarray(body_centres), -1, 0)[:, :, None],
        body_radii,
        jnp.moveaxis(jnp.asarray(start_centres), -1, 0)[:, None],
        jnp.asarray(avoidance_mask)[:, None],
        jnp.asarray(active_mask)[:, None],
        dt=dt,
        config=config,
        attack_present=attack_present,
    )
    return jax.tree.map(lambda field: field[0], batch)


@partial(jax.jit, static_argnames="swept")
def energies_batch(
    attack_centres: Float[Array, "3 T I"],
    attack_radii: Float[Array, " I"],
    body_centres: Float[Array, "3 T C S"],
    body_radii: Float[Array, " S"],
    start_centres: Float[Array, "3 C S"],
    avoidance_mask: Bool[Array, "T C"],
    active_mask: Bool[Array, "T C"],
    *,
    dt: Float[Array, ""] | float,
    config: EnergyConfig,
    attack_present: Bool[Array, "T I"] | None = None,
    swept: bool = True,
) -> Energies:
    """Energies of many candidates against one attack (Oshita & Masaoka 2011, eqs 4–8).

    With D(S1, S2) = distance of the centres − both radii:

    - e' (eqs 4–5) sums max(0, −x) Δt over the times that are active *and* in the avoidance mask and
      over all pairs of spheres, where x compares the body at t0 with the body at t
      (``config.form``); e_avoidance = max(0, 1 − e'/E_avoidance) (eq. 6).
    - d (eq. 7) is the smallest D over the active times. Between two consecutive active times both
      centres move linearly and the smallest distance is exact.
    - d0 is the same for the body that is frozen at ``start_centres`` from the first true entry of
      the avoidance mask on; it moves linearly into that pose during the interval before. Without
      such an entry d0 = d.
    - e_body (eq. 8) is (d − d0)/D_body between d0 and d0 + D_body, and 1 outside.

    Everything is computed in float32. Entries at masked times must be finite and change nothing.
    First derivatives are exact and finite, also for coincident centres and spheres at rest; second
    derivatives treat the time of closest approach as fixed. A NaN at an active time makes d NaN.

    Deviation:
        Eq. 6 is garbled in print and read as above. Eq. 5 as printed also counts a body that moves
        away from an attack that is metres off; the default ``form="overlap"`` counts penetration
        only. Eq. 7 takes the minimum over sampled times; here it is swept, since a ball at 10 m/s
        moves 0.5 m in 1/20 s. Eq. 8 uses max(d0, 0) by default. A d less than 10 µm above
        d0 counts as d ≤ d0, so that rounding cannot make a body that never moved look modest.

    Args:
        attack_centres: centres of the attack's spheres, world, m.
        attack_radii: their radii, m.
        body_centres: centres of each candidate's body spheres, world, m.
        body_radii: their radii, the same for all candidates, m; far below 0 for padding.
        start_centres: the body's spheres at t0, the start of each avoidance part, m.
        avoidance_mask: times inside each candidate's avoidance part.
        active_mask: times at which the attack is there.
        dt: interval of the evaluated times, s.
        config: forms, scales and weights.
        attack_present: times at which each of the attack's spheres is there; default: always.
        swept: without it d and d0 look at the sampled times only. They are then upper bounds, by at
            most half the largest relative displacement of one interval: a negative one is a hit.
            The sweep does not even double the time, so sorting out the candidates that need it does
            not pay.

    Returns:
        Energies with fields ``[C]``.

    Raises:
        ConfigError: an unknown ``form`` or ``d0``.
    """
    if config.form not in ("paper", "overlap") or config.d0 not in ("clamped", "paper"):
        raise ConfigError(f"unknown energy form {config.form!r} or d0 {config.d0!r}")
    avoidance, active = jnp.asarray(avoidance_mask), jnp.asarray(active_mask)
    times = jnp.arange(active.shape[0])[:, None]
    first = jnp.min(jnp.where(avoidance, times, active.shape[0]), axis=0, keepdims=True)
    paths = Paths(
        centres=_float32(body_centres),
        start=_float32(start_centres),
        radii=_float32(body_radii),
        frozen=times >= first,
        active=active,
        scored=avoidance & active,
    )
    centres, radii = _float32(attack_centres), _float32(attack_radii)
    present = jnp.ones(centres.shape[1:], bool) if attack_present is None else attack_present
    totals = over_attack(config.form, swept, paths, centres, radii, jnp.asarray(present))
    met = jnp.any(active & jnp.any(present, axis=1)[:, None], axis=0)
    penetration, d, d0 = totals.measured(met, _float32(dt))
    return Energies(
        avoidance=avoidance_energy(penetration, config.E_avoidance),
        body=body_energy(d, d0, config),
        penetration=penetration,
        d=d,
        d0=d0,
    )


def _float32(value: Number) -> jax.Array:
    return jnp.asarray(value, jnp.float32)
