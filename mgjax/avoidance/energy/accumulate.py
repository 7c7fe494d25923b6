"""Candidates and their attacks compared moment by moment: what the energies are made of."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attacks.batch import (
    AttackBatch,
    AttackColumn,
    active_at,
    centres_at,
    evaluation_times,
)
from mgjax.avoidance.body.device_tables import DeviceTables
from mgjax.avoidance.body.volumes import PlacedEdges, locate, spheres_at
from mgjax.avoidance.candidates.batch import CandidateBatch
from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.kernel import Paths, RawMeasures, join, nothing_measured, over_sphere
from mgjax.core.arrays import Array

TIMES = 20
"""Times that are evaluated together. A ball that is quick enough for its radius to be the interval
needs no more to cross the cylinder around the body; for others the compiled code loops."""

_NEVER = 1 << 30


def accumulate(
    tables: DeviceTables,
    walks: CandidateBatch,
    placed: PlacedEdges,
    span: tuple[Array, Array],
    attack_batch: AttackBatch,
    config: EnergyConfig,
) -> tuple[RawMeasures, Bool[Array, " C"]]:
    """e'/Δt, d and d0 of candidates over the evaluated times, and whether their attack is there.

    ``TIMES`` moments at a time; each chunk begins with the last moment of the chunk before, so that
    nothing between them is left out.
    """
    count = walks.length.shape[0]
    start, stop = (x[None] for x in span)
    number = walks.each(attack_batch.number(AttackColumn.EVALUATED))[None]
    frozen_from = _first_within(walks, attack_batch, span)[None]

    def of_walks(values: Array) -> Array:
        """[T, A, …] of attacks to [T, C, …]; [T, 1, …] where there is but one."""
        return values if walks.owner is None else values[:, walks.owner]

    def chunk(k: Array, known: tuple[RawMeasures, Array]) -> tuple[RawMeasures, Array]:
        first = k * (TIMES - 1)
        index = first + jnp.arange(TIMES, dtype=jnp.int32)
        own_times = evaluation_times(attack_batch, index)
        centres = of_walks(centres_at(attack_batch, own_times))
        present = of_walks(active_at(attack_batch, own_times))
        times = jnp.broadcast_to(of_walks(own_times), (TIMES, count))
        # The pose at the start of the part is one more time.
        keys = locate(tables, placed, jnp.concatenate([times, start]))
        body = spheres_at(tables, keys)
        counts = index[:, None].astype(jnp.float32) < number
        active = counts & (times <= placed.stop[None])
        again = (index == first) & (k > 0)
        paths = Paths(
            centres=body[:, :-1],
            start=body[:, -1],
            radii=tables.radii,
            frozen=index[:, None] >= frozen_from,
            active=active,
            scored=active & (times >= start) & (times < stop) & ~again[:, None],
        )
        totals, met = known
        added = _over_spheres(paths, centres, of_radii(attack_batch), present, spheres, config)
        met = met | jnp.any(active & jnp.any(present, axis=-1), axis=0)
        return join(totals, added), met

    def of_radii(attack_batch: AttackBatch) -> Float[Array, "A I"]:
        return (
            attack_batch.spheres[:, 0]
            if walks.owner is None
            else attack_batch.spheres[walks.owner, 0]
        )

    spheres = jnp.max(attack_batch.number(AttackColumn.SPHERE_COUNT)).astype(jnp.int32)
    chunks = jnp.ceil(
        (jnp.max(attack_batch.number(AttackColumn.EVALUATED)) - 1) / (TIMES - 1)
    ).astype(jnp.int32)
    none = nothing_measured(count), jnp.zeros(count, bool)
    return jax.lax.fori_loop(0, chunks, chunk, none)


def _over_spheres(
    paths: Paths,
    centres: Float[Array, "T A D"],
    radii: Float[Array, "A I"],
    present: Bool[Array, "T A I"],
    count: Int[Array, ""],
    config: EnergyConfig,
) -> RawMeasures:
    """(e'/Δt, d, d0) over all spheres of the attacks, of which ``count`` are no padding."""
    slots = radii.shape[1]
    each = jnp.moveaxis(centres.reshape(*centres.shape[:2], slots, 3), (2, 3), (0, 1))

    def one(sphere: Array, radius: Array, present: Array) -> RawMeasures:
        return over_sphere(config.form, True, paths, sphere, radius, present)

    if slots == 1:
        return one(each[0], radii[:, 0], present[..., 0])

    def step(k: Array, known: RawMeasures) -> RawMeasures:
        return join(known, one(each[k], radii[:, k], present[..., k]))

    return jax.lax.fori_loop(0, count, step, nothing_measured(paths.active.shape[1]))


def _first_within(
    walks: CandidateBatch, attack_batch: AttackBatch, span: tuple[Array, Array]
) -> Int[Array, " C"]:
    """Number of the first evaluated time within the avoidance part; never where there is none."""
    begin, end, count = (
        walks.each(attack_batch.number(k))
        for k in (AttackColumn.CROP_START, AttackColumn.CROP_END, AttackColumn.EVALUATED)
    )
    start, stop = span
    step = jnp.maximum(end - begin, 1e-9) / (count - 1)

    def at(index: Array) -> Array:
        return begin + jnp.minimum(index / (count - 1), 1.0) * (end - begin)

    # By division, and one more or less where that is off by rounding.
    first = jnp.clip(jnp.ceil((start - begin) / step), 0.0, count)
    first = jnp.where((first > 0) & (at(first - 1) >= start), first - 1, first)
    first = jnp.where(at(first) < start, first + 1, first)
    inside = (first < count) & (at(first) < stop) & (at(first) >= start)
    return jnp.where(inside, first.astype(jnp.int32), _NEVER)
