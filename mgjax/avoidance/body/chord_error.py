"""How far body spheres stray from straight lines between two poses of a graph.

The search reads the body between two poses as if its spheres moved straight; the written motion
turns joints by slerp. The difference is measured once per pair of neighbouring poses, so that the
search can tell what is certain from what has to be looked at more closely.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Float, Int

from mgjax.avoidance.body.edge_tables import edge_steps
from mgjax.avoidance.body.poses import GraphPoses, PosedGraph, placed_poses, sphere_places
from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.csr import expand_rows
from mgjax.core.xla.exported import exported
from mgjax.core.xla.padding import pad_axis

FRAME_TILE = 256
"""Pairs of poses that are measured in one call."""
_SHARES = (0.25, 0.5, 0.75)
_SAFETY, _ROUNDING_M = 1.1, 2e-5
"""The largest of three samples is short of the maximum of the arc by a few per cent."""


def chord_errors(
    posed: PosedGraph, body_rate: float
) -> tuple[Float[np.ndarray, " F"], Float[np.ndarray, " Q"]]:
    """Those of all frames and of all seams, m: of each edge, in order, with all that follow it.

    Infinite where the body is not sampled at every frame, so that the search knows nothing.
    """
    graph = posed.graph
    edges, item = expand_rows(graph.out_first, graph.edge_target)
    if not np.array_equal(edge_steps(graph, body_rate), graph.edge_frames):
        return np.full(len(graph.root_translation), np.inf), np.full(len(edges), np.inf)
    return frame_chord_errors(posed), seam_chord_errors(posed, edges, graph.out_edges[item])


def frame_chord_errors(posed: PosedGraph) -> Float[np.ndarray, " F"]:
    """For each frame the largest distance of a sphere from the straight line to the next frame, m.

    Meaningless for frames that end a stretch of frames.
    """
    frames = np.arange(len(posed.graph.root_translation))
    after = np.minimum(frames + 1, frames[-1])
    return _chord_errors(posed.poses, frames, after, np.zeros((len(frames), 3)))


def seam_chord_errors(
    posed: PosedGraph, edges: Int[np.ndarray, " Q"], following: Int[np.ndarray, " Q"]
) -> Float[np.ndarray, " Q"]:
    """The largest distance of a sphere from the straight line over a seam, m.

    A seam leads from the last frame of an edge to the first frame of the edge that follows it.
    """
    graph = posed.graph
    return _chord_errors(
        posed.poses,
        graph.edge_stops[edges] - 1,
        graph.edge_starts[following],
        graph.edge_exit[edges],
    )


def _chord_errors(
    poses: GraphPoses, low: np.ndarray, high: np.ndarray, place: np.ndarray
) -> Float[np.ndarray, " Q"]:
    errors = []
    for first in range(0, len(low), FRAME_TILE):
        tile = slice(first, first + FRAME_TILE)
        low_tile, high_tile = (pad_axis(x[tile].astype(np.int32), FRAME_TILE) for x in (low, high))
        place_tile = pad_axis(place[tile].astype(np.float32), FRAME_TILE)
        errors.append(np.asarray(_tile_errors(poses, low_tile, high_tile, place_tile)))
    return np.concatenate(errors)[: len(low)] * _SAFETY + _ROUNDING_M


@jax.jit
@exported()
def _tile_errors(
    poses: GraphPoses, low: Int[Array, " N"], high: Int[Array, " N"], place: Float[Array, "N 3"]
) -> Float[Array, " N"]:
    root, turns = zip(
        (poses.root[low], poses.rotations[low]), placed_poses(poses, high, place), strict=True
    )
    shares = jnp.array((0.0, 1.0, *_SHARES), jnp.float32)[:, None, None]
    roots = root[0][None] * (1 - shares) + root[1][None] * shares
    between = quaternion.slerp(turns[0][None], turns[1][None], shares[2:])
    # One body for all poses: written out, it would be compiled five times.
    first, last, *inner = lax.map(
        lambda pose: sphere_places(poses, *pose),
        (roots, jnp.concatenate([jnp.stack(turns), between])),
    )
    off = [x - (first * (1 - s) + last * s) for x, s in zip(inner, _SHARES, strict=True)]
    return jnp.sqrt(jnp.max(jnp.sum(jnp.stack(off) ** 2, axis=-1), axis=(0, 2)))
