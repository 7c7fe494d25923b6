"""From what is measured of a candidate to what it is worth: its energies (eqs 6, 8–10).

Measures do not depend on the settings of the energies; scores do. A new term is a field of
:class:`Scores`, a line of :func:`score`, a field of :class:`Energy`, and its settings in
:class:`~mgjax.avoidance.config.EnergyConfig`; a new measure comes from the kernel.

:mod:`mgjax.avoidance.energy.promise` takes every term to be 0 or more; one that can be negative has
to be known there.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import jax
import jax.numpy as jnp
from jaxtyping import Float

from mgjax.avoidance.config import EnergyConfig
from mgjax.core.arrays import Array
from mgjax.core.traced import Number
from mgjax.core.xla.pytree import register

register("form", "d0")(EnergyConfig)

_SAME = 1e-5
"""Clearances that differ by less, m, are equal: rounding, some metres from the origin."""


@register()
@dataclass(frozen=True, kw_only=True)
class Measures:
    """What is measured of one candidate, or of each of many.

    Attributes:
        penetration: e' (eq. 4), m·s: what the avoidance moved out of the attack's way.
        d: least clearance of attack and body (eq. 7), m; negative where the body is hit.
        d0: the clearance had the body frozen when the avoidance began, m; never clamped here.
        displacement: how far the body is, on average, from where it would be without a reaction, m
            (:mod:`mgjax.avoidance.energy.displacement`); 0 where nothing asks for it.
        s_time: factor on the duration of the adjustable edges (eq. 3).
    """

    penetration: Float[Array, "*c"]
    d: Float[Array, "*c"]
    d0: Float[Array, "*c"]
    displacement: Float[Array, "*c"]
    s_time: Float[Array, "*c"]


@register()
@dataclass(frozen=True, kw_only=True)
class Scores:
    """What one candidate, or each of many, is worth; smaller is better.

    Attributes:
        total: e (eq. 10), and the weighted movement energy.
        avoidance: e_avoidance (eq. 6), 0 … 1.
        body: e_body (eq. 8), 0 … 1.
        movement: e_move, 0 … about 2.
        timescale: e_timescale (eq. 9).
    """

    total: Float[Array, "*c"]
    avoidance: Float[Array, "*c"]
    body: Float[Array, "*c"]
    movement: Float[Array, "*c"]
    timescale: Float[Array, "*c"]


@dataclass(frozen=True, kw_only=True)
class Energy:
    """What a chosen walk was worth and what of it was measured; the fields are those of eqs 4–10.

    Attributes:
        total, avoidance, body, movement, timescale: see :class:`Scores`.
        penetration, d, d0, displacement: see :class:`Measures`.
    """

    total: float
    avoidance: float
    body: float
    movement: float
    timescale: float
    penetration: float
    d: float
    d0: float
    displacement: float


ROWS = tuple(field.name for kind in (Measures, Scores) for field in fields(kind))
"""The names of all measures and scores, in the order in which :func:`stacked` has them."""


def score(measures: Measures, config: EnergyConfig) -> Scores:
    """The energies of candidates, and their weighted sum (eqs 6, 8–10).

    Differentiable with respect to the measures and to all numbers of the settings.

    Args:
        measures: of candidates, of whatever shape.
        config: forms, scales and weights.
    """
    avoidance = avoidance_energy(measures.penetration, config.E_avoidance)
    body = body_energy(measures.d, measures.d0, config)
    movement = movement_energy(measures.displacement, config.D_move)
    timescale = time_scale_energy(measures.s_time, config.E_time, config.w_speed_up)
    return Scores(
        total=total_energy(avoidance, body, timescale, config, movement),
        avoidance=avoidance,
        body=body,
        movement=movement,
        timescale=timescale,
    )


def stacked(measures: Measures, scores: Scores) -> Float[Array, "R C"]:
    """All measures and scores in one array, a row each, named by ``ROWS``."""
    values = {name: getattr(part, name) for part in (measures, scores) for name in _names(part)}
    return jnp.stack([values[name] for name in ROWS])


def _names(part: Measures | Scores) -> list[str]:
    return [field.name for field in fields(part)]


def avoidance_energy(
    penetration: Float[Array, "*c"] | float, E_avoidance: Number
) -> Float[Array, "*c"]:
    """e_avoidance (eq. 6): 1 − e'/E_avoidance, at least 0.

    Args:
        penetration: e' (eq. 4), m·s.
        E_avoidance: e' at which an avoidance is perfect, m·s, > 0.
    """
    return jnp.maximum(1 - _float32(penetration) / _float32(E_avoidance), 0.0)


def body_energy(
    d: Float[Array, "*c"] | float, d0: Float[Array, "*c"] | float, config: EnergyConfig
) -> Float[Array, "*c"]:
    """e_body (eq. 8): (d − d0)/D_body between d0 and d0 + D_body, and 1 outside.

    Args:
        d: clearance of the body (eq. 7), m.
        d0: the same had it frozen when the avoidance began, m; clamped here where ``config.d0``
            says so.
        config: ``d0`` and ``D_body``.
    """
    clear, frozen = _float32(d), _float32(d0)
    excess = clear - (jnp.maximum(frozen, 0.0) if config.d0 == "clamped" else frozen)
    width = _float32(config.D_body)
    return jnp.where((excess > _SAME) & (excess < width), excess / width, 1.0)


def movement_energy(displacement: Float[Array, "*c"] | float, D_move: Number) -> Float[Array, "*c"]:
    """e_move: the displacement against not reacting, in units of D_move.

    Deviation:
        Not the paper's. Its energies ask for a small clearance and a natural speed, and leave open
        how far the body goes for it.

    Args:
        displacement: m.
        D_move: m, > 0.
    """
    return _float32(displacement) / _float32(D_move)


def time_scale_energy(
    s: Float[Array, "*c"] | float, E_time: Number, w_speed_up: Number = 1.0
) -> Float[Array, "*c"]:
    """e_timescale (eq. 9): s/E_time if s > 1, 1/(s E_time) if s < 1; 1/E_time at s = 1.

    With ``w_speed_up`` it is (1 + w_speed_up (1/s − 1))/E_time if s < 1.

    Args:
        s: factor on the duration of the adjustable edges, > 0.
        E_time: largest acceptable factor.
        w_speed_up: how much more speeding up weighs than slowing down; 1 in the paper.
    """
    scale = jnp.maximum(jnp.abs(_float32(s)), 1e-6)
    slower, faster = jnp.maximum(scale, 1.0) - 1, jnp.maximum(1 / scale, 1.0) - 1
    return (1 + slower + _float32(w_speed_up) * faster) / _float32(E_time)


def total_energy(
    avoidance: Float[Array, "*c"] | float,
    body: Float[Array, "*c"] | float,
    timescale: Float[Array, "*c"] | float,
    config: EnergyConfig,
    movement: Float[Array, "*c"] | float = 0.0,
) -> Float[Array, "*c"]:
    """e (eq. 10), the weighted sum of the energies; the smallest wins."""
    return (
        _float32(config.w_a) * _float32(avoidance)
        + _float32(config.w_b) * _float32(body)
        + _float32(config.w_t) * _float32(timescale)
        + _float32(config.w_m) * _float32(movement)
    )


def _float32(value: Number) -> jax.Array:
    return jnp.asarray(value, jnp.float32)
