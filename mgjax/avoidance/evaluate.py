"""Many candidates judged at once: their timing, their body volume in the world, their energies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attack import Attack
from mgjax.avoidance.body_reader import BEGIN, SCALE, Laid, find, lay, read_edges, spheres_at
from mgjax.avoidance.candidates import NO_EDGE, Candidates
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.crop import Crop
from mgjax.avoidance.device_tables import (
    PART_CENTRE,
    PART_START,
    PART_STOP,
    DeviceTables,
)
from mgjax.avoidance.energy import Energies, energies_of, time_scale_energy, total_energy
from mgjax.avoidance.energy_kernel import Paths, Totals, join, no_totals, over_sphere
from mgjax.avoidance.shot import (
    CROP_END,
    CROP_START,
    EVALUATED,
    SPHERE_COUNT,
    T_ATTACK,
    Shots,
    evaluation_times,
    make_shot,
    places,
    presence,
)
from mgjax.avoidance.time_scale import OK, PADDING, Timing, time_scale
from mgjax.core.arrays import Array
from mgjax.core.padding import bucket_size
from mgjax.core.pytree import register
from mgjax.core.staging import stage

TILE = 64
"""Candidates judged together: their volumes then stay in the cache."""

SIZES = (8, 32, 128, 512, 4096)
"""Numbers of candidates that a call is compiled for; then four times as many, …"""

LONG_SIZES = (128, 4096)
"""The same for what is long, which comes seldom."""

LENGTH = 40
"""Edges of a walk that a call is compiled for, and four times as many, …"""

TIMES = 20
"""Times that are evaluated together. A ball that is quick enough for its radius to be the interval
needs no more to cross the cylinder around the body; for others the compiled code loops."""

UNLIMITED = 1e6
"""Largest time scale where the configuration sets no limit."""

_NEVER = 1 << 30


@register("shared")
@dataclass(frozen=True, kw_only=True)
class Walks:
    """Candidates as compiled code reads them.

    Attributes:
        table: edges of each walk, padded; then how many they are (0 for a candidate that is
            padding), the avoidance part at the end, and which of several attacks it is meant for.
            [L+3, C]
        shared: whether all are meant for one attack.
    """

    table: Int[Array, "L3 C"]
    shared: bool

    @property
    def edges(self) -> Int[Array, "L C"]:
        """Padded."""
        return self.table[:-3]

    @property
    def length(self) -> Int[Array, " C"]:
        """Edges."""
        return self.table[-3]

    @property
    def part(self) -> Int[Array, " C"]:
        """The avoidance part at the end."""
        return self.table[-2]

    @property
    def owner(self) -> Int[Array, " C"] | None:
        """The attack of each; None where there is but one."""
        return None if self.shared else self.table[-1]

    def rows(self, chosen: Int[Array, " K"]) -> Walks:
        """Some of them."""
        return replace(self, table=self.table[:, chosen])


def empty_walks(longest: int, count: int, *, shared: bool) -> Walks:
    """Room for walks, all of them padding."""
    table = np.full((longest + 3, count), NO_EDGE, np.int32)
    table[longest:] = 0
    return Walks(table=table, shared=shared)


@register()
@dataclass(frozen=True, kw_only=True)
class Judged:
    """What is known of each candidate. Fields are [C]; ``timing.scales`` is [L, C]."""

    timing: Timing
    energies: Energies
    timescale: Float[Array, " C"]
    total: Float[Array, " C"]


def judge_tile(
    tables: DeviceTables,
    walks: Walks,
    shots: Shots,
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Judged:
    """Timing and energies of some candidates (§4.1, §4.2)."""
    limit = jnp.asarray(config.E_time if limit_scale else UNLIMITED, dtype=jnp.float32)
    t_attack = _each(shots.number(T_ATTACK), walks)

    def begin(edges: Array, length: Array, part: Array, t_attack: Array) -> tuple:
        read = read_edges(tables, edges)
        timing = time_scale(
            read.seconds,
            read.slow_down > 0,
            read.speed_up > 0,
            length,
            tables.parts[part, PART_CENTRE],
            t_attack,
            half_frame=half_frame,
            limit=limit,
        )
        timing = replace(timing, status=jnp.where(length > 0, timing.status, PADDING))
        return timing, lay(tables, edges, read, timing.scales)

    timing, laid = stage(tables.there, begin, walks.edges, walks.length, walks.part, t_attack)
    rows = laid.row(jnp.maximum(walks.length - 1, 0)[None])[0]
    begins, scale = rows[:, BEGIN], rows[:, SCALE]
    spans = tables.parts[walks.part]
    span = (begins + spans[:, PART_START] * scale, begins + spans[:, PART_STOP] * scale)
    totals, met = _over_time(tables, walks, laid, span, shots, config)
    crop = _each(shots.number(CROP_END) - shots.number(CROP_START), walks)
    found = energies_of(totals, met, crop / (_each(shots.number(EVALUATED), walks) - 1), config)
    timescale = time_scale_energy(timing.s_time, config.E_time)
    return Judged(
        timing=timing,
        energies=found,
        timescale=timescale,
        total=total_energy(found.avoidance, found.body, timescale, config),
    )


def _each(values: Float[Array, " A"], walks: Walks) -> Float[Array, " C"]:
    """What is known of attacks, for each candidate."""
    if walks.owner is None:
        return jnp.broadcast_to(values, walks.length.shape)
    return values[walks.owner]


def _over_time(
    tables: DeviceTables,
    walks: Walks,
    laid: Laid,
    span: tuple[Array, Array],
    shots: Shots,
    config: EnergyConfig,
) -> tuple[Totals, Bool[Array, " C"]]:
    """e'/Δt, d and d0 of candidates over the evaluated times, and whether their attack is there.

    ``TIMES`` moments at a time; each lot begins with the last moment of the lot before, so that
    nothing between them is left out.
    """
    count = walks.length.shape[0]
    start, stop = (x[None] for x in span)
    number = _each(shots.number(EVALUATED), walks)[None]
    frozen_from = _first_within(walks, shots, span)[None]

    def of_walks(values: Array) -> Array:
        """[T, A, …] of attacks to [T, C, …]; [T, 1, …] where there is but one."""
        return values if walks.owner is None else values[:, walks.owner]

    def lot(k: Array, known: tuple[Totals, Array]) -> tuple[Totals, Array]:
        first = k * (TIMES - 1)
        index = first + jnp.arange(TIMES, dtype=jnp.int32)
        own_times = evaluation_times(shots, index)
        centres = of_walks(places(shots, own_times))
        present = of_walks(presence(shots, own_times))
        times = jnp.broadcast_to(of_walks(own_times), (TIMES, count))
        # The pose at the start of the part is one more time.
        where = find(tables, laid, jnp.concatenate([times, start]))
        body = spheres_at(tables, where)
        counts = index[:, None].astype(jnp.float32) < number
        active = counts & (times <= laid.stop[None])
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
        found = _over_spheres(paths, centres, of_radii(shots), present, spheres, config)
        met = met | jnp.any(active & jnp.any(present, axis=-1), axis=0)
        return join(totals, found), met

    def of_radii(shots: Shots) -> Float[Array, "A I"]:
        return shots.spheres[:, 0] if walks.owner is None else shots.spheres[walks.owner, 0]

    spheres = jnp.max(shots.number(SPHERE_COUNT)).astype(jnp.int32)
    lots = jnp.ceil((jnp.max(shots.number(EVALUATED)) - 1) / (TIMES - 1)).astype(jnp.int32)
    none = no_totals(count), jnp.zeros(count, bool)
    return jax.lax.fori_loop(0, lots, lot, none)


def _over_spheres(
    paths: Paths,
    centres: Float[Array, "T A D"],
    radii: Float[Array, "A I"],
    present: Bool[Array, "T A I"],
    count: Int[Array, ""],
    config: EnergyConfig,
) -> Totals:
    """The same over all spheres of the attacks, of which ``count`` are no padding."""
    slots = radii.shape[1]
    apart = jnp.moveaxis(centres.reshape(*centres.shape[:2], slots, 3), (2, 3), (0, 1))

    def one(sphere: Array, radius: Array, there: Array) -> Totals:
        return over_sphere(config.form, True, paths, sphere, radius, there)

    if slots == 1:
        return one(apart[0], radii[:, 0], present[..., 0])

    def step(k: Array, known: Totals) -> Totals:
        return join(known, one(apart[k], radii[:, k], present[..., k]))

    return jax.lax.fori_loop(0, count, step, no_totals(paths.active.shape[1]))


def _first_within(walks: Walks, shots: Shots, span: tuple[Array, Array]) -> Int[Array, " C"]:
    """Number of the first evaluated time within the avoidance part; never where there is none."""
    begin, end, count = (_each(shots.number(k), walks) for k in (CROP_START, CROP_END, EVALUATED))
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


def judge_all(
    tables: DeviceTables,
    walks: Walks,
    shots: Shots,
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Judged:
    """The same for any number of candidates: up to a tile, or a multiple of one.

    Tiles without candidates are left out, so large arrays of few candidates cost little.
    """
    one = partial(
        judge_tile,
        tables,
        shots=shots,
        config=config,
        half_frame=half_frame,
        limit_scale=limit_scale,
    )
    count = walks.length.shape[0]
    if count <= TILE:
        return one(walks)

    def cut(tile: Array | int) -> Walks:
        return jax.tree.map(
            lambda x: jax.lax.dynamic_slice_in_dim(x, tile * TILE, TILE, axis=x.ndim - 1), walks
        )

    shapes = jax.eval_shape(one, jax.eval_shape(cut, 0))
    nothing = jax.tree.map(lambda x: jnp.zeros((*x.shape[:-1], count), x.dtype), shapes)
    status = jnp.full_like(walks.length, PADDING)
    nothing = replace(nothing, timing=replace(nothing.timing, status=status))

    def step(tile: Array, found: Judged) -> Judged:
        return jax.tree.map(
            lambda whole, part: jax.lax.dynamic_update_slice_in_dim(
                whole, part, tile * TILE, axis=whole.ndim - 1
            ),
            found,
            one(cut(tile)),
        )

    tiles = (jnp.sum((walks.length > 0).astype(jnp.int32)) + TILE - 1) // TILE
    return jax.lax.fori_loop(0, tiles, step, nothing)


def ranking(judged: Judged, owner: Int[Array, " C"] | None = None) -> Int[Array, " C"]:
    """Candidates in the order of their energy; those that seem to be hit after them, then the rest.

    The volumes that rank are samples, so a small penetration there is not yet a hit: such
    candidates follow, the least touched first, and the exact check decides on all. Last are those
    that cannot be timed. Ties go to the lower number. With an ``owner`` they are ordered by that
    first.
    """
    d = judged.energies.d
    value = jnp.where(d < 0, -d, judged.total) + 0.0
    # Numbers that are not negative are in the order of their bits.
    bits = jax.lax.bitcast_convert_type(value, jnp.uint32)
    key = jnp.where(d < 0, bits | jnp.uint32(1 << 31), bits)
    key = jnp.where(judged.timing.status == OK, key, jnp.uint32(0xFFFFFFFF))
    return jnp.argsort(key) if owner is None else jnp.lexsort((key, owner))


_judge = jax.jit(judge_all, static_argnames=("half_frame", "limit_scale"))


def pad_candidates(candidates: Candidates, *, long: bool = False) -> Walks:
    """Candidates padded to few sizes; to larger ones if their attack is ``long``."""
    count, longest = len(candidates.length), int(candidates.length.max(initial=1))
    sizes = LONG_SIZES if long else SIZES
    size = next((s for s in sizes if count <= s), 0) or bucket_size(count, sizes[-1], 4)
    edges = bucket_size(max(longest, LENGTH + 1 if long else 0), LENGTH, 4)
    walks = empty_walks(edges, size, shared=True)
    table = walks.table
    table[:longest, :count] = candidates.edges[:, :longest].T
    table[-3, :count], table[-2, :count] = candidates.length, candidates.part
    return walks


def judge(
    device: DeviceTables,
    candidates: Candidates,
    attack: Attack,
    crop: Crop,
    config: AvoidanceConfig,
    *,
    frame_rate: float,
) -> dict[str, np.ndarray]:
    """Energies and timing of all candidates, as NumPy arrays by name; ``order`` ranks them.

    The attack is in the planar frame of the node at which the walks begin, and time counts from
    there. Shapes are padded to a few sizes, so that attacks do not compile anew.
    """
    judged = _judge(
        device,
        pad_candidates(candidates),
        make_shot(attack, crop, config, 0.0),
        config.energy,
        half_frame=0.5 / frame_rate,
        limit_scale=config.limit_scale,
    )
    count = len(candidates.length)
    found = {name: np.asarray(value)[..., :count] for name, value in by_name(judged).items()}
    found["scales"] = found["scales"].T
    usable = found["status"] == OK
    d = found["d"]
    keys = (np.where(d < 0, -d, found["total"]), d < 0, ~usable)
    found["order"] = np.lexsort(keys)[: int(usable.sum())]
    return found


def by_name(judged: Judged) -> dict[str, Array]:
    """All fields."""
    return {
        "s_time": judged.timing.s_time,
        "scales": judged.timing.scales,
        "status": judged.timing.status,
        "avoidance": judged.energies.avoidance,
        "body": judged.energies.body,
        "penetration": judged.energies.penetration,
        "d": judged.energies.d,
        "d0": judged.energies.d0,
        "timescale": judged.timescale,
        "total": judged.total,
    }
