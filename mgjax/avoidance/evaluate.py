"""Many candidates judged at once: their timing, their body volume in the world, their energies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attack import Attack, Crop
from mgjax.avoidance.body_reader import find, is_over, lay, spheres_at
from mgjax.avoidance.candidates import NO_EDGE, Candidates
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.device_tables import DeviceTables
from mgjax.avoidance.energy import Energies, energies_batch, time_scale_energy, total_energy
from mgjax.avoidance.time_scale import OK, PADDING, Timing, time_scale
from mgjax.core.arrays import Array
from mgjax.core.padding import bucket_size, pad_axis
from mgjax.core.pytree import register

TILE = 128
"""Candidates judged together: their volumes then stay in the cache."""

SIZES = (8, 32, 64, TILE)
"""Numbers of candidates that a call is compiled for; then 1024, 4096, …"""

LENGTH = 48
"""Edges of a walk that a call is compiled for, and twice as many, …"""

TIMES = 24
"""Times that a call is compiled for, and four times as many, …"""

SPHERES = 1
"""Spheres of an attack that a call is compiled for, and eight times as many, …"""

UNLIMITED = 1e6
"""Largest time scale where the configuration sets no limit."""


@register()
@dataclass(frozen=True, kw_only=True)
class Problem:
    """An attack as the search reads it, at evenly spaced times; time counts from the walk's start.

    Attributes:
        t_attack: the time of the attack, s.
        times, active: evaluated times, and which of them count. [T]
        centres: of the attack's spheres, m. [3, T, I]
        present: which spheres are there. [T, I]
        radii: m. [I]
        dt: interval of the times, s.
    """

    t_attack: Float[Array, ""]
    times: Float[Array, " T"]
    active: Bool[Array, " T"]
    centres: Float[Array, "3 T I"]
    present: Bool[Array, "T I"]
    radii: Float[Array, " I"]
    dt: Float[Array, ""]


@register()
@dataclass(frozen=True, kw_only=True)
class Judged:
    """What is known of each candidate. Fields are [C], those of ``timing`` also [C, L]."""

    timing: Timing
    energies: Energies
    timescale: Float[Array, " C"]
    total: Float[Array, " C"]


def judge_tile(
    tables: DeviceTables,
    edges: Int[Array, "C L"],
    length: Int[Array, " C"],
    part: Int[Array, " C"],
    problem: Problem,
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Judged:
    """Timing and energies of some candidates (§4.1, §4.2); ``length`` 0 is padding."""
    inside = jnp.maximum(edges, 0)
    limit = jnp.asarray(config.E_time if limit_scale else UNLIMITED, dtype=jnp.float32)
    timing = jax.vmap(
        partial(time_scale, half_frame=half_frame, limit=limit), in_axes=(0, 0, 0, 0, 0, None)
    )(
        tables.seconds[inside],
        tables.slow_down[inside],
        tables.speed_up[inside],
        length,
        tables.part_centre[part],
        problem.t_attack,
    )
    timing = replace(timing, status=jnp.where(length > 0, timing.status, PADDING))
    laid = lay(tables, edges, timing.scales)
    last = jnp.maximum(length - 1, 0)
    rows = jnp.arange(edges.shape[0])
    begin, scale = laid.begins[rows, last], timing.scales[rows, last]
    t0 = (begin + tables.part_start[part] * scale)[None]
    t1 = (begin + tables.part_stop[part] * scale)[None]
    times = jnp.broadcast_to(problem.times[:, None], (problem.times.shape[0], edges.shape[0]))
    # The pose at t0 is one more time.
    where = find(tables, laid, jnp.concatenate([times, t0]))
    body = jnp.stack(spheres_at(tables, where))
    found = energies_batch(
        problem.centres,
        problem.radii,
        body[:, :-1],
        tables.radii,
        body[:, -1],
        (times >= t0) & (times < t1),
        problem.active[:, None] & ~is_over(laid, times),
        dt=problem.dt,
        config=config,
        attack_present=problem.present,
    )
    timescale = time_scale_energy(timing.s_time, config.E_time)
    return Judged(
        timing=timing,
        energies=found,
        timescale=timescale,
        total=total_energy(found.avoidance, found.body, timescale, config),
    )


def judge_all(
    tables: DeviceTables,
    edges: Int[Array, "C L"],
    length: Int[Array, " C"],
    part: Int[Array, " C"],
    problem: Problem,
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Judged:
    """The same for any number of candidates: up to a tile, or a multiple of one.

    Tiles without candidates are left out, so a large array of few candidates costs little.
    """
    one = partial(
        judge_tile,
        tables,
        problem=problem,
        config=config,
        half_frame=half_frame,
        limit_scale=limit_scale,
    )
    if len(edges) <= TILE:
        return one(edges, length, part)
    nothing = jax.tree.map(
        lambda x: jnp.zeros((len(edges), *x.shape[1:]), x.dtype),
        jax.eval_shape(one, edges[:TILE], length[:TILE], part[:TILE]),
    )
    nothing = replace(
        nothing, timing=replace(nothing.timing, status=jnp.full_like(length, PADDING))
    )

    def step(tile: Array, found: Judged) -> Judged:
        cut = [jax.lax.dynamic_slice_in_dim(x, tile * TILE, TILE) for x in (edges, length, part)]
        return jax.tree.map(
            lambda whole, part: jax.lax.dynamic_update_slice_in_dim(whole, part, tile * TILE, 0),
            found,
            one(*cut),
        )

    tiles = (jnp.sum((length > 0).astype(jnp.int32)) + TILE - 1) // TILE
    return jax.lax.fori_loop(0, tiles, step, nothing)


def ranking(judged: Judged) -> Int[Array, " C"]:
    """Candidates in the order of their energy; those that seem to be hit after them, then the rest.

    The volumes that rank are samples, so a small penetration there is not yet a hit: such
    candidates follow, the least touched first, and the exact check decides on all. Last are those
    that cannot be timed. Ties go to the lower number.
    """
    d = judged.energies.d
    usable = judged.timing.status == OK
    group = jnp.where(usable, jnp.where(d < 0, 1, 0), 2)
    return jnp.lexsort((jnp.where(d < 0, -d, judged.total), group))


_judge = jax.jit(judge_all, static_argnames=("half_frame", "limit_scale"))


def evaluation_times(attack: Attack, crop: Crop, config: AvoidanceConfig) -> np.ndarray:
    """Evenly spaced times over the crop, at most min(1/20 s, radius / speed) apart (§4.2)."""
    quickest = float(attack.radii.min()) / max(attack.largest_speed, 1e-6)
    step = min(config.evaluation_step_s, quickest)
    count = int(np.ceil((crop.end - crop.start) / step)) + 1
    return np.linspace(crop.start, crop.end, max(count, 2))


def make_problem(attack: Attack, crop: Crop, config: AvoidanceConfig) -> Problem:
    """The attack at the evaluated times, padded to one of few sizes."""
    times = evaluation_times(attack, crop, config)
    size = bucket_size(len(times), TIMES, 4)
    # Padded by the last time: the same places, and not active.
    padded = np.full(size, times[-1])
    padded[: len(times)] = times
    centres, present, radii = padded_spheres(attack, padded)
    return Problem(
        t_attack=np.asarray(crop.middle, dtype=np.float32),
        times=padded.astype(np.float32),
        active=np.arange(size) < len(times),
        centres=centres,
        present=present,
        radii=radii,
        dt=np.asarray(times[1] - times[0], dtype=np.float32),
    )


def padded_spheres(
    attack: Attack, times: Float[np.ndarray, " T"]
) -> tuple[Float[np.ndarray, "3 T I"], Bool[np.ndarray, "T I"], Float[np.ndarray, " I"]]:
    """Places, presence and radii of an attack's spheres; those that pad are never there."""
    spheres = bucket_size(len(attack.radii), SPHERES, 8)
    centres = np.moveaxis(attack.at(times), -1, 0).astype(np.float32)
    present, radii = attack.active(times), attack.radii.astype(np.float32)
    if spheres == len(radii):
        return np.ascontiguousarray(centres), present, radii
    return (
        pad_axis(centres, spheres, axis=2),
        pad_axis(present, spheres, axis=1, value=False),
        pad_axis(radii, spheres),
    )


def pad_candidates(candidates: Candidates) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges, lengths and parts, padded to few sizes; a padded candidate has no edges."""
    count, longest = candidates.edges.shape
    size = next((s for s in SIZES if count <= s), 0) or bucket_size(count, 8 * TILE, 4)
    edges = np.full((size, bucket_size(longest, LENGTH)), NO_EDGE, np.int32)
    edges[:count, :longest] = candidates.edges
    length, part = np.zeros(size, np.int32), np.zeros(size, np.int32)
    length[:count], part[:count] = candidates.length, candidates.part
    return edges, length, part


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
        *pad_candidates(candidates),
        make_problem(attack, crop, config),
        config.energy,
        half_frame=0.5 / frame_rate,
        limit_scale=config.limit_scale,
    )
    count = len(candidates.length)
    found = {name: np.asarray(value)[:count] for name, value in by_name(judged).items()}
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
