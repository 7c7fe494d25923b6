"""Time scaling: the speed of a walk is changed so that the avoidance meets the attack (§4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from mgjax.core.arrays import Array
from mgjax.core.pytree import register

OK, NOT_ADJUSTABLE, OUT_OF_RANGE, PADDING = 0, 1, 2, 3
"""What is known of a candidate: its time scale; none may be scaled; out of range; no candidate."""


@register()
@dataclass(frozen=True, kw_only=True)
class Timing:
    """How the edges of one walk, or of many, are played.

    Attributes:
        s_time: factor on the duration of the adjustable edges (eq. 3).
        scales: factor on the duration of each edge. [L]
        status: ``OK``, ``NOT_ADJUSTABLE`` or ``OUT_OF_RANGE``.
    """

    s_time: Float[Array, "*c"]
    scales: Float[Array, "*c L"]
    status: Int[Array, "*c"]


def time_scale(
    seconds: Float[Array, " L"],
    slow_down: Bool[Array, " L"],
    speed_up: Bool[Array, " L"],
    length: Int[Array, ""],
    part_centre: Float[Array, ""],
    t_attack: Float[Array, ""],
    *,
    half_frame: float,
    limit: Float[Array, ""],
) -> Timing:
    """Scales one walk (eqs 2–3).

    s_time = (t_attack − t_nonadjustable) / t_adjustable, both counted up to the middle of the
    avoidance part; every adjustable edge is scaled whole. Where the path must become shorter, the
    edges that may be sped up are adjustable, else those that may be slowed down.

    Deviation:
        Where the times agree to half a frame nothing is scaled and nothing need be adjustable. A
        factor outside [1/limit, limit] is out of range; the paper keeps it (``limit`` = inf).

    Args:
        seconds: natural duration of each edge, padded. [L]
        slow_down, speed_up: whether it may be. [L]
        length: edges in the walk; the last holds the part.
        part_centre: middle of the part within the last edge, s.
        t_attack: s from the beginning of the walk.
        half_frame: half a frame of the motion, s.
        limit: largest factor, and inverse of the smallest.
    """
    index = jnp.arange(seconds.shape[0])
    counted = jnp.where(index < length - 1, seconds, 0.0)
    counted = jnp.where(index == length - 1, part_centre, counted)
    t_avoid = jnp.sum(counted)
    adjustable = jnp.where(t_avoid > t_attack, speed_up, slow_down) & (index < length)
    flexible = jnp.sum(jnp.where(adjustable, counted, 0.0))
    exact = jnp.abs(t_avoid - t_attack) <= half_frame
    s = (t_attack - (t_avoid - flexible)) / jnp.maximum(flexible, 1e-6)
    s = jnp.where(exact, 1.0, s)
    out = (s <= 0) | (s > limit) | (s * limit < 1)
    stiff = (flexible < 1e-6) & ~exact
    status = jnp.where(stiff, NOT_ADJUSTABLE, jnp.where(out, OUT_OF_RANGE, OK))
    usable = jnp.where(status == OK, s, 1.0)
    return Timing(s_time=usable, scales=jnp.where(adjustable & ~exact, usable, 1.0), status=status)
