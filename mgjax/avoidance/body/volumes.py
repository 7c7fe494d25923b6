"""The body along many walks at once: edges placed end to end, and spheres read at any time.

Arrays have the edges of a walk, or times, first and the walks after them, which is what compiled
code goes through quickest.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.body.device_tables import (
    DeviceTables,
    EdgeColumn,
    LinkColumn,
    RootColumn,
)
from mgjax.core.arrays import Array
from mgjax.core.xla.materialise import stage
from mgjax.core.xla.pytree import register
from mgjax.graph.types import NO_EDGE


@register()
@dataclass(frozen=True, kw_only=True)
class Edges:
    """What is needed to place the edges of walks; padding lasts no time and goes nowhere. [L, C]

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
class PlacedEdges:
    """Walks whose edges lie end to end, in the planar frame of the node where each begins.

    Attributes:
        edges: padded. [L, C]
        count: edges. [C]
        ends: seconds at which each edge is over; padding lies at the end and lasts no time. [L, C]
        rows: what is known of each edge, see :class:`PlacedColumn`. [L, C, 7]
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


class PlacedColumn(IntEnum):
    """Columns of :attr:`PlacedEdges.rows`.

    Cosine, sine, x and z of the planar frame in which the edge begins, the seconds at which it
    does, the factor on its duration, and its number.
    """

    COSINE = 0
    SINE = 1
    X = 2
    Z = 3
    BEGIN = 4
    SCALE = 5
    EDGE = 6


_FRAME = slice(PlacedColumn.COSINE, PlacedColumn.Z + 1)


@register()
@dataclass(frozen=True, kw_only=True)
class Keyframes:
    """The two rows of the pool that poses lie between, and where these lie in space. [T, C]

    Attributes:
        low, high: rows of the pool.
        share: how far from the first to the second.
        low_frame, high_frame: cosine, sine, x and z of the planar frame of each row. [T, C, 4]
        edge, following: the edge of the walk, and the next one if there is one. [T, C]
        crosses: whether the second row belongs to the latter. [T, C]
    """

    low: Int[Array, "T C"]
    high: Int[Array, "T C"]
    share: Float[Array, "T C"]
    low_frame: Float[Array, "T C 4"]
    high_frame: Float[Array, "T C 4"]
    edge: Int[Array, "T C"]
    following: Int[Array, "T C"]
    crosses: Bool[Array, "T C"]


def read_edges(tables: DeviceTables, edges: Int[Array, "L C"]) -> Edges:
    """What the tables say of the edges of walks."""
    real = edges != NO_EDGE
    rows = tables.edge_rows[jnp.maximum(edges, 0)]
    columns = (jnp.where(real, rows[..., k], 0.0) for k in range(len(fields(Edges))))
    return Edges(**{field.name: x for field, x in zip(fields(Edges), columns, strict=True)})


def chain_transforms(
    tables: DeviceTables,
    edges: Int[Array, "L C"],
    read: Edges,
    scales: Float[Array, "L C"],
) -> PlacedEdges:
    """Places the edges of walks end to end in time and space, by chaining their planar steps.

    Sums along the walks are products with a triangular matrix: one call each, where a loop over the
    edges would take one for every edge.
    """
    size, walks = edges.shape
    upto = jnp.asarray(np.tril(np.ones((size, size), np.float32)))
    durations = read.seconds * scales
    sums = upto @ jnp.concatenate([durations, read.turn], axis=1)
    ends, angle = sums[:, :walks], sums[:, walks:] - read.turn
    cosine, sine = stage(tables.opaque_true, lambda a: (jnp.cos(a), jnp.sin(a)), angle)
    x = read.x * cosine + read.z * sine
    z = read.z * cosine - read.x * sine
    sums = upto @ jnp.concatenate([x, z], axis=1)
    place = [cosine, sine, sums[:, :walks] - x, sums[:, walks:] - z]
    number = jnp.maximum(edges, 0).astype(jnp.float32)
    return PlacedEdges(
        edges=edges,
        count=jnp.sum((edges != NO_EDGE).astype(jnp.int32), axis=0),
        ends=ends,
        rows=jnp.stack([*place, ends - durations, scales, number], axis=-1),
    )


def locate(tables: DeviceTables, placed: PlacedEdges, times: Float[Array, "T C"]) -> Keyframes:
    """Where in the pool the poses of walks are; after its end a walk keeps its last pose."""
    size = placed.ends.shape[0]

    def slots(times: Array, ends: Array, count: Array) -> Array:
        passed = [(times >= ends[k][None]).astype(jnp.int32) for k in range(size)]
        return jnp.clip(sum(passed), 0, jnp.maximum(count[None] - 1, 0))

    slot = stage(tables.opaque_true, slots, times, placed.ends, placed.count)
    goes_on = slot + 1 < placed.count[None]
    current, after = placed.row(slot), placed.row(jnp.where(goes_on, slot + 1, slot))
    edge, following = (row[..., PlacedColumn.EDGE].astype(jnp.int32) for row in (current, after))
    own, next_ = tables.edge_rows[edge], tables.edge_rows[following]
    steps = own[..., EdgeColumn.STEPS]
    duration = own[..., EdgeColumn.SECONDS] * current[..., PlacedColumn.SCALE]
    position = (times - current[..., PlacedColumn.BEGIN]) * steps / jnp.maximum(duration, 1e-6)
    position = jnp.clip(position, 0.0, steps)
    low = jnp.minimum(jnp.floor(position), steps - 1)
    crosses = (low >= steps - 1) & goes_on
    row = own[..., EdgeColumn.FIRST] + low
    return Keyframes(
        low=row.astype(jnp.int32),
        high=jnp.where(crosses, next_[..., EdgeColumn.FIRST], row + 1).astype(jnp.int32),
        share=position - low,
        low_frame=current[..., _FRAME],
        high_frame=jnp.where(crosses[..., None], after[..., _FRAME], current[..., _FRAME]),
        edge=edge,
        following=following,
        crosses=crosses,
    )


def chord_errors_at(tables: DeviceTables, keys: Keyframes) -> Float[Array, "T C"]:
    """Largest distance of a sphere from the straight line between the rows of each pose, m."""
    first = tables.edge_links[keys.edge, LinkColumn.SEAM]
    seam = tables.seam_errors[first + tables.edge_links[keys.following, LinkColumn.RANK]]
    return jnp.where(keys.crosses, seam, tables.root_rows[keys.low, RootColumn.CHORD_ERROR])


def spheres_at(tables: DeviceTables, keys: Keyframes) -> Float[Array, "3 T C S"]:
    """x, y and z of the body's spheres."""
    width = tables.radii.shape[0]

    def axes(rows: Array) -> tuple[Array, Array, Array]:
        return rows[..., :width], rows[..., width : 2 * width], rows[..., 2 * width :]

    def mixed(pool: Array, keys: Keyframes) -> Array:
        return jnp.stack(_mixed(axes(pool[keys.low]), axes(pool[keys.high]), keys))

    return stage(tables.opaque_true, mixed, tables.pool, keys)


def root_at(tables: DeviceTables, keys: Keyframes) -> tuple[Array, Array, Array]:
    """x, y and z of the root. Each [T, C]"""

    def axes(rows: Array) -> tuple[Array, Array, Array]:
        root = tables.root_rows[rows][..., None, :]
        return root[..., RootColumn.X], root[..., RootColumn.Y], root[..., RootColumn.Z]

    x, y, z = _mixed(axes(keys.low), axes(keys.high), keys)
    return x[..., 0], y[..., 0], z[..., 0]


def _mixed(
    low: tuple[Array, Array, Array], high: tuple[Array, Array, Array], keys: Keyframes
) -> tuple[Array, Array, Array]:
    share = keys.share[..., None]
    rest = 1 - share
    c, s, dx, dz = (keys.low_frame[..., k : k + 1] * rest for k in range(4))
    c1, s1, dx1, dz1 = (keys.high_frame[..., k : k + 1] * share for k in range(4))
    x = low[0] * c + low[2] * s + high[0] * c1 + high[2] * s1 + (dx + dx1)
    z = low[2] * c - low[0] * s + high[2] * c1 - high[0] * s1 + (dz + dz1)
    return x, low[1] * rest + high[1] * share, z
