"""What the search needs of every edge of a graph, computed once: body volume, speed, labels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.body.spheres import BodySpheres, preset_spheres, sphere_centres
from mgjax.avoidance.body.unmoved import edges_onward
from mgjax.avoidance.config import SpeedConfig
from mgjax.core import planar
from mgjax.core.body.roles import find_role
from mgjax.graph.parts.connectivity import nearest_part
from mgjax.graph.types import MotionGraph

END_EFFECTORS = ("left_wrist", "right_wrist", "left_ankle", "right_ankle")
_LOT = 2048
"""Rows of the pool that are made at a time: so many fit into caches."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeTables:
    """Per edge and per labelled part.

    Attributes:
        spheres: of the body.
        seconds: natural duration of each edge. [E]
        step: planar frame of the node an edge arrives at, in that of the node it leaves. [E, 3]
        pool: sphere centres, components first, at evenly spaced moments of each edge, in the planar
            frame of the node it leaves, m. [P, 3·S]
        pool_first: row of an edge's first moment. [E]
        pool_steps: intervals between its moments; it has one moment more. [E]
        top_speed: largest speed of a hand or foot, m/s. [E]
        part_edge: edge of each avoidance part. [A]
        part_start, part_stop, part_centre: seconds within the edge. [A]
        part_first, part_ids: the parts of edge e are part_ids[part_first[e]:part_first[e+1]].
        nearest_part: least seconds from a node to the middle of a part; inf if there is none. [N]
        onward: the edge by which the motion goes on without a reaction. [N]
        farthest: how far from a node a body that stands there may be, m, and a millimetre more.
    """

    spheres: BodySpheres
    seconds: Float[np.ndarray, " E"]
    step: Float[np.ndarray, "E 3"]
    pool: Float[np.ndarray, "P K"]
    pool_first: Int[np.ndarray, " E"]
    pool_steps: Int[np.ndarray, " E"]
    top_speed: Float[np.ndarray, " E"]
    part_edge: Int[np.ndarray, " A"]
    part_start: Float[np.ndarray, " A"]
    part_stop: Float[np.ndarray, " A"]
    part_centre: Float[np.ndarray, " A"]
    part_first: Int[np.ndarray, " E1"]
    part_ids: Int[np.ndarray, " A"]
    nearest_part: Float[np.ndarray, " N"]
    onward: Int[np.ndarray, " N"]
    farthest: float


def edge_tables(graph: MotionGraph, body_rate: float) -> EdgeTables:
    """Makes the tables of a graph, with body volumes sampled ``body_rate`` times a second."""
    spheres = preset_spheres(graph.skeleton)
    positions = graph.positions
    seconds = graph.edge_frames / graph.frame_rate
    steps = edge_steps(graph, body_rate)
    first = np.concatenate([[0], np.cumsum(steps + 1)])[:-1]
    rows = np.arange(int((steps + 1).sum()))
    edge = np.repeat(np.arange(graph.num_edges), steps + 1)
    frame = graph.edge_starts[edge] + (rows - first[edge]) * (graph.edge_frames / steps)[edge]
    pool = _sample_spheres(graph, spheres, positions, edge, frame)
    part_edge = graph.label_edge
    offset = graph.edge_starts[part_edge]
    start = (graph.label_starts - offset) / graph.frame_rate
    stop = (graph.label_stops - offset) / graph.frame_rate
    counts = np.bincount(part_edge, minlength=graph.num_edges)
    source = graph.node_plane[graph.edge_source].astype(np.float64)
    target = graph.node_plane[graph.edge_target].astype(np.float64)
    arrival = planar.compose(graph.edge_exit.astype(np.float64), target)
    return EdgeTables(
        spheres=spheres,
        seconds=seconds,
        step=np.asarray(planar.compose(planar.inverse(source), arrival)),
        pool=pool,
        pool_first=first,
        pool_steps=steps,
        top_speed=_top_speeds(graph, positions),
        part_edge=part_edge,
        part_start=start,
        part_stop=stop,
        part_centre=0.5 * (start + stop),
        part_first=np.concatenate([[0], np.cumsum(counts)]),
        part_ids=np.argsort(part_edge, kind="stable"),
        nearest_part=nearest_part(graph, np.ones(len(part_edge), dtype=bool)),
        onward=edges_onward(graph),
        farthest=_farthest(pool[first], spheres),
    )


