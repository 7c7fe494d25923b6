"""The tables of a graph as the jitted search reads them: padded jax arrays of 32 bits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.body.chord_error import frame_bends, seam_bends
from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables, speed_classes
from mgjax.avoidance.config import SpeedConfig
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.core.xla.pytree import register
from mgjax.graph.types import MotionGraph

NOT_THERE_M = -1e3
"""Radius of the columns that pad the body's spheres: never near anything."""

SECONDS, FIRST, STEPS = 0, 6, 7
"""Columns of :attr:`DeviceTables.edge_rows`."""

SEAM, RANK, FOLLOWERS = 0, 1, 2
"""Columns of :attr:`DeviceTables.edge_links`; the followers go on to the last."""

BEND = 3
"""Column of :attr:`DeviceTables.trace`, after the root."""

PART_START, PART_STOP, PART_CENTRE = 0, 1, 2
"""Columns of :attr:`DeviceTables.parts`."""

FOLLOWING = 8
"""Edges that are played after a path by default."""

LANES = 16
"""Body spheres are padded to a multiple of this, which the compiler vectorises."""


@register()
@dataclass(frozen=True, kw_only=True)
class DeviceTables:
    """What the jitted search reads; see :class:`mgjax.avoidance.body.edge_tables.EdgeTables`.

    Attributes:
        edge_rows: what it takes to lay an edge, in one row: its duration in s, turn, x and z of its
            step, 1 where it may be slowed down and sped up, its first row of ``pool`` and its
            intervals there. [E, 8]
        edge_links: row of ``seam_bend`` for an edge and the first edge out of its target; its
            place among the edges that leave its node; then the edges that follow it by default,
            each the longest that leaves its node. [E, 2+FOLLOWING]
        pool: x of all spheres, then y, then z, each padded. [P, 3·S]
        trace: x, y and z of the root at the same moments, and the largest way of a sphere off the
            straight line to the next moment, m; infinite where the moments are not the frames of
            the graph. [P, 4]
        seam_bend: the same from the last frame of an edge to the first pose of the next. [Q]
        parts: start, stop and middle of each part, seconds within its edge. [A, 3]
        radii: of the body's spheres, m; ``NOT_THERE_M`` for padding. [S]
        numbers: the largest speed of the root at natural speed, m/s, and a 1.
    """

    edge_rows: Float[Array, "E 8"]
    edge_links: Int[Array, "E D"]
    pool: Float[Array, "P K"]
    trace: Float[Array, "P 4"]
    seam_bend: Float[Array, " Q"]
    parts: Float[Array, "A 3"]
    radii: Float[Array, " S"]
    numbers: Float[Array, " 2"]

    @property
    def root_speed(self) -> Float[Array, ""]:
        """The largest at natural speed, m/s."""
        return self.numbers[0]

    @property
    def there(self) -> Bool[Array, ""]:
        """True, which a compiler does not know; see :func:`mgjax.core.xla.materialise.stage`."""
        return self.numbers[1] > 0


@lru_cache(maxsize=8)
def search_tables(
    graph: MotionGraph, body_rate: float, speed: SpeedConfig
) -> tuple[EdgeTables, DeviceTables]:
    """The tables of a graph, kept: they are made once for all attacks."""
    tables = edge_tables(graph, body_rate)
    return tables, device_tables(graph, tables, speed)


