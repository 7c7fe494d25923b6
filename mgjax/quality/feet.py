"""Feet: how they skate, how fast they are while they touch the floor, how deep and how high.

Each function takes one motion, padded; ``count`` says how many of its frames are there, and
``first`` and ``last`` between which of them is counted. Heights are over the floor at 0; heights
and speeds of the definitions are those of an adult and are scaled to the body.
"""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from mgjax.core.arrays import Array
from mgjax.core.contacts import PLANT_HEIGHT_M, PLANT_SPEED_M_S

CONTACT_M = 0.05
"""A toe lower than this touches the floor (GMD, Kimodo)."""
SKATE_M_S = 0.5
"""A toe faster than this while it touches the floor skates (GMD)."""
SKATE_MEAN = 5
"""Steps over which its speed is averaged, too (GMD)."""
SLIDE_M = 0.025
"""A joint less than this above where it rests is weighted as sliding (MANN)."""
FAST_M_S = 0.2
"""A contact that is faster than this is counted."""

Number = Float[Array, ""]
Count = Int[Array, ""]


def counted(steps: int, reach: int, first: Count, last: Count) -> Bool[Array, " S"]:
    """Which of so many runs of ``reach`` + 1 frames lie between two frames, both included."""
    index = jnp.arange(steps)
    return (index >= first) & (index + reach <= last)


def skating(
    toes: Float[Array, "F 2 3"], count: Count, *, rate: float, scale: Number
) -> Bool[Array, " S"]:
    """Whether either foot skates in each step from a frame to the next. [F − 1]

    A toe touches the floor where it is below 5 cm in both frames; it skates where its horizontal
    speed then and the mean of its speeds over five steps around it, which are 0 outside of the
    motion, are above 0.5 m/s (Karunratanakul et al. 2023, GMD; there at 20 Hz).
    """
    steps = toes.shape[0] - 1
    there = counted(steps, 1, jnp.zeros((), count.dtype), count - 1)[:, None]
    moved = toes[1:, :, ::2] - toes[:-1, :, ::2]
    speed = jnp.where(there, jnp.sqrt(jnp.sum(moved * moved, axis=-1)), 0.0) * rate
    half = SKATE_MEAN // 2
    around = jnp.pad(speed, ((half, half), (0, 0)))
    total = sum(around[i : i + steps] for i in range(SKATE_MEAN))
    low = toes[..., 1] < CONTACT_M * scale
    fast = SKATE_M_S * scale
    skates = low[1:] & low[:-1] & there & (speed > fast) & (total > SKATE_MEAN * fast)
    return jnp.any(skates, axis=1)


def contact_speeds(
    toes: Float[Array, "F n 3"], *, rate: float, scale: Number
) -> tuple[Float[Array, "S n"], Bool[Array, "S n"]]:
    """Speed of each toe to the next frame, in space, m/s, and whether it touches the floor."""
    moved = toes[1:] - toes[:-1]
    # The root of a speed of 0 has a slope that is not finite.
    speed = jnp.sqrt(jnp.maximum(jnp.sum(moved * moved, axis=-1), 1e-20)) * rate
    return speed, toes[:-1, :, 1] < CONTACT_M * scale


def slides(
    feet: Float[Array, "F n 3"], rests: Float[Array, " n"], *, rate: float, scale: Number
) -> Float[Array, "S n"]:
    """How far each joint of the feet slides from a frame to the next, in 1/30 s, m.

    Its way over the floor times 2 − 2^(h / H), for heights h over where it rests below H = 2.5 cm
    (Zhang et al. 2018, MANN).
    """
    moved = feet[1:, :, ::2] - feet[:-1, :, ::2]
    way = jnp.sqrt(jnp.maximum(jnp.sum(moved * moved, axis=-1), 1e-20)) * (rate / 30)
    height = jnp.maximum(feet[:-1, :, 1] - rests[None], 0.0) / (SLIDE_M * scale)
    return jnp.where(height < 1, way * (2 - 2**height), 0.0)


def sunk(feet: Float[Array, "F n 3"]) -> Float[Array, "F n"]:
    """How deep each joint of the feet is below the floor, m."""
    return jnp.maximum(-feet[..., 1], 0.0)


def floating(
    toes: Float[Array, "F 2 3"], rests: Float[Array, "2"], *, rate: float, scale: Number
) -> tuple[Float[Array, " S"], Bool[Array, " S"]]:
    """How high the lower foot is over where its toe rests, m, and whether it stands. [F − 1]

    It stands where it is low and slow (:data:`mgjax.core.contacts.PLANT_HEIGHT_M`): a guess with an
    error of its own, from which what is said of standing feet inherits.
    """
    speed, _ = contact_speeds(toes, rate=rate, scale=scale)
    height = toes[:-1, :, 1]
    stands = (height < PLANT_HEIGHT_M * scale) & (speed < PLANT_SPEED_M_S * scale)
    over = height - rests[None]
    left = over[:, 0] < over[:, 1]
    return jnp.min(over, axis=1), jnp.where(left, stands[:, 0], stands[:, 1])