def edge_steps(graph: MotionGraph, body_rate: float) -> Int[np.ndarray, " E"]:
    """Intervals of each edge between samples of the body, ``body_rate`` a second."""
    seconds = graph.edge_frames / graph.frame_rate
    return np.maximum(np.ceil(seconds * body_rate - 1e-6).astype(np.int64), 1)


def of_size(tables: EdgeTables, factor: float) -> EdgeTables:
    """The tables of a body and its motion so many times as large."""
    if factor == 1:
        return tables
    spheres = replace(tables.spheres, radii=_times(tables.spheres.radii, factor))
    return replace(
        tables,
        spheres=spheres,
        step=tables.step * [1.0, factor, factor],
        pool=_times(tables.pool, factor),
        top_speed=tables.top_speed * factor,
        farthest=tables.farthest * factor,
    )


def _times(values: np.ndarray, factor: float) -> np.ndarray:
    return (values * np.float64(factor)).astype(values.dtype)


def _sample_spheres(
    graph: MotionGraph,
    spheres: BodySpheres,
    positions: np.ndarray,
    edge: np.ndarray,
    frame: np.ndarray,
) -> np.ndarray:
    """[P, 3·S] sphere centres at fractional frames, in the frames of the edges' source nodes."""
    low = np.minimum(np.floor(frame + 1e-6).astype(np.int64), graph.edge_stops[edge] - 1)
    share = (frame - low)[:, None, None].astype(np.float32)
    plane = np.asarray(planar.inverse(graph.node_plane[graph.edge_source[edge]]))[:, None]
    pool = np.empty((len(edge), 3, len(spheres.radii)), np.float32)
    for first in range(0, len(edge), _LOT):
        lot = slice(first, first + _LOT)
        before, after = (sphere_centres(spheres, positions[low[lot] + k]) for k in (0, 1))
        mixed = before * (1 - share[lot]) + after * share[lot]
        pool[lot] = np.moveaxis(np.asarray(planar.apply(plane[lot], mixed)), -1, 1)
    return pool.reshape(len(edge), -1)


def _farthest(pool: np.ndarray, spheres: BodySpheres) -> float:
    """How far spheres are from the origin of poses [E, 3·S], and a millimetre more, m."""
    distances = np.linalg.norm(pool.reshape(len(pool), 3, -1), axis=1)
    return float((distances + spheres.radii).max(initial=0.0)) + 1e-3


def _top_speeds(graph: MotionGraph, positions: np.ndarray) -> np.ndarray:
    """v_max of each edge (§4.1): the fastest end effector over its frames, in the world.

    Of those that the body has: an arm may be missing.
    """
    found = [find_role(graph.skeleton, role) for role in END_EFFECTORS]
    joints = [joint for joint in found if joint is not None]
    step = np.linalg.norm(np.diff(positions[:, joints], axis=0), axis=-1).max(axis=1)
    step = np.append(step * graph.frame_rate, 0.0)
    # The step from frame f to f + 1 belongs to the edge that plays f.
    return np.array(
        [step[a:b].max() for a, b in zip(graph.edge_starts, graph.edge_stops, strict=True)]
    )


def speed_classes(
    top_speed: Float[np.ndarray, " E"], speed: SpeedConfig
) -> tuple[Bool[np.ndarray, " E"], Bool[np.ndarray, " E"]]:
    """Which edges may be slowed down, and which sped up (§4.1)."""
    still = top_speed < speed.V_still
    slow_down = (top_speed > speed.V_fast) | still
    speed_up = ((top_speed > speed.V_still) & (top_speed < speed.V_slow)) | still
    return slow_down, speed_up