def device_tables(graph: MotionGraph, tables: EdgeTables, speed: SpeedConfig) -> DeviceTables:
    """Puts the tables into jax arrays, padded so that few graphs compile anew."""
    slow_down, speed_up = speed_classes(tables.top_speed, speed)

    def padded(x: np.ndarray, kind: type, least: int) -> jax.Array:
        return jnp.asarray(pad_axis(x.astype(kind), bucket_size(len(x), least), value=0))

    spheres = len(tables.spheres.radii)
    width = -(-spheres // LANES) * LANES
    radii = np.full(width, NOT_THERE_M)
    radii[:spheres] = tables.spheres.radii
    bend, seam_bend = _all_bends(graph, tables)
    root = _roots(graph, tables)
    marks = (slow_down, speed_up, tables.pool_first, tables.pool_steps)
    edge_rows = np.column_stack((tables.seconds, tables.step, *marks))
    fan = np.diff(graph.out_first)[graph.edge_target]
    seam_first = np.cumsum(fan) - fan
    edge_links = np.column_stack((seam_first, _ranks(graph), *_followers(graph)))
    parts = np.column_stack((tables.part_start, tables.part_stop, tables.part_centre))
    return DeviceTables(
        edge_rows=padded(edge_rows, np.float32, 1 << 12),
        edge_links=padded(edge_links, np.int32, 1 << 12),
        pool=padded(_wide_pool(tables, width), np.float32, 1 << 15),
        trace=padded(np.column_stack((root, bend)), np.float32, 1 << 15),
        seam_bend=padded(seam_bend, np.float32, 1 << 14),
        parts=padded(parts, np.float32, 128),
        radii=jnp.asarray(radii, dtype=jnp.float32),
        numbers=jnp.asarray([_top_root_speed(tables, root), 1.0], dtype=jnp.float32),
    )


def _rows(graph: MotionGraph, tables: EdgeTables) -> tuple[np.ndarray, np.ndarray]:
    """Edge and fractional frame of each row of the pool."""
    edge = np.repeat(np.arange(graph.num_edges), tables.pool_steps + 1)
    step = np.arange(len(edge)) - tables.pool_first[edge]
    return edge, graph.edge_starts[edge] + step * (graph.edge_frames / tables.pool_steps)[edge]


def _roots(graph: MotionGraph, tables: EdgeTables) -> Float[np.ndarray, "P 3"]:
    """The root at each row of the pool, in the planar frame of the node that its edge leaves."""
    edge, frame = _rows(graph, tables)
    low = np.minimum(np.floor(frame + 1e-6).astype(np.int64), graph.edge_stops[edge] - 1)
    share = (frame - low)[:, None]
    root = graph.root_translation[low] * (1 - share) + graph.root_translation[low + 1] * share
    plane = np.asarray(planar.inverse(graph.node_plane[graph.edge_source[edge]]))
    return np.asarray(planar.apply(plane, root)).astype(np.float32)


def _wide_pool(tables: EdgeTables, width: int) -> Float[np.ndarray, "P K"]:
    """The pool with room for ``width`` spheres."""
    spheres = tables.pool.reshape(len(tables.pool), 3, -1)
    return pad_axis(spheres, width, axis=2, value=0).reshape(len(spheres), -1)


def _top_root_speed(tables: EdgeTables, root: Float[np.ndarray, "P 3"]) -> float:
    """The largest speed of the root within an edge, m/s."""
    edge = np.repeat(np.arange(len(tables.seconds)), tables.pool_steps + 1)
    rate = (tables.pool_steps / tables.seconds)[edge[1:]]
    within = edge[1:] == edge[:-1]
    return float((np.linalg.norm(np.diff(root, axis=0), axis=1) * rate)[within].max(initial=0.0))


def _all_bends(graph: MotionGraph, tables: EdgeTables) -> tuple[np.ndarray, np.ndarray]:
    """``bend`` and ``seam_bend``."""
    fan = np.diff(graph.out_first)[graph.edge_target]
    edges = np.repeat(np.arange(graph.num_edges), fan)
    within = np.arange(len(edges)) - np.repeat(np.cumsum(fan) - fan, fan)
    following = graph.out_edges[graph.out_first[graph.edge_target[edges]] + within]
    if not np.array_equal(tables.pool_steps, graph.edge_frames):
        return np.full(len(tables.pool), np.inf), np.full(len(edges), np.inf)
    _, frame = _rows(graph, tables)
    return frame_bends(graph)[frame.astype(np.int64)], seam_bends(graph, edges, following)


def _followers(graph: MotionGraph) -> Int[np.ndarray, "FOLLOWING E"]:
    """What is played after each edge: again and again the longest edge that leaves the node."""
    source = graph.edge_source[graph.out_edges]
    order = np.lexsort((graph.edge_frames[graph.out_edges], source))
    last = np.searchsorted(source[order], np.arange(graph.num_nodes), side="right") - 1
    longest = graph.out_edges[order][last][graph.edge_target]
    rows = np.empty((FOLLOWING, graph.num_edges), np.int64)
    rows[0] = longest
    for k in range(1, FOLLOWING):
        rows[k] = longest[rows[k - 1]]
    return rows


def _ranks(graph: MotionGraph) -> Int[np.ndarray, " E"]:
    rank = np.zeros(graph.num_edges, np.int64)
    first = graph.out_first[graph.edge_source[graph.out_edges]]
    rank[graph.out_edges] = np.arange(len(graph.out_edges)) - first
    return rank
