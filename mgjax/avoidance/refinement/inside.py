"""Limbs in the body: how deep changed poses put them there, and how that changes."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.refinement.rig import Rig
from mgjax.avoidance.refinement.slopes import Changed
from mgjax.core.arrays import Array
from mgjax.core.body.capsules import nearest_shares, pair_distances

DEPTH_M = 0.01
"""How much deeper than in the capture limbs may be in the body, of an adult; or as deep as they
were without the change."""
AIMED = 0.7
"""Share of it that is aimed at."""
MOST_PAIRS = 8
"""Pairs of capsules that a step looks at: those that are deepest at any moment."""


def depths(rig: Rig, places: Float[Array, "*t J 3"]) -> Float[Array, "*t P"]:
    """How much deeper each pair of capsules is in each other than in the capture, m."""
    allowed = rig.apart.reshape((1,) * (places.ndim - 2) + (-1,))
    return allowed - pair_distances(rig.pairs, places)


def deepest(
    rig: Rig, now: Changed, limits: Float[Array, "T P"]
) -> tuple[Float[Array, "T K"], Float[Array, "T K C"]]:
    """By how much the worst pairs of capsules are deeper than so, m, and the derivatives.

    The nearest points of two capsules stay where they are on them to the first order.

    Args:
        rig: the channels.
        now: changed poses.
        limits: the depths, m.
    """
    count = min(MOST_PAIRS, len(rig.pairs.reach))
    if not count:
        none = jnp.zeros((len(limits), 0), limits.dtype)
        return none, jnp.zeros((*none.shape, rig.channels), limits.dtype)
    beyond = depths(rig, now.places) - limits
    _, worst = jax.lax.top_k(jnp.max(beyond, axis=0), count)
    joints = rig.pairs.joints[worst]  # [K, 4]
    ends = [now.places[:, joints[:, k]] for k in range(4)]
    s, t = nearest_shares(*ends)
    shares = jnp.stack([1 - s, s, t - 1, -t], axis=-1)  # [T, K, 4]
    way = jnp.einsum("tke,etkx->tkx", shares, jnp.stack(ends))
    way = way / jnp.sqrt(jnp.sum(way * way, axis=-1, keepdims=True) + 1e-12)
    slopes = jnp.einsum("tke,tkx,tkexc->tkc", shares, way, now.to_places[:, joints])
    return beyond[:, worst], -slopes


def too_deep(
    rig: Rig,
    were: Float[np.ndarray, "T J 3"],
    are: Float[np.ndarray, "T J 3"],
    scale: float,
) -> bool:
    """Whether a change of places of joints, m, puts a limb deeper in the body than it was, and than
    it may be."""
    near = _may_meet(rig, are)
    joints, reach, least = (np.asarray(x) for x in (rig.pairs.joints, rig.pairs.reach, rig.apart))
    pairs = replace(rig.pairs, joints=joints[near], reach=reach[near])
    some = replace(rig, apart=least[near], pairs=pairs)
    if np.max(depths(some, are), initial=0.0) <= DEPTH_M * scale:
        return False
    pairs = replace(rig.pairs, joints=joints, reach=reach)
    every = replace(rig, apart=least, pairs=pairs)
    return bool(np.max(depths(some, are)) > np.max(depths(every, were)))


def _may_meet(rig: Rig, places: Float[np.ndarray, "T J 3"]) -> Bool[np.ndarray, " P"]:
    """Which pairs of capsules may meet at any moment, by the spheres around them."""
    ends = np.asarray(rig.pairs.joints)
    bones, number = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    first, second = number.reshape(-1, 2).T
    middles = 0.5 * (places[:, bones[:, 0]] + places[:, bones[:, 1]])
    bone = places[:, bones[:, 0]] - places[:, bones[:, 1]]
    half = 0.5 * np.sqrt(np.max(np.sum(bone * bone, axis=-1), axis=0))
    way = middles[:, first] - middles[:, second]
    away = np.sqrt(np.min(np.sum(way * way, axis=-1), axis=0))
    return away < half[first] + half[second] + np.asarray(rig.pairs.reach)
