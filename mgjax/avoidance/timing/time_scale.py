"""Time scaling: the speed of a walk is changed so that the avoidance meets the attack (§4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.config import EnergyConfig
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

OK, NOT_ADJUSTABLE, OUT_OF_RANGE, PADDING = 0, 1, 2, 3
"""What is known of a candidate: its time scale; none may be scaled; out of range; no candidate."""


@register()
@dataclass(frozen=True, kw_only=True)
class Timing:
    """How the edges of one walk, or of many, are played.

    Attributes:
        s_time: factor on the duration of the adjustable edges (eq. 3).
        scales: factor on the duration of each edge. [L] or [L, C]
        status: ``OK``, ``NOT_ADJUSTABLE`` or ``OUT_OF_RANGE``.
    """

    s_time: Float[Array, "*c"]
    scales: Float[Array, "*l"]
    status: Int[Array, "*c"]


def time_scale(
    seconds: Float[Array, "*l"],
    slow_down: Bool[Array, "*l"],
    speed_up: Bool[Array, "*l"],
    length: Int[Array, "*c"],
    part_centre: Float[Array, "*c"],
    t_attack: Float[Array, "*a"],
    *,
    half_frame: float,
    limits: tuple[Array, Array],
) -> Timing:
    """Scales one walk, or many side by side (eqs 2–3).

    s_time = (t_attack − t_nonadjustable) / t_adjustable, both counted up to the middle of the
    avoidance part; every adjustable edge is scaled whole. Where the path must become shorter, the
    edges that may be sped up are adjustable, else those that may be slowed down.

    Deviation:
        Where the times agree to half a frame nothing is scaled and nothing need be adjustable. A
        factor out of its limits is out of range; the paper keeps it.

    Args:
        seconds: natural duration of each edge, padded. [L] or [L, C]
        slow_down, speed_up: whether it may be.
        length: edges in the walk; the last holds the part.
        part_centre: middle of the part within the last edge, s.
        t_attack: s from the beginning of the walk; one for each walk, or one for all.
        half_frame: half a frame of the motion, s.
        limits: largest factor, and inverse of the smallest.
    """
    index = jnp.arange(seconds.shape[0]).reshape(-1, *[1] * length.ndim)
    last = (length - 1)[None]
    counted = jnp.where(index < last, seconds, 0.0)
    counted = jnp.where(index == last, part_centre[None], counted)
    t_avoid = jnp.sum(counted, axis=0)
    shorten = t_avoid > t_attack
    adjustable = jnp.where(shorten[None], speed_up, slow_down) & (index < length[None])
    flexible = jnp.sum(jnp.where(adjustable, counted, 0.0), axis=0)
    exact = jnp.abs(t_avoid - t_attack) <= half_frame
    s = (t_attack - (t_avoid - flexible)) / jnp.maximum(flexible, 1e-6)
    s = jnp.where(exact, 1.0, s)
    slowest, fastest = limits
    out = (s <= 0) | (s > slowest) | (s * fastest < 1)
    stiff = (flexible < 1e-6) & ~exact
    status = jnp.where(stiff, NOT_ADJUSTABLE, jnp.where(out, OUT_OF_RANGE, OK))
    usable = jnp.where(status == OK, s, 1.0)
    scaled = adjustable & ~exact[None]
    return Timing(s_time=usable, scales=jnp.where(scaled, usable[None], 1.0), status=status)


UNLIMITED = 1e6
"""Largest time scale where the configuration sets no limit."""


def scale_limits(config: EnergyConfig, limit_scale: bool) -> tuple[Array, Array]:
    """The largest time scale, and the inverse of the smallest."""
    slowest = jnp.asarray(config.E_time if limit_scale else UNLIMITED, dtype=jnp.float32)
    if not limit_scale:
        return slowest, slowest
    return slowest, jnp.minimum(slowest, jnp.asarray(config.E_fast, dtype=jnp.float32))
