"""What candidates promise before they are judged: most of them cannot be the best.

The time scale and the movement of a candidate are found at a fraction of the cost of its other
energies, which are not negative: they bound its total from below. Where the attack is deep in its
body at any one of a few moments it is touched, and comes after all that are not.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attacks.batch import AttackBatch, AttackColumn, active_at, centres_at
from mgjax.avoidance.body.device_tables import DeviceTables
from mgjax.avoidance.body.volumes import PlacedEdges, locate, spheres_at
from mgjax.avoidance.candidates.batch import CANDIDATE_TILE, CandidateBatch
from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.displacement import displacements
from mgjax.avoidance.energy.evaluate import Judged, judge_tile, over_tiles, timed_and_placed
from mgjax.avoidance.energy.score import Measures, movement_energy, score, time_scale_energy
from mgjax.avoidance.timing.time_scale import OK, PADDING, Timing
from mgjax.core.arrays import Array
from mgjax.core.xla.materialise import stage
from mgjax.core.xla.pytree import register

LOOKS = 6
"""Evaluated times at which a body is looked at before it is judged."""

CENTRAL = (0.2, 0.8)
"""Between which shares of the crop they lie."""

FIRST = 16
"""Candidates of each attack that are judged first, those that promise most."""

ROUNDING = 1e-3
"""What a bound may be off by: in units of energy, and as a share of it."""

DEEP_M = 0.021
"""How deep samples have to be touched to count. Such a motion is hit, without doubt
(:data:`mgjax.avoidance.choice.search.HOPELESS_M`)."""

TILE = CANDIDATE_TILE
"""Candidates that are looked at together. As many as in a search for one attack, so that energies
agree to the last bit; with four times as many it is a tenth faster."""

UNJUDGED = 1e30
"""Total of a candidate that cannot be the best."""


_MEASURES = tuple(field.name for field in fields(Measures))


@register()
@dataclass(frozen=True, kw_only=True)
class Promise:
    """What is known of candidates before they are judged.

    Attributes:
        timing: when they are played.
        least: their total is at least this. [C]
        touched: whether the attack is surely ``DEEP_M`` and more in their samples. [C]
    """

    timing: Timing
    least: Float[Array, " C"]
    touched: Bool[Array, " C"]


def promise_tile(
    tables: DeviceTables,
    walks: CandidateBatch,
    attack_batch: AttackBatch,
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Promise:
    """What some candidates promise; see :func:`~mgjax.avoidance.energy.evaluate.judge_tile`."""
    timing, placed = timed_and_placed(
        tables, walks, attack_batch, config, half_frame=half_frame, limit_scale=limit_scale
    )
    displacement = stage(
        jnp.asarray(config.w_m) > 0, displacements, tables, walks, placed, attack_batch
    )
    scaled = time_scale_energy(timing.s_time, config.E_time, config.w_speed_up)
    moved = movement_energy(displacement, config.D_move)
    touched = jnp.zeros(walks.length.shape, bool)
    if attack_batch.sphere_slots == 1:
        touched = _touched(tables, walks, placed, attack_batch)
    return Promise(
        timing=timing, least=_f32(config.w_t) * scaled + _f32(config.w_m) * moved, touched=touched
    )


def _touched(
    tables: DeviceTables, walks: CandidateBatch, placed: PlacedEdges, attack_batch: AttackBatch
) -> Bool[Array, " C"]:
    """Whether a single sphere touches bodies at any of ``LOOKS`` evaluated times."""
    begin, end, count = (
        attack_batch.number(k)[None]
        for k in (AttackColumn.CROP_START, AttackColumn.CROP_END, AttackColumn.EVALUATED)
    )
    shares = jnp.linspace(*CENTRAL, LOOKS, dtype=jnp.float32)[:, None]
    own_times = begin + jnp.round(shares * (count - 1)) / (count - 1) * (end - begin)
    centres, present = centres_at(attack_batch, own_times), active_at(attack_batch, own_times)
    radii = attack_batch.spheres[:, 0, 0]
    if walks.owner is not None:
        own_times, centres, present = (x[:, walks.owner] for x in (own_times, centres, present))
        radii = radii[walks.owner]
    times = jnp.broadcast_to(own_times, (LOOKS, walks.length.shape[0]))
    body = spheres_at(tables, locate(tables, placed, times))
    x, y, z = (body[k] - centres[..., k, None] for k in range(3))
    reach = (tables.radii[None] + radii[:, None] - DEEP_M)[None]
    near = (x * x + y * y + z * z < reach * reach) & (reach > 0)
    there = present[..., 0] & (times <= placed.stop[None])
    return jnp.any(near & there[..., None], axis=(0, 2))


def judge_promising(
    tables: DeviceTables,
    walks: CandidateBatch,
    attack_batch: AttackBatch,
    first: Int[Array, " A"],
    whole: Bool[Array, " A"],
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Judged:
    """Timing of all candidates of several attacks, and energies of those that may be the best.

    They are judged in three rounds: first the ``FIRST`` of each attack that promise most; then all
    that promise more than the best of these that is clear; and, of attacks of which none is clear,
    all. What is not judged has the total ``UNJUDGED`` and d = 0, or −1 m where it is touched.

    Args:
        tables, attack_batch, config, half_frame, limit_scale: see
            :func:`~mgjax.avoidance.energy.evaluate.judge_all`.
        walks: with the attack that each is meant for, in ascending order; padding goes to the last.
        first: number of the first candidate of each attack.
        whole: attacks whose candidates are all judged.
    """
    given = {"half_frame": half_frame, "limit_scale": limit_scale}
    owner, size = walks.owner, walks.length.shape[0]
    assert owner is not None, "several attacks"
    numbers = jnp.arange(size, dtype=jnp.int32)

    def promise(tile: Array | int) -> Promise:
        own = walks.rows(tile * TILE + jnp.arange(TILE, dtype=jnp.int32))
        return promise_tile(tables, own, attack_batch, config, **given)

    def padding(nothing: Promise) -> Promise:
        status = jnp.full_like(walks.length, PADDING)
        return replace(nothing, timing=replace(nothing.timing, status=status))

    count = jnp.sum((walks.length > 0).astype(jnp.int32))
    known = over_tiles(promise, size, count, padding, TILE)
    fit = known.timing.status == OK
    order = jnp.lexsort((jnp.where(known.touched | ~fit, UNJUDGED, known.least), owner))
    rank = jnp.zeros_like(numbers).at[order].set(numbers - first[owner])

    def judged(lanes: Int[Array, " C"], chosen: Array) -> Float[Array, "M C"]:
        """The measures of the first ``chosen`` of some candidates."""

        def one(tile: Array | int) -> Array:
            at = tile * TILE + jnp.arange(TILE, dtype=jnp.int32)
            own = walks.rows(lanes[at])
            length = jnp.where(at < chosen, own.length, 0)
            own = replace(own, table=jnp.asarray(own.table).at[-3].set(length))
            measures = judge_tile(tables, own, attack_batch, config, **given).measures
            return jnp.stack([getattr(measures, name) for name in _MEASURES])

        return over_tiles(one, size, chosen, lambda nothing: nothing, TILE)

    def scores_of(rows: Array) -> tuple[Measures, Array]:
        measures = Measures(**dict(zip(_MEASURES, rows, strict=True)))
        return measures, score(measures, config).total

    def turn(number: Array, state: tuple[Array, Array]) -> tuple[Array, Array]:
        rows, done = state
        measures, total = scores_of(rows)
        clear = jnp.where(done & (measures.d >= 0), total, UNJUDGED)
        best = jnp.full(whole.shape, UNJUDGED, jnp.float32).at[owner].min(clear)[owner]
        promising = ~known.touched & ~(known.least > best + ROUNDING * (1 + best))
        asked = jnp.where(number == 1, promising, best >= UNJUDGED)
        asked = jnp.where(number == 0, (rank < FIRST) | whole[owner], asked) & fit & ~done
        place = jnp.where(asked, jnp.cumsum(asked.astype(jnp.int32)) - 1, size)
        lanes = jnp.zeros_like(numbers).at[place].set(numbers, mode="drop")
        found = judged(lanes, jnp.sum(asked.astype(jnp.int32)))
        found = found[:, jnp.minimum(place, size - 1)]
        return jnp.where(asked, found, rows), done | asked

    none = jnp.zeros((len(_MEASURES), size), jnp.float32), jnp.zeros(size, bool)
    rows, done = jax.lax.fori_loop(0, 3, turn, none)
    measures, total = scores_of(rows)
    scores = replace(score(measures, config), total=jnp.where(done, total, UNJUDGED))
    measures = replace(measures, d=jnp.where(known.touched & ~done, -1.0, measures.d))
    return Judged(timing=known.timing, measures=measures, scores=scores)


def _f32(value: Array | float) -> Array:
    return jnp.asarray(value, jnp.float32)
