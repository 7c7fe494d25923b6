"""Limbs in the body: how deep capsules of limbs are in the torso and in each other."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Float

from mgjax.core.arrays import Array
from mgjax.core.body.capsules import CapsulePairs, pair_distances


def self_penetration(
    pairs: CapsulePairs, places: Float[Array, "*f J 3"], apart: Float[Array, " P"]
) -> Float[Array, "*f"]:
    """How much deeper than in the capture any limb is in the body, m; 0 where none is.

    Args:
        pairs: capsules that should not meet.
        places: of all joints, m.
        apart: least distance of the surfaces of each pair in the capture, m; it excuses no pair
            that never meets there.
    """
    if not pairs.joints.shape[0]:
        return jnp.zeros(places.shape[:-2], places.dtype)
    allowed = jnp.minimum(apart, 0.0).reshape((1,) * (places.ndim - 2) + (-1,))
    return jnp.max(jnp.maximum(allowed - pair_distances(pairs, places), 0.0), axis=-1)
