"""The body along many walks at once: edges laid end to end, and spheres read at any time.

Arrays have the edges of a walk, or times, first and the walks after them, which is what compiled
code goes through quickest.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.body.device_tables import (
    BEND,
    FIRST,
    RANK,
    SEAM,
    SECONDS,
    STEPS,
    DeviceTables,
)
from mgjax.core.arrays import Array
from mgjax.core.xla.materialise import stage
from mgjax.core.xla.pytree import register
from mgjax.graph.types import NO_EDGE


@register()
@dataclass(frozen=True, kw_only=True)
class Edges:
    """What is needed to lay the edges of walks; padding lasts no time and goes nowhere. [L, C]

    Attributes:
        seconds: natural duration.
        turn, x, z: planar frame of the node that an edge arrives at in that of the node it leaves.
        slow_down, speed_up: 1 where its speed may be changed so, else 0.
    """

    seconds: Float[Array, "L C"]
    turn: Float[Array, "L C"]
    x: Float[Array, "L C"]
    z: Float[Array, "L C"]
    slow_down: Float[Array, "L C"]
    speed_up: Float[Array, "L C"]


@register()
@dataclass(frozen=True, kw_only=True)
class Laid:
    """Walks whose edges lie end to end, in the planar frame of the node where each begins.

    Attributes:
        edges: padded. [L, C]
        count: edges. [C]
        ends: seconds at which each edge is over; padding lies at the end and lasts no time. [L, C]
        rows: of each edge the cosine, sine, x and z of the planar frame in which it begins, the
            seconds at which it does, the factor on its duration, and its number. [L, C, 7]
    """

    edges: Int[Array, "L C"]
    count: Int[Array, " C"]
    ends: Float[Array, "L C"]
    rows: Float[Array, "L C 7"]

    @property
    def stop(self) -> Float[Array, " C"]:
        """Seconds until the last edge is over."""
        return self.ends[-1]

    def row(self, slot: Int[Array, "T C"]) -> Float[Array, "T C 7"]:
        """The row of an edge of each walk."""
        size, walks, _ = self.rows.shape
        at = slot * walks + jnp.arange(walks, dtype=jnp.int32)[None]
        return self.rows.reshape(size * walks, -1)[at]


@register()
@dataclass(frozen=True, kw_only=True)
class Between:
    """The two rows of the pool that poses lie between, and where these lie in space. [T, C]

    Attributes:
        low, high: rows of the pool.
        share: how far from the first to the second.
        here, there: cosine, sine, x and z of the planar frame of each row. [T, C, 4]
        edge, following: the edge of the walk, and the next one if there is one. [T, C]
        crosses: whether the second row belongs to the latter. [T, C]
    """

    low: Int[Array, "T C"]
    high: Int[Array, "T C"]
    share: Float[Array, "T C"]
    here: Float[Array, "T C 4"]
    there: Float[Array, "T C 4"]
    edge: Int[Array, "T C"]
    following: Int[Array, "T C"]
    crosses: Bool[Array, "T C"]


def read_edges(tables: DeviceTables, edges: Int[Array, "L C"]) -> Edges:
    """What the tables say of the edges of walks."""
    there = edges != NO_EDGE
    rows = tables.edge_rows[jnp.maximum(edges, 0)]
    columns = (jnp.where(there, rows[..., k], 0.0) for k in range(len(fields(Edges))))
    return Edges(**{field.name: x for field, x in zip(fields(Edges), columns, strict=True)})


def lay(
    tables: DeviceTables,
    edges: Int[Array, "L C"],
    read: Edges,
    scales: Float[Array, "L C"],
) -> Laid:
    """Lays the edges of walks end to end in time and space.

    Sums along the walks are products with a triangular matrix: one call each, where a loop over the
    edges would take one for every edge.
    """
    size, walks = edges.shape
    upto = jnp.asarray(np.tril(np.ones((size, size), np.float32)))
    lasts = read.seconds * scales
    sums = upto @ jnp.concatenate([lasts, read.turn], axis=1)
    ends, angle = sums[:, :walks], sums[:, walks:] - read.turn
    cosine, sine = stage(tables.there, lambda a: (jnp.cos(a), jnp.sin(a)), angle)
    x = read.x * cosine + read.z * sine
    z = read.z * cosine - read.x * sine
    sums = upto @ jnp.concatenate([x, z], axis=1)
    place = [cosine, sine, sums[:, :walks] - x, sums[:, walks:] - z]
    number = jnp.maximum(edges, 0).astype(jnp.float32)
    return Laid(
        edges=edges,
        count=jnp.sum((edges != NO_EDGE).astype(jnp.int32), axis=0),
        ends=ends,
        rows=jnp.stack([*place, ends - lasts, scales, number], axis=-1),
    )


_PLACE, BEGIN, SCALE, _EDGE = slice(0, 4), 4, 5, 6
"""Columns of :attr:`Laid.rows`."""


def find(tables: DeviceTables, laid: Laid, times: Float[Array, "T C"]) -> Between:
    """Where in the pool the poses of walks are; after its end a walk keeps its last pose."""
    size = laid.ends.shape[0]

    def slots(times: Array, ends: Array, count: Array) -> Array:
        passed = [(times >= ends[k][None]).astype(jnp.int32) for k in range(size)]
        return jnp.clip(sum(passed), 0, jnp.maximum(count[None] - 1, 0))

    slot = stage(tables.there, slots, times, laid.ends, laid.count)
    goes_on = slot + 1 < laid.count[None]
    here, after = laid.row(slot), laid.row(jnp.where(goes_on, slot + 1, slot))
    edge, following = (row[..., _EDGE].astype(jnp.int32) for row in (here, after))
    own, next_ = tables.edge_rows[edge], tables.edge_rows[following]
    steps = own[..., STEPS]
    lasts = own[..., SECONDS] * here[..., SCALE]
    position = (times - here[..., BEGIN]) * steps / jnp.maximum(lasts, 1e-6)
    position = jnp.clip(position, 0.0, steps)
    low = jnp.minimum(jnp.floor(position), steps - 1)
    crosses = (low >= steps - 1) & goes_on
    row = own[..., FIRST] + low
    return Between(
        low=row.astype(jnp.int32),
        high=jnp.where(crosses, next_[..., FIRST], row + 1).astype(jnp.int32),
        share=position - low,
        here=here[..., _PLACE],
        there=jnp.where(crosses[..., None], after[..., _PLACE], here[..., _PLACE]),
        edge=edge,
        following=following,
        crosses=crosses,
    )


def bends_at(tables: DeviceTables, where: Between) -> Float[Array, "T C"]:
    """Largest way of a sphere off the straight line between the two rows of each pose, m."""
    first = tables.edge_links[where.edge, SEAM]
    seam = tables.seam_bend[first + tables.edge_links[where.following, RANK]]
    return jnp.where(where.crosses, seam, tables.trace[where.low, BEND])


def spheres_at(tables: DeviceTables, where: Between) -> Float[Array, "3 T C S"]:
    """x, y and z of the body's spheres."""
    width = tables.radii.shape[0]

    def axes(rows: Array) -> tuple[Array, Array, Array]:
        return rows[..., :width], rows[..., width : 2 * width], rows[..., 2 * width :]

    def mixed(pool: Array, where: Between) -> Array:
        return jnp.stack(_mixed(axes(pool[where.low]), axes(pool[where.high]), where))

    return stage(tables.there, mixed, tables.pool, where)


def root_at(tables: DeviceTables, where: Between) -> tuple[Array, Array, Array]:
    """x, y and z of the root. Each [T, C]"""

    def axes(rows: Array) -> tuple[Array, Array, Array]:
        there = tables.trace[rows][..., None, :]
        return there[..., 0], there[..., 1], there[..., 2]

    x, y, z = _mixed(axes(where.low), axes(where.high), where)
    return x[..., 0], y[..., 0], z[..., 0]


def _mixed(
    low: tuple[Array, Array, Array], high: tuple[Array, Array, Array], where: Between
) -> tuple[Array, Array, Array]:
    share = where.share[..., None]
    rest = 1 - share
    c, s, dx, dz = (where.here[..., k : k + 1] * rest for k in range(4))
    c1, s1, dx1, dz1 = (where.there[..., k : k + 1] * share for k in range(4))
    x = low[0] * c + low[2] * s + high[0] * c1 + high[2] * s1 + (dx + dx1)
    z = low[2] * c - low[0] * s + high[2] * c1 - high[0] * s1 + (dz + dz1)
    return x, low[1] * rest + high[1] * share, z
