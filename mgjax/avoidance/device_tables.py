"""The tables of a graph as the jitted search reads them: padded jax arrays of 32 bits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.bend import frame_bends, seam_bends
from mgjax.avoidance.config import SpeedConfig
from mgjax.avoidance.tables import EdgeTables, edge_tables, speed_classes
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.padding import bucket_size, pad_axis
from mgjax.core.pytree import register
from mgjax.graph.types import MotionGraph

NOT_THERE_M = -1e3
"""Radius of the columns that pad the body's spheres: never near anything."""

LANES = 16
"""Body spheres are padded to a multiple of this, which the compiler vectorises."""


@register("root_column")
@dataclass(frozen=True, kw_only=True)
class DeviceTables:
    """What the jitted search reads; see :class:`mgjax.avoidance.tables.EdgeTables`.

    Attributes:
        pool: x of all spheres, then y, then z, each padded with copies of the root. [P, 3·S]
        bend: largest way of a sphere off the straight line from a moment of ``pool`` to the next,
            m; infinite where the moments are not the frames of the graph. [P]
        next_edge: the longest edge out of an edge's target: what follows by default. [E]
        seam_first: row of ``seam_bend`` for an edge and the first edge out of its target. [E]
        rank: place of an edge among those that leave its node. [E]
        seam_bend: as ``bend``, from the last frame of an edge to the first pose of the next. [Q]
        radii: of the body's spheres, m; ``NOT_THERE_M`` for padding. [S]
        root_column: the column of ``pool`` that holds the root.
    """

    seconds: Float[Array, " E"]
    step: Float[Array, "E 3"]
    pool: Float[Array, "P K"]
    pool_first: Int[Array, " E"]
    pool_steps: Int[Array, " E"]
    bend: Float[Array, " P"]
    slow_down: Bool[Array, " E"]
    speed_up: Bool[Array, " E"]
    next_edge: Int[Array, " E"]
    seam_first: Int[Array, " E"]
    rank: Int[Array, " E"]
    seam_bend: Float[Array, " Q"]
    part_start: Float[Array, " A"]
    part_stop: Float[Array, " A"]
    part_centre: Float[Array, " A"]
    radii: Float[Array, " S"]
    root_column: int


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

    fan = np.diff(graph.out_first)[graph.edge_target]
    edges = {
        "seconds": (tables.seconds, np.float32),
        "step": (tables.step, np.float32),
        "pool_first": (tables.pool_first, np.int32),
        "pool_steps": (tables.pool_steps, np.int32),
        "slow_down": (slow_down, np.bool_),
        "speed_up": (speed_up, np.bool_),
        "next_edge": (_longest_followers(graph), np.int32),
        "seam_first": (np.cumsum(fan) - fan, np.int32),
        "rank": (_ranks(graph), np.int32),
    }
    parts = {
        "part_start": tables.part_start,
        "part_stop": tables.part_stop,
        "part_centre": tables.part_centre,
    }
    spheres = len(tables.spheres.radii)
    width = -(-(spheres + 1) // LANES) * LANES
    radii = np.full(width, NOT_THERE_M)
    radii[:spheres] = tables.spheres.radii
    bend, seam_bend = _all_bends(graph, tables)
    return DeviceTables(
        pool=padded(_with_root(graph, tables, width), np.float32, 1 << 15),
        bend=padded(bend, np.float32, 1 << 15),
        seam_bend=padded(seam_bend, np.float32, 1 << 14),
        radii=jnp.asarray(radii, dtype=jnp.float32),
        root_column=spheres,
        **{name: padded(x, kind, 1 << 12) for name, (x, kind) in edges.items()},
        **{name: padded(x, np.float32, 128) for name, x in parts.items()},
    )


def _rows(graph: MotionGraph, tables: EdgeTables) -> tuple[np.ndarray, np.ndarray]:
    """Edge and fractional frame of each row of the pool."""
    edge = np.repeat(np.arange(graph.num_edges), tables.pool_steps + 1)
    step = np.arange(len(edge)) - tables.pool_first[edge]
    return edge, graph.edge_starts[edge] + step * (graph.edge_frames / tables.pool_steps)[edge]


def _with_root(graph: MotionGraph, tables: EdgeTables, width: int) -> Float[np.ndarray, "P K"]:
    """The pool with the root's place in the columns after the spheres."""
    edge, frame = _rows(graph, tables)
    low = np.minimum(np.floor(frame + 1e-6).astype(np.int64), graph.edge_stops[edge] - 1)
    share = (frame - low)[:, None]
    root = graph.root_translation[low] * (1 - share) + graph.root_translation[low + 1] * share
    plane = np.asarray(planar.inverse(graph.node_plane[graph.edge_source[edge]]))
    local = np.asarray(planar.apply(plane, root)).astype(np.float32)
    spheres = tables.pool.reshape(len(edge), 3, -1)
    padding = np.repeat(local[:, :, None], width - spheres.shape[2], axis=2)
    return np.concatenate([spheres, padding], axis=2).reshape(len(edge), -1)


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


def _longest_followers(graph: MotionGraph) -> Int[np.ndarray, " E"]:
    source = graph.edge_source[graph.out_edges]
    order = np.lexsort((graph.edge_frames[graph.out_edges], source))
    last = np.searchsorted(source[order], np.arange(graph.num_nodes), side="right") - 1
    return graph.out_edges[order][last][graph.edge_target]


def _ranks(graph: MotionGraph) -> Int[np.ndarray, " E"]:
    rank = np.zeros(graph.num_edges, np.int64)
    first = graph.out_first[graph.edge_source[graph.out_edges]]
    rank[graph.out_edges] = np.arange(len(graph.out_edges)) - first
    return rank
