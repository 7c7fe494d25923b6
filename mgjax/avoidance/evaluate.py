"""Many candidates judged at once: their timing, their body volume in the world, their energies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.attack import Attack, Crop
from mgjax.avoidance.candidates import NO_EDGE, Candidates
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig, SpeedConfig
from mgjax.avoidance.energy import Energies, energies_batch, time_scale_energy, total_energy
from mgjax.avoidance.tables import EdgeTables, speed_classes
from mgjax.avoidance.time_scale import Timing, time_scale
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.padding import bucket_size, pad_axis
from mgjax.core.pytree import register

TILE = 128
"""Candidates judged in one call: their volumes then stay in the cache."""


@register()
@dataclass(frozen=True, kw_only=True)
class Judged:
    """What is known of each candidate. Fields are [C]; ``scales`` is [C, L]."""

    timing: Timing
    energies: Energies
    timescale: Float[Array, " C"]
    total: Float[Array, " C"]


@register()
@dataclass(frozen=True, kw_only=True)
class DeviceTables:
    """The part of :class:`EdgeTables` that the jitted search reads."""

    seconds: Float[Array, " E"]
    step: Float[Array, "E 3"]
    pool: Float[Array, "P K"]
    pool_first: Int[Array, " E"]
    pool_steps: Int[Array, " E"]
    slow_down: Bool[Array, " E"]
    speed_up: Bool[Array, " E"]
    part_start: Float[Array, " A"]
    part_stop: Float[Array, " A"]
    part_centre: Float[Array, " A"]
    radii: Float[Array, " S"]


def device_tables(tables: EdgeTables, speed: SpeedConfig) -> DeviceTables:
    """Puts the tables into jax arrays of 32 bits, padded so that few graphs compile anew."""
    slow_down, speed_up = speed_classes(tables.top_speed, speed)

    def padded(x: np.ndarray, kind: type, least: int) -> jax.Array:
        return jnp.asarray(pad_axis(x.astype(kind), bucket_size(len(x), least), value=0))

    edges = {
        "seconds": (tables.seconds, np.float32),
        "step": (tables.step, np.float32),
        "pool_first": (tables.pool_first, np.int32),
        "pool_steps": (tables.pool_steps, np.int32),
        "slow_down": (slow_down, np.bool_),
        "speed_up": (speed_up, np.bool_),
    }
    parts = {
        "part_start": tables.part_start,
        "part_stop": tables.part_stop,
        "part_centre": tables.part_centre,
    }
    return DeviceTables(
        pool=padded(tables.pool, np.float32, 1 << 15),
        radii=jnp.asarray(tables.spheres.radii, dtype=jnp.float32),
        **{name: padded(x, kind, 1 << 12) for name, (x, kind) in edges.items()},
        **{name: padded(x, np.float32, 128) for name, x in parts.items()},
    )


@partial(jax.jit, static_argnames=("half_frame", "limit_scale"))
def _judge(
    tables: DeviceTables,
    edges: Int[Array, "C L"],
    length: Int[Array, " C"],
    part: Int[Array, " C"],
    t_attack: Float[Array, ""],
    times: Float[Array, " T"],
    active: Bool[Array, " T"],
    attack_centres: Float[Array, "3 T I"],
    attack_radii: Float[Array, " I"],
    dt: Float[Array, ""],
    config: EnergyConfig,
    *,
    half_frame: float,
    limit_scale: bool,
) -> Judged:
    inside = jnp.maximum(edges, 0)
    limit = jnp.asarray(config.E_time if limit_scale else 1e6, dtype=jnp.float32)
    timing = jax.vmap(
        partial(time_scale, half_frame=half_frame, limit=limit), in_axes=(0, 0, 0, 0, 0, None)
    )(
        tables.seconds[inside],
        tables.slow_down[inside],
        tables.speed_up[inside],
        length,
        tables.part_centre[part],
        t_attack,
    )
    lasts = jnp.where(edges == NO_EDGE, 0.0, tables.seconds[inside] * timing.scales)
    ends = jnp.cumsum(lasts, axis=1)
    begins = ends - lasts
    places = _chain(jnp.where((edges == NO_EDGE)[..., None], 0.0, tables.step[inside]))
    rows = jnp.arange(edges.shape[0])
    last = length - 1
    t0 = begins[rows, last] + tables.part_start[part] * timing.scales[rows, last]
    t1 = begins[rows, last] + tables.part_stop[part] * timing.scales[rows, last]
    read = partial(_body, tables, edges, timing.scales, begins, ends, places)
    body = read(times[:, None])
    start = read(t0[None, :])[:, 0]
    walking = times[:, None] <= ends[rows, last][None, :]
    found = energies_batch(
        attack_centres,
        attack_radii,
        body,
        tables.radii,
        start,
        (times[:, None] >= t0[None, :]) & (times[:, None] < t1[None, :]),
        active[:, None] & walking,
        dt=dt,
        config=config,
    )
    timescale = time_scale_energy(timing.s_time, config.E_time)
    return Judged(
        timing=timing,
        energies=found,
        timescale=timescale,
        total=total_energy(found.avoidance, found.body, timescale, config),
    )


def _chain(steps: Float[Array, "C L 3"]) -> Float[Array, "C L 3"]:
    """Planar frame at the beginning of each edge, in the frame of the first node."""
    return jax.lax.associative_scan(
        planar.compose,
        jnp.concatenate([jnp.zeros_like(steps[:, :1]), steps[:, :-1]], axis=1),
        axis=1,
    )


def _body(
    tables: DeviceTables,
    edges: Int[Array, "C L"],
    scales: Float[Array, "C L"],
    begins: Float[Array, "C L"],
    ends: Float[Array, "C L"],
    places: Float[Array, "C L 3"],
    times: Float[Array, "T C1"],
) -> Float[Array, "3 T S C"]:
    """Sphere centres of each candidate at times on its path; its last pose is held after it."""
    count, longest = edges.shape
    when = jnp.broadcast_to(times, (times.shape[0], count))
    slot = jnp.sum(when[..., None] >= ends[None], axis=-1)
    slot = jnp.minimum(slot, jnp.sum(edges != NO_EDGE, axis=1)[None] - 1)
    slot = jnp.clip(slot, 0, longest - 1)
    candidate = jnp.arange(count)[None, :]
    edge = jnp.maximum(edges[candidate, slot], 0)
    natural = (when - begins[candidate, slot]) / scales[candidate, slot]
    steps = tables.pool_steps[edge]
    position = natural / jnp.maximum(tables.seconds[edge], 1e-6) * steps.astype(jnp.float32)
    position = jnp.clip(position, 0.0, steps.astype(jnp.float32))
    low = jnp.minimum(position.astype(jnp.int32), steps - 1)
    share = (position - low.astype(jnp.float32))[..., None]
    row = tables.pool_first[edge] + low
    local = tables.pool[row] * (1 - share) + tables.pool[row + 1] * share
    local = jnp.moveaxis(local, -1, 0).reshape(3, -1, *when.shape)  # [3, S, T, C]
    place = places[candidate, slot]
    c, s = jnp.cos(place[..., 0])[None], jnp.sin(place[..., 0])[None]
    x, y, z = local
    world = jnp.stack([x * c + z * s + place[None, ..., 1], y, z * c - x * s + place[None, ..., 2]])
    return jnp.moveaxis(world, 1, 2)


def evaluation_times(attack: Attack, crop: Crop, config: AvoidanceConfig) -> np.ndarray:
    """Evenly spaced times over the crop, at most min(1/20 s, radius / speed) apart (§4.2)."""
    quickest = float(attack.radii.min()) / max(attack.largest_speed(), 1e-6)
    step = min(config.evaluation_step_s, quickest)
    count = int(np.ceil((crop.end - crop.start) / step)) + 1
    return np.linspace(crop.start, crop.end, max(count, 2))


def judge(
    tables: EdgeTables,
    device: DeviceTables,
    candidates: Candidates,
    attack: Attack,
    crop: Crop,
    config: AvoidanceConfig,
    *,
    frame_rate: float,
) -> dict[str, np.ndarray]:
    """Energies and timing of all candidates, as NumPy arrays by name.

    The attack is in the planar frame of the node at which the walks begin, and time counts from
    there. Shapes are padded to a few sizes, so that attacks do not compile anew.
    """
    times = evaluation_times(attack, crop, config)
    # Few sizes: every combination of them is compiled once.
    size = bucket_size(len(times), 24)
    active = np.arange(size) < len(times)
    centres = np.moveaxis(attack.at(times), -1, 0)
    padded = pad_axis(centres, size, axis=1).astype(np.float32)
    longest = bucket_size(candidates.edges.shape[1], 16, 4)
    edges = pad_axis(candidates.edges, longest, axis=1, value=NO_EDGE).astype(np.int32)
    count = len(edges)
    tile = min(bucket_size(count, 16, 8), TILE)
    parts: list[dict[str, np.ndarray]] = []
    for first in range(0, count, tile):
        chunk = [
            pad_axis(x[first : first + tile].astype(np.int32), tile)
            for x in (edges, candidates.length, candidates.part)
        ]
        judged = _judge(
            device,
            *chunk,
            np.float32(crop.middle),
            pad_axis(times, size).astype(np.float32),
            active,
            padded,
            attack.radii.astype(np.float32),
            np.float32(times[1] - times[0]),
            config.energy,
            half_frame=0.5 / frame_rate,
            limit_scale=config.limit_scale,
        )
        parts.append(_flatten(judged))
    return {name: np.concatenate([p[name] for p in parts])[:count] for name in parts[0]}


def _flatten(judged: Judged) -> dict[str, np.ndarray]:
    values = {
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
    return {name: np.asarray(value) for name, value in values.items()}
