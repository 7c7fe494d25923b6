"""The body along many walks at once: edges laid end to end, and spheres read at any time."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.candidates import NO_EDGE
from mgjax.avoidance.device_tables import DeviceTables
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.pytree import register

_BEGIN, _RATE, _STEPS, _FIRST, _PLACE, _NEXT, _NEXT_PLACE, _SEAM = 0, 1, 2, 3, 4, 8, 9, 13
"""Columns of :attr:`Laid.slots`; a place has four: cosine, sine, x, z."""


@register()
@dataclass(frozen=True, kw_only=True)
class Laid:
    """Walks whose edges lie end to end, in the planar frame of the node where each begins.

    Attributes:
        begins, ends: seconds of each edge; padding lies at the end and lasts no time. [C, L]
        stop: seconds until the last edge is over. [C]
        count: edges. [C]
        slots: what is needed to read a pose, in one row per edge. [C, L, 14]
    """

    begins: Float[Array, "C L"]
    ends: Float[Array, "C L"]
    stop: Float[Array, " C"]
    count: Int[Array, " C"]
    slots: Float[Array, "C L 14"]


@register()
@dataclass(frozen=True, kw_only=True)
class Between:
    """The two rows of the pool that a pose lies between, and their weights. [T, C]

    ``turn`` has the weighted cosines and sines of the two places, ``shift`` the weighted x and z.
    """

    low: Int[Array, "T C"]
    high: Int[Array, "T C"]
    share: Float[Array, "T C"]
    turn: tuple[Array, Array, Array, Array]
    shift: tuple[Array, Array]
    bend: Float[Array, "T C"]


def lay(tables: DeviceTables, edges: Int[Array, "C L"], scales: Float[Array, "C L"]) -> Laid:
    """Lays the edges of walks end to end in time and space."""
    inside = jnp.maximum(edges, 0)
    there = edges != NO_EDGE
    seconds = tables.seconds[inside]
    lasts = jnp.where(there, seconds * scales, 0.0)
    ends = jnp.cumsum(lasts, axis=1)
    places = _chain(jnp.where(there[..., None], tables.step[inside], 0.0))
    turned = jnp.concatenate(
        [jnp.cos(places[..., :1]), jnp.sin(places[..., :1]), places[..., 1:]], axis=-1
    )
    steps, first = tables.pool_steps[inside], tables.pool_first[inside]
    # A row past the last edge: its final pose, in its own place.
    follows = jnp.concatenate([there[:, 1:], jnp.zeros_like(there[:, :1])], axis=1)
    following = jnp.roll(inside, -1, axis=1)
    next_first = jnp.where(follows, tables.pool_first[following], first + steps)
    next_place = jnp.where(follows[..., None], jnp.roll(turned, -1, axis=1), turned)
    seam = tables.seam_bend[tables.seam_first[inside] + tables.rank[following]]
    columns = [
        ends - lasts,
        steps.astype(jnp.float32) / jnp.maximum(seconds * scales, 1e-6),
        steps.astype(jnp.float32),
        first.astype(jnp.float32),
        *jnp.moveaxis(turned, -1, 0),
        next_first.astype(jnp.float32),
        *jnp.moveaxis(next_place, -1, 0),
        jnp.where(follows, seam, tables.bend[first + steps - 1]),
    ]
    return Laid(
        begins=ends - lasts,
        ends=ends,
        stop=ends[:, -1],
        count=jnp.sum(there, axis=1),
        slots=jnp.stack(columns, axis=-1),
    )


def _chain(steps: Float[Array, "C L 3"]) -> Float[Array, "C L 3"]:
    """Planar frame at the beginning of each edge, in the frame of the first node."""

    def step(here: Array, move: Array) -> tuple[Array, Array]:
        return planar.compose(here, move), here

    _, places = jax.lax.scan(step, jnp.zeros_like(steps[:, 0]), jnp.moveaxis(steps, 1, 0))
    return jnp.moveaxis(places, 0, 1)


def find(tables: DeviceTables, laid: Laid, times: Float[Array, "T C"]) -> Between:
    """Where in the pool the poses of walks are; after its end a walk keeps its last pose."""
    slot = jnp.sum((times[..., None] >= laid.ends[None]).astype(jnp.int32), axis=-1)
    slot = jnp.minimum(slot, laid.count[None] - 1)
    row = laid.slots[jnp.arange(times.shape[1])[None], slot]
    column = [row[..., k] for k in range(14)]
    steps = column[_STEPS]
    position = jnp.clip((times - column[_BEGIN]) * column[_RATE], 0.0, steps)
    low = jnp.minimum(jnp.floor(position), steps - 1)
    share = position - low
    crosses = low >= steps - 1
    here, there = column[_PLACE : _PLACE + 4], column[_NEXT_PLACE : _NEXT_PLACE + 4]
    other = [jnp.where(crosses, b, a) for a, b in zip(here, there, strict=True)]
    rest = 1 - share
    row_low = (column[_FIRST] + low).astype(jnp.int32)
    row_high = jnp.where(crosses, column[_NEXT].astype(jnp.int32), row_low + 1)
    return Between(
        low=row_low,
        high=row_high,
        share=share,
        turn=(rest * here[0], rest * here[1], share * other[0], share * other[1]),
        shift=(rest * here[2] + share * other[2], rest * here[3] + share * other[3]),
        bend=jnp.where(crosses, column[_SEAM], tables.bend[row_low]),
    )


def spheres_at(tables: DeviceTables, where: Between) -> tuple[Array, Array, Array]:
    """x, y and z of the body's spheres. Each [T, C, S]"""
    width = tables.radii.shape[0]

    def axes(rows: Array) -> tuple[Array, Array, Array]:
        return rows[..., :width], rows[..., width : 2 * width], rows[..., 2 * width :]

    return _mixed(axes(tables.pool[where.low]), axes(tables.pool[where.high]), where)


def root_at(tables: DeviceTables, where: Between) -> tuple[Array, Array, Array]:
    """x, y and z of the root. Each [T, C, 1]"""
    columns = [k * tables.radii.shape[0] + tables.root_column for k in range(3)]

    def axes(rows: Array) -> tuple[Array, Array, Array]:
        x, y, z = (tables.pool[rows, column][..., None] for column in columns)
        return x, y, z

    return _mixed(axes(where.low), axes(where.high), where)


def _mixed(
    low: tuple[Array, Array, Array], high: tuple[Array, Array, Array], where: Between
) -> tuple[Array, Array, Array]:
    c, s, c1, s1 = (w[..., None] for w in where.turn)
    dx, dz = (w[..., None] for w in where.shift)
    share = where.share[..., None]
    x = low[0] * c + low[2] * s + high[0] * c1 + high[2] * s1 + dx
    z = low[2] * c - low[0] * s + high[2] * c1 - high[0] * s1 + dz
    return x, low[1] * (1 - share) + high[1] * share, z


def is_over(laid: Laid, times: Float[Array, "T C"]) -> Bool[Array, "T C"]:
    """Whether a walk is over."""
    return times > laid.stop[None]
