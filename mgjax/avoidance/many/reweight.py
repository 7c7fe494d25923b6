"""Judged candidates under other settings: what a sweep needs to compute only once.

The penetration e', the clearances d and d0, the displacement and the time scale of a candidate do
not depend on E_avoidance, D_body, D_move, E_time, E_fast and the weights. A whole grid of those is
therefore one compiled call that ranks the same candidates again, exactly as a search with these
settings would.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Float, Int

from mgjax.avoidance.choice.search import HOPELESS_M
from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.evaluate import Judged, ranking
from mgjax.avoidance.energy.score import Scores, score
from mgjax.avoidance.timing.time_scale import OK, OUT_OF_RANGE, scale_limits
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

NONE = -1
"""No candidate."""


class Certainty(IntEnum):
    """What is certain of a candidate by its bounds or the exact check."""

    CLEAR = 0
    TOUCHED = 1
    UNKNOWN = 2


@register()
@dataclass(frozen=True, kw_only=True)
class Picked:
    """The candidate that one setting picks, and how often its energies are saturated.

    Attributes:
        number: the first in the order that is not touched; where all that are looked at are,
            the one with the largest clearance; ``NONE`` where none can be timed.
        scores: its energies.
        usable: candidates that can be timed.
        apart: those of them whose sampled clearance is not negative.
        saturated: how many of the latter have an avoidance energy of 0, of 1, and a body energy
            of 1. [3]
    """

    number: Int[Array, "*g"]
    scores: Scores
    usable: Int[Array, "*g"]
    apart: Int[Array, "*g"]
    saturated: Int[Array, "*g 3"]


def reweight(judged: Judged, config: EnergyConfig, *, limit_scale: bool) -> Judged:
    """Judged candidates with the energies of other settings (eqs 6, 8–10).

    Args:
        judged: by :func:`mgjax.avoidance.energy.evaluate.judge_all` with ``limit_scale=False`` and
            the same ``form``; nothing else of the settings it was judged with matters.
        config: the other settings.
        limit_scale: rejects time scales outside [1/E_time, E_time] and below 1/E_fast.
    """
    timing = judged.timing
    status = timing.status
    if limit_scale:
        slowest, fastest = scale_limits(config, limit_scale)
        out = (timing.s_time > slowest) | (timing.s_time * fastest < 1)
        status = jnp.where((status == OK) & out, OUT_OF_RANGE, status)
    return Judged(
        timing=replace(timing, status=status),
        measures=judged.measures,
        scores=score(judged.measures, config),
    )


def pick(
    judged: Judged,
    certainty: Int[Array, " C"],
    clearance: Float[Array, " C"],
    config: EnergyConfig,
    *,
    limit_scale: bool,
    checks: int,
) -> Picked:
    """What one setting picks among judged candidates.

    Args:
        judged: see :func:`reweight`.
        certainty: what is certain of each, see :class:`Certainty`.
        clearance: by the exact check, m.
        config: the setting.
        limit_scale: see :func:`reweight`.
        checks: most candidates that are looked at.
    """
    again = reweight(judged, config, limit_scale=limit_scale)
    order = ranking(again)
    usable = again.timing.status == OK
    d, scores = again.measures.d, again.scores
    hopeful = _count(usable & (d >= -HOPELESS_M))
    looked_at = usable[order] & (jnp.arange(len(order)) < jnp.clip(hopeful, 1, checks))
    wins = looked_at & (certainty[order] != int(Certainty.TOUCHED))
    nearest = jnp.argmax(jnp.where(looked_at, clearance[order], -jnp.inf))
    place = jnp.where(jnp.any(wins), jnp.argmax(wins), nearest)
    number = order[place]
    apart = usable & (d >= 0)
    full = [scores.avoidance <= 0, scores.avoidance >= 1, scores.body >= 1]
    return Picked(
        number=jnp.where(jnp.any(usable), number, NONE),
        scores=jax.tree.map(lambda values: values[number], scores),
        usable=_count(usable),
        apart=_count(apart),
        saturated=jnp.stack([_count(apart & x) for x in full]),
    )


def _count(mask: Array) -> Array:
    return jnp.sum(mask.astype(jnp.int32))


@partial(jax.jit, static_argnames=("limit_scale", "checks"))
def pick_each(
    judged: Judged,
    certainty: Int[Array, " C"],
    clearance: Float[Array, " C"],
    grid: EnergyConfig,
    *,
    limit_scale: bool,
    checks: int,
) -> Picked:
    """What each setting of a grid picks; the numbers of ``grid`` are arrays [G]."""
    one = partial(pick, limit_scale=limit_scale, checks=checks)
    return jax.vmap(one, in_axes=(None, None, None, 0))(judged, certainty, clearance, grid)
