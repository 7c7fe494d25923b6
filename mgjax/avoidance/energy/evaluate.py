"""Many candidates judged at once: their timing, their body volume in the world, their energies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import MOMENTS, AttackBatch, AttackColumn, make_attack_batch
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.body.device_tables import DeviceTables, PartColumn
from mgjax.avoidance.body.volumes import (
    PlacedColumn,
    PlacedEdges,
    chain_transforms,
    read_edges,
)
from mgjax.avoidance.candidates.batch import CANDIDATE_TILE, CandidateBatch, pad_candidates
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.energy.accumulate import accumulate
from mgjax.avoidance.energy.displacement import displacements
from mgjax.avoidance.energy.score import Measures, Scores, score
from mgjax.avoidance.timing.time_scale import OK, PADDING, Timing, scale_limits, time_scale
from mgjax.core.arrays import Array
from mgjax.core.xla.materialise import stage
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True)
class Judged:
    """What is known of each of C candidates: when it is played, what was measured, its worth.

    Fields of the parts are [C]; ``timing.scales`` is [L, C].
    """

    timing: Timing
    measures: Measures
    scores: Scores


def timed_and_placed(
    tables: DeviceTables,
    walks: CandidateBatch,
    attack_batch: AttackBatch,
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> tuple[Timing, PlacedEdges]:
    """When some candidates are played (§4.1), and where their edges then lie."""
    limits = scale_limits(config, limit_scale)
    t_attack = walks.each(attack_batch.number(AttackColumn.T_ATTACK))

    def begin(edges: Array, length: Array, part: Array, t_attack: Array) -> tuple:
        read = read_edges(tables, edges)
        timing = time_scale(
            read.seconds,
            read.slow_down > 0,
            read.speed_up > 0,
            length,
            tables.parts[part, PartColumn.CENTRE],
            t_attack,
            half_frame=half_frame,
            limits=limits,
        )
        timing = replace(timing, status=jnp.where(length > 0, timing.status, PADDING))
        return timing, chain_transforms(tables, edges, read, timing.scales)

    return stage(tables.opaque_true, begin, walks.edges, walks.length, walks.part, t_attack)


def judge_tile(
    tables: DeviceTables,
    walks: CandidateBatch,
    attack_batch: AttackBatch,
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Judged:
    """Timing and energies of some candidates (§4.1, §4.2)."""
    timing, placed = timed_and_placed(
        tables, walks, attack_batch, config, half_frame=half_frame, limit_scale=limit_scale
    )
    last = placed.row(jnp.maximum(walks.length - 1, 0)[None])[0]
    begins, scale = last[:, PlacedColumn.BEGIN], last[:, PlacedColumn.SCALE]
    part = tables.parts[walks.part]
    span = (
        begins + part[:, PartColumn.START] * scale,
        begins + part[:, PartColumn.STOP] * scale,
    )
    totals, met = accumulate(tables, walks, placed, span, attack_batch, config)
    crop = walks.each(
        attack_batch.number(AttackColumn.CROP_END) - attack_batch.number(AttackColumn.CROP_START)
    )
    dt = crop / (walks.each(attack_batch.number(AttackColumn.EVALUATED)) - 1)
    penetration, d, d0 = totals.measured(met, dt)
    displacement = stage(
        jnp.asarray(config.w_m) > 0, displacements, tables, walks, placed, attack_batch
    )
    measures = Measures(
        penetration=penetration, d=d, d0=d0, displacement=displacement, s_time=timing.s_time
    )
    return Judged(timing=timing, measures=measures, scores=score(measures, config))


def judge_all(
    tables: DeviceTables,
    walks: CandidateBatch,
    attack_batch: AttackBatch,
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Judged:
    """Timing and energies of any number of candidates: up to a tile, or a multiple of one.

    Tiles without candidates are left out, so large arrays of few candidates cost little.
    """
    one = partial(
        judge_tile,
        tables,
        attack_batch=attack_batch,
        config=config,
        half_frame=half_frame,
        limit_scale=limit_scale,
    )
    if walks.length.shape[0] <= CANDIDATE_TILE:
        return one(walks)

    def cut(tile: Array | int) -> CandidateBatch:
        return jax.tree.map(
            lambda x: jax.lax.dynamic_slice_in_dim(
                x, tile * CANDIDATE_TILE, CANDIDATE_TILE, axis=x.ndim - 1
            ),
            walks,
        )

    def padding(nothing: Judged) -> Judged:
        status = jnp.full_like(walks.length, PADDING)
        return replace(nothing, timing=replace(nothing.timing, status=status))

    count = jnp.sum((walks.length > 0).astype(jnp.int32))
    return over_tiles(lambda tile: one(cut(tile)), walks.length.shape[0], count, padding)


T = TypeVar("T")


def over_tiles(
    one: Callable[[Array | int], T],
    size: int,
    count: Array,
    padding: Callable[[T], T],
    tile_size: int = CANDIDATE_TILE,
) -> T:
    """What ``one`` says of each of the tiles that hold the first ``count`` of some candidates.

    Args:
        one: from the number of a tile; arrays have the candidates last.
        size: candidates and padding.
        count: candidates.
        padding: from zeros what is said of the others.
        tile_size: candidates of a tile.
    """
    shapes = jax.eval_shape(one, 0)
    nothing = padding(jax.tree.map(lambda x: jnp.zeros((*x.shape[:-1], size), x.dtype), shapes))

    def step(tile: Array, known: T) -> T:
        return jax.tree.map(
            lambda total, part: jax.lax.dynamic_update_slice_in_dim(
                total, part, tile * tile_size, axis=total.ndim - 1
            ),
            known,
            one(tile),
        )

    tiles = (count + tile_size - 1) // tile_size
    return jax.lax.fori_loop(0, tiles, step, nothing)


def ranking(judged: Judged, owner: Int[Array, " C"] | None = None) -> Int[Array, " C"]:
    """Candidates in the order of their energy; those that seem to be hit after them, then the rest.

    The volumes that rank are samples, so a small penetration there is not yet a hit: such
    candidates follow, the least touched first, and the exact check decides on all. Last are those
    that cannot be timed. Ties go to the lower number. With an ``owner`` they are ordered by that
    first.
    """
    d = judged.measures.d
    value = jnp.abs(jnp.where(d < 0, d, judged.scores.total))  # also of a zero with a sign
    # Numbers that are not negative are in the order of their bits.
    bits = jax.lax.bitcast_convert_type(value, jnp.uint32)
    key = jnp.where(d < 0, bits | jnp.uint32(1 << 31), bits)
    key = jnp.where(judged.timing.status == OK, key, jnp.uint32(0xFFFFFFFF))
    return jnp.argsort(key) if owner is None else jnp.lexsort((key, owner))


_judge = jax.jit(judge_all, static_argnames=("half_frame", "limit_scale"))


def judge(
    device: DeviceTables,
    candidates: Candidates,
    attack: Attack,
    crop: Crop,
    config: AvoidanceConfig,
    *,
    frame_rate: float,
    unmoved: Float[np.ndarray, "K B"] | None = None,
) -> dict[str, np.ndarray]:
    """Energies and timing of all candidates, as NumPy arrays by name; ``order`` ranks them.

    The attack is in the planar frame of the node at which the walks begin, and time counts from
    there. Shapes are padded to a few sizes, so that attacks do not compile anew. ``unmoved`` is the
    body that does not react, as :func:`~mgjax.avoidance.attacks.batch.make_attack_batch` takes it;
    without it there is no movement energy.
    """
    energy = config.energy
    if unmoved is None:
        energy = replace(energy, w_m=0.0)
        unmoved = np.zeros((MOMENTS, 3 * len(device.radii)), np.float32)
    judged = _judge(
        device,
        pad_candidates(candidates),
        make_attack_batch(attack, crop, config, 0.0, unmoved),
        energy,
        half_frame=0.5 / frame_rate,
        limit_scale=config.limit_scale,
    )
    count = len(candidates.length)
    table = {name: np.asarray(value)[..., :count] for name, value in by_name(judged).items()}
    table["scales"] = table["scales"].T
    usable = table["status"] == OK
    d = table["d"]
    keys = (np.where(d < 0, -d, table["total"]), d < 0, ~usable)
    table["order"] = np.lexsort(keys)[: int(usable.sum())]
    return table


def by_name(judged: Judged) -> dict[str, Array]:
    """All measures and scores by name, and ``scales`` and ``status`` of the timing."""
    rows = {
        field.name: getattr(part, field.name)
        for part in (judged.measures, judged.scores)
        for field in fields(part)
    }
    return rows | {"scales": judged.timing.scales, "status": judged.timing.status}
