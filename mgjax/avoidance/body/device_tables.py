"""The tables of a graph as the jitted search reads them: padded jax arrays of 32 bits."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.body.edge_tables import EdgeTables, speed_classes
from mgjax.avoidance.config import SpeedConfig
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.core.xla.pytree import register
from mgjax.graph.types import MotionGraph

SEAM_M = 0.05
"""How far the root of an adult may move from one edge to the next beside what its speed tells."""

NOT_THERE_M = -1e3
"""Radius of the columns that pad the body's spheres: never near anything."""


class EdgeColumn(IntEnum):
    """Columns of :attr:`DeviceTables.edge_rows`; the first six are the fields of an edge's row.

    The duration in s; turn, x and z of the step; 1 where it may be slowed down, and sped up; its
    first row of the pool, and its intervals there.
    """

    SECONDS = 0
    TURN = 1
    X = 2
    Z = 3
    SLOW_DOWN = 4
    SPEED_UP = 5
    FIRST = 6
    STEPS = 7


class LinkColumn(IntEnum):
    """Columns of :attr:`DeviceTables.edge_links`; those from ``FOLLOWERS`` on are the followers."""

    SEAM = 0
    RANK = 1
    FOLLOWERS = 2


class RootColumn(IntEnum):
    """Columns of :attr:`DeviceTables.root_rows`."""

    X = 0
    Y = 1
    Z = 2
    CHORD_ERROR = 3


class PartColumn(IntEnum):
    """Columns of :attr:`DeviceTables.parts`, seconds within the part's edge."""

    START = 0
    STOP = 1
    CENTRE = 2


FOLLOWING = 8
"""Edges that are played after a path by default."""

SPHERE_LANES = 16
"""Body spheres are padded to a multiple of this, which the compiler vectorises."""


@register()
@dataclass(frozen=True, kw_only=True)
class DeviceTables:
    """What the jitted search reads; see :class:`mgjax.avoidance.body.edge_tables.EdgeTables`.

    Attributes:
        edge_rows: what it takes to place an edge, in one row; see :class:`EdgeColumn`. [E, 8]
        edge_links: row of ``seam_errors`` for an edge and the first edge out of its target; its
            place among the edges that leave its node; then the edges that follow it by default,
            each the longest that leaves its node; see :class:`LinkColumn`. [E, 2+FOLLOWING]
        pool: x of all spheres, then y, then z, each padded. [P, 3·S]
        root_rows: x, y and z of the root at these moments, and the chord error: the largest
            distance of a sphere from the straight line to the next moment, m; infinite where the
            moments are not the frames of the graph. [P, 4]
        seam_errors: the chord error from the last frame of an edge to the first pose of the next,
            m. [Q]
        parts: start, stop and middle of each part; see :class:`PartColumn`. [A, 3]
        radii: of the body's spheres, m; ``NOT_THERE_M`` for padding. [S]
        numbers: the largest speed of the root at natural speed, m/s; a 1; and how far the root may
            move from one edge to the next beside what its speed tells, m.
    """

    edge_rows: Float[Array, "E 8"]
    edge_links: Int[Array, "E D"]
    pool: Float[Array, "P K"]
    root_rows: Float[Array, "P 4"]
    seam_errors: Float[Array, " Q"]
    parts: Float[Array, "A 3"]
    radii: Float[Array, " S"]
    numbers: Float[Array, " 3"]

    @property
    def root_speed(self) -> Float[Array, ""]:
        """The largest at natural speed, m/s."""
        return self.numbers[0]

    @property
    def opaque_true(self) -> Bool[Array, ""]:
        """True, which a compiler does not know; see :func:`mgjax.core.xla.materialise.stage`."""
        return self.numbers[1] > 0

    @property
    def seam(self) -> Float[Array, ""]:
        """How far the root may move from one edge to the next beside what its speed tells, m."""
        return self.numbers[2]


def device_tables(
    graph: MotionGraph,
    tables: EdgeTables,
    speed: SpeedConfig,
    frame_errors: Float[np.ndarray, " F"],
    seam_errors: Float[np.ndarray, " Q"],
) -> DeviceTables:
    """Puts the tables of a graph into jax arrays, padded so that few graphs compile anew.

    Args:
        graph: the motion graph.
        tables: of it.
        speed: which edges may change their speed.
        frame_errors, seam_errors: of :func:`~mgjax.avoidance.body.chord_error.chord_errors`, m.
    """
    slow_down, speed_up = speed_classes(tables.top_speed, speed)

    def padded(x: np.ndarray, kind: type, least: int) -> jax.Array:
        return jnp.asarray(pad_axis(x.astype(kind), bucket_size(len(x), least), value=0))

    spheres = len(tables.spheres.radii)
    width = -(-spheres // SPHERE_LANES) * SPHERE_LANES
    radii = np.full(width, NOT_THERE_M)
    radii[:spheres] = tables.spheres.radii
    chord_errors = frame_errors[_rows(graph, tables)[1].astype(np.int64)]
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
        root_rows=padded(np.column_stack((root, chord_errors)), np.float32, 1 << 15),
        seam_errors=padded(seam_errors, np.float32, 1 << 14),
        parts=padded(parts, np.float32, 128),
        radii=jnp.asarray(radii, dtype=jnp.float32),
        numbers=jnp.asarray(
            [_top_root_speed(tables, root), 1.0, SEAM_M * graph.body_scale], dtype=jnp.float32
        ),
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
