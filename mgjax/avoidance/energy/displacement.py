"""How far candidates take the body from where it would be without a reaction."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Float

from mgjax.avoidance.attacks.batch import AttackBatch, AttackColumn
from mgjax.avoidance.body.device_tables import DeviceTables
from mgjax.avoidance.body.volumes import PlacedEdges, locate, spheres_at
from mgjax.avoidance.candidates.batch import CandidateBatch
from mgjax.core.arrays import Array

_TINY = 1e-20
"""Squared length under which two points coincide, m²."""


def displacements(
    tables: DeviceTables,
    walks: CandidateBatch,
    placed: PlacedEdges,
    attack_batch: AttackBatch,
) -> Float[Array, " C"]:
    """Mean displacement of the body of each candidate against not reacting, m.

    Over the moments of :attr:`~mgjax.avoidance.attacks.batch.AttackBatch.unmoved`, from now until
    the attack has passed; a walk that is over by then keeps its last pose.

    Args:
        tables: of the graph.
        walks, placed: the candidates, and their edges laid end to end.
        attack_batch: the attacks, with the body of who does not react.
    """
    attacks, count, _ = attack_batch.unmoved.shape
    share = (1 + jnp.arange(count, dtype=jnp.float32)) / count
    times = share[:, None] * walks.each(attack_batch.number(AttackColumn.CROP_END))[None]
    moved = spheres_at(tables, locate(tables, placed, times))
    still = jnp.moveaxis(attack_batch.unmoved.reshape(attacks, count, 3, -1), (2, 1), (0, 1))
    if walks.owner is not None:
        still = still[:, :, walks.owner]
    return mean_distance(moved, still, tables.radii)


def mean_distance(
    moved: Float[Array, "3 T C S"], still: Float[Array, "3 T A S"], radii: Float[Array, " S"]
) -> Float[Array, " C"]:
    """Mean distance of the spheres of C bodies from those of one other, or of one each, m.

    Its gradient is 0 where two centres coincide.

    Args:
        moved, still: centres, m.
        radii: of the spheres, m; below 0 for padding, which counts for nothing.
    """
    x, y, z = (moved[k] - still[k] for k in range(3))
    far = jnp.sqrt(jnp.maximum(x * x + y * y + z * z, _TINY))
    real = radii >= 0
    total = jnp.sum(jnp.where(real, far, 0.0), axis=(0, 2))
    return total / (moved.shape[1] * jnp.maximum(jnp.sum(real.astype(jnp.float32)), 1.0))
