"""The edges of a graph, cut into pieces short enough for one table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import csr
from mgjax.graph.types import MotionGraph

NO_PIECE = -1
"""Pads the pieces of macro edges."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EdgePieces:
    """The edges of a graph, cut into pieces of at most Δ; the first stops are the graph's nodes.

    Attributes:
        source, target: stops. [Q]
        first, frames: first frame and number of frames. [Q]
        exit: planar transform after the piece. [Q, 3]
        edge: the edge it belongs to. [Q]
        blend: squared distance of the windows that it blends, m²; 0 in captured motion. [Q]
        out_first, out: the pieces out of stop n are out[out_first[n]:out_first[n+1]].
        plane: planar frame of the body at each stop. [N, 3]
        body: planar frame of the body at every frame of the graph, in its edge's coordinates.
            [F, 3]
    """

    source: Int[np.ndarray, " Q"]
    target: Int[np.ndarray, " Q"]
    first: Int[np.ndarray, " Q"]
    frames: Int[np.ndarray, " Q"]
    exit: Float[np.ndarray, "Q 3"]
    edge: Int[np.ndarray, " Q"]
    blend: Float[np.ndarray, " Q"]
    out_first: Int[np.ndarray, " N1"]
    out: Int[np.ndarray, " Q"]
    plane: Float[np.ndarray, "N 3"]
    body: Float[np.ndarray, "F 3"]


def cut_edges(graph: MotionGraph, planes: Float[np.ndarray, "F 3"], longest: int) -> EdgePieces:
    """Cuts the edges of a graph into pieces of at most ``longest`` frames, about equally long."""
    frames = graph.edge_frames
    counts = -(-frames // longest)
    edge, part = csr.expand(counts)
    begin = graph.edge_starts[edge] + part * frames[edge] // counts[edge]
    stop = graph.edge_starts[edge] + (part + 1) * frames[edge] // counts[edge]
    # A cut has a stop of its own, numbered after the nodes.
    inner = part + 1 < counts[edge]
    number = graph.num_nodes + np.cumsum(inner) - 1
    target = np.where(inner, number, graph.edge_target[edge])
    source = np.where(part > 0, np.roll(number, 1), graph.edge_source[edge])
    order = np.argsort(source, kind="stable")
    stops = graph.num_nodes + int(inner.sum())
    return EdgePieces(
        source=source,
        target=target,
        first=begin,
        frames=stop - begin,
        exit=np.where(inner[:, None], 0.0, graph.edge_exit[edge].astype(np.float64)),
        edge=edge,
        blend=graph.edge_distance[edge].astype(np.float64) ** 2,
        out_first=csr.row_starts(np.bincount(source, minlength=stops)),
        out=order,
        plane=np.concatenate([graph.node_plane.astype(np.float64), planes[stop[inner]]]),
        body=planes,
    )
