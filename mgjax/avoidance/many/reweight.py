"""Judged candidates under other settings: what a sweep needs to compute only once.

The penetration e', the clearances d and d0 and the time scale of a candidate do not depend on
E_avoidance, D_body, E_time and the weights. A whole grid of those is therefore one compiled call
that ranks the same candidates again, exactly as a search with these settings would.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Float, Int

from mgjax.avoidance.choice.search import HOPELESS_M
from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.energies import (
    avoidance_energy,
    body_energy,
    time_scale_energy,
    total_energy,
)
from mgjax.avoidance.energy.score import Judged, ranking
from mgjax.avoidance.timing.time_scale import OK, OUT_OF_RANGE
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

CLEAR, TOUCHED, UNKNOWN = 0, 1, 2
"""What the exact check says of a candidate."""

NONE = -1
"""No candidate."""


@register()
@dataclass(frozen=True, kw_only=True)
class Picked:
    """The candidate that one setting picks, and how often its energies are saturated.

    Attributes:
        number: the first in the order that is not ``TOUCHED``; where all that are looked at are,
            the one with the largest clearance; ``NONE`` where none can be timed.
        avoidance, body, timescale, total: its energies.
        usable: candidates that can be timed.
        apart: those of them whose sampled clearance is not negative.
        saturated: how many of the latter have an avoidance energy of 0, of 1, and a body energy
            of 1. [3]
    """

    number: Int[Array, "*g"]
    avoidance: Float[Array, "*g"]
    body: Float[Array, "*g"]
    timescale: Float[Array, "*g"]
    total: Float[Array, "*g"]
    usable: Int[Array, "*g"]
    apart: Int[Array, "*g"]
    saturated: Int[Array, "*g 3"]


def rescore(judged: Judged, config: EnergyConfig, *, limit_scale: bool) -> Judged:
    """The same candidates with the energies of other settings (eqs 6, 8–10).

    Args:
        judged: by :func:`mgjax.avoidance.energy.score.judge_all` with ``limit_scale=False`` and the
            same ``form``; nothing else of the settings it was judged with matters.
        config: the other settings.
        limit_scale: rejects time scales outside [1/E_time, E_time].
    """
    timing, found = judged.timing, judged.energies
    status = timing.status
    if limit_scale:
        limit = jnp.asarray(config.E_time, jnp.float32)
        out = (timing.s_time > limit) | (timing.s_time * limit < 1)
        status = jnp.where((status == OK) & out, OUT_OF_RANGE, status)
    avoidance = avoidance_energy(found.penetration, config.E_avoidance)
    body = body_energy(found.d, found.d0, config)
    timescale = time_scale_energy(timing.s_time, config.E_time)
    return Judged(
        timing=replace(timing, status=status),
        energies=replace(found, avoidance=avoidance, body=body),
        timescale=timescale,
        total=total_energy(avoidance, body, timescale, config),
    )


def pick(
    judged: Judged,
    verdict: Int[Array, " C"],
    clearance: Float[Array, " C"],
    config: EnergyConfig,
    *,
    limit_scale: bool,
    checks: int,
) -> Picked:
    """What one setting picks among judged candidates.

    Args:
        judged: see :func:`rescore`.
        verdict: ``CLEAR``, ``TOUCHED`` or ``UNKNOWN``.
        clearance: by the exact check, m.
        config: the setting.
        limit_scale: see :func:`rescore`.
        checks: most candidates that are looked at.
    """
    again = rescore(judged, config, limit_scale=limit_scale)
    order = ranking(again)
    usable = again.timing.status == OK
    hopeful = _count(usable & (again.energies.d >= -HOPELESS_M))
    looked_at = usable[order] & (jnp.arange(len(order)) < jnp.clip(hopeful, 1, checks))
    wins = looked_at & (verdict[order] != TOUCHED)
    nearest = jnp.argmax(jnp.where(looked_at, clearance[order], -jnp.inf))
    place = jnp.where(jnp.any(wins), jnp.argmax(wins), nearest)
    number = order[place]
    apart = usable & (again.energies.d >= 0)
    full = [again.energies.avoidance <= 0, again.energies.avoidance >= 1, again.energies.body >= 1]
    return Picked(
        number=jnp.where(jnp.any(usable), number, NONE),
        avoidance=again.energies.avoidance[number],
        body=again.energies.body[number],
        timescale=again.timescale[number],
        total=again.total[number],
        usable=_count(usable),
        apart=_count(apart),
        saturated=jnp.stack([_count(apart & x) for x in full]),
    )


def _count(mask: Array) -> Array:
    return jnp.sum(mask.astype(jnp.int32))


@partial(jax.jit, static_argnames=("limit_scale", "checks"))
def pick_each(
    judged: Judged,
    verdict: Int[Array, " C"],
    clearance: Float[Array, " C"],
    grid: EnergyConfig,
    *,
    limit_scale: bool,
    checks: int,
) -> Picked:
    """What each setting of a grid picks; the numbers of ``grid`` are arrays [G]."""
    one = partial(pick, limit_scale=limit_scale, checks=checks)
    return jax.vmap(one, in_axes=(None, None, None, 0))(judged, verdict, clearance, grid)
