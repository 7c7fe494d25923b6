"""Where the spheres of a body are nearest to those of an attack."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Float, Int

from mgjax.avoidance.rates import FAR
from mgjax.core.arrays import Array

CHUNK = 32
"""In so many intervals each sphere counts once, where it is nearest."""


def swept(
    attack: Float[Array, "T I 3"],
    attack_radii: Float[Array, " I"],
    absent: Float[Array, "V I"],
    spheres: Float[Array, "T S 3"],
    radii: Float[Array, " S"],
) -> tuple[Float[Array, "V S"], Float[Array, "V S 3"], Float[Array, "V S"]]:
    """Clearance of each sphere in each interval, m; the way to it at the closest; and when.

    Both move straight from moment to moment. The way is the unit vector from the attack to the
    sphere, and the time is the share of the interval.

    Args:
        attack, attack_radii: spheres of the attack at T moments, m.
        absent: 1 where one is not there between two moments, else 0; V = T − 1.
        spheres, radii: of the body, m.
    """
    gaps = spheres[:, None] - attack[:, :, None]  # [T, I, S, 3]
    begin, move = gaps[:-1], gaps[1:] - gaps[:-1]
    along = jnp.maximum(jnp.sum(move * move, axis=-1), 1e-12)
    share = jnp.clip(-jnp.sum(begin * move, axis=-1) / along, 0.0, 1.0)
    near = begin + share[..., None] * move
    distance = jnp.sqrt(jnp.sum(near * near, axis=-1) + 1e-12)
    gap = distance - attack_radii[None, :, None] - radii[None, None] + FAR * absent[..., None]
    nearest = jnp.argmin(gap, axis=1)[:, None]

    def pick(values: Array) -> Array:
        index = nearest if values.ndim == 3 else nearest[..., None]
        return jnp.take_along_axis(values, index, axis=1)[:, 0]

    return pick(gap), pick(near / distance[..., None]), pick(share)


def nearest_intervals(gap: Float[Array, "V S"]) -> Int[Array, "H S"]:
    """In which interval of each chunk each sphere is nearest, of those nearer than their
    neighbours; where there is none, the first that is farthest from being one."""
    far = jnp.full((1, gap.shape[1]), jnp.inf, dtype=gap.dtype)
    before, after = jnp.concatenate([far, gap[:-1]]), jnp.concatenate([gap[1:], far])
    least = jnp.where((gap <= before) & (gap < after), gap, gap + 2 * FAR)
    chunks = -(-len(gap) // CHUNK)
    padded = jnp.concatenate(
        [least, jnp.broadcast_to(far, (chunks * CHUNK - len(gap), gap.shape[1]))]
    )
    first = jnp.arange(chunks, dtype=jnp.int32)[:, None] * CHUNK
    inner = jnp.argmin(padded.reshape(chunks, CHUNK, -1), axis=1).astype(jnp.int32)
    return jnp.minimum(first + inner, len(gap) - 1)


def is_least(gap: Float[Array, "V S"], at: Int[Array, "H S"]) -> Array:
    """Whether the intervals picked are nearer than their neighbours."""
    own = jnp.arange(gap.shape[1], dtype=jnp.int32)[None]
    last = len(gap) - 1
    here = gap[at, own]
    before = jnp.where(at > 0, gap[jnp.maximum(at - 1, 0), own], jnp.inf)
    after = jnp.where(at < last, gap[jnp.minimum(at + 1, last), own], jnp.inf)
    return (here <= before) & (here < after)
