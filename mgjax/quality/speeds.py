"""How fast joints are, as histograms, and how far two of them are apart."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Bool, Float

from mgjax.core.arrays import Array, namespace
from mgjax.quality.feet import Number

BIN_M_S = 0.1
"""Width of a bin, of an adult."""
BINS = 64
"""The last one takes all that is faster."""


def speed_histogram(
    places: Float[Array, "F J 3"], counted: Bool[Array, " S"], *, rate: float, scale: Number
) -> Float[Array, "J B"]:
    """How many steps from a frame to the next each joint is how fast.

    Args:
        places: m.
        counted: which steps.
        rate: frames per second.
        scale: of the body.
    """
    moved = places[1:] - places[:-1]
    speed = jnp.sqrt(jnp.sum(moved * moved, axis=-1)) * rate / scale
    number = jnp.clip(jnp.floor(speed / BIN_M_S), 0, BINS - 1).astype(jnp.int32)
    same = number[..., None] == jnp.arange(BINS, dtype=jnp.int32)[None, None]
    return jnp.sum(jnp.where(counted[:, None, None], same, False), axis=0).astype(places.dtype)


def hellinger(first: Float[Array, "*a B"], second: Float[Array, "*b B"]) -> Float[Array, "*c"]:
    """Hellinger distance of two histograms, 0 … 1: √(1 − Σ √(p q)); 1 where one is empty.

    As for joint speeds in the GENEA challenge (Kucherenko et al. 2021). Few samples alone put two
    histograms of one motion apart.
    """
    xp = namespace(first, second)
    p, q = (x / xp.maximum(xp.sum(x, axis=-1, keepdims=True), 1e-12) for x in (first, second))
    return xp.sqrt(xp.clip(1 - xp.sum(xp.sqrt(p * q), axis=-1), 0.0, 1.0))
