"""How far body spheres stray from straight lines between two poses of a graph.

The search reads the body between two poses as if its spheres moved straight; the written motion
turns joints by slerp. The difference is measured once per pair of neighbouring poses, so that the
search can tell what is certain from what has to be looked at more closely.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.body.poses import Body, body_of
from mgjax.core import planar, quaternion
from mgjax.core.arrays import Array
from mgjax.core.kinematics import forward
from mgjax.core.xla.padding import pad_axis
from mgjax.graph.types import MotionGraph

TILE = 4096
_SHARES = (0.25, 0.5, 0.75)
_SAFETY, _ROUNDING_M = 1.1, 2e-5
"""The largest of three samples is short of the maximum of the arc by a few per cent."""


def frame_bends(graph: MotionGraph) -> Float[np.ndarray, " F"]:
    """For each frame the largest way of a sphere off the straight line to the next frame, m.

    Meaningless for frames that end a stretch of frames.
    """
    frames = np.arange(len(graph.root_translation))
    after = np.minimum(frames + 1, frames[-1])
    return _bends(graph, frames, after, np.zeros((len(frames), 3)))


def seam_bends(
    graph: MotionGraph, edges: Int[np.ndarray, " Q"], following: Int[np.ndarray, " Q"]
) -> Float[np.ndarray, " Q"]:
    """The same from the last frame of each edge to the first frame of the edge that follows it."""
    return _bends(
        graph, graph.edge_stops[edges] - 1, graph.edge_starts[following], graph.edge_exit[edges]
    )


def _bends(
    graph: MotionGraph, low: np.ndarray, high: np.ndarray, place: np.ndarray
) -> Float[np.ndarray, " Q"]:
    body, _ = body_of(graph)
    found = []
    for first in range(0, len(low), TILE):
        pieces = (low[first : first + TILE], high[first : first + TILE])
        low_tile, high_tile = (pad_axis(x.astype(np.int32), TILE) for x in pieces)
        place_tile = pad_axis(place[first : first + TILE].astype(np.float32), TILE)
        found.append(np.asarray(_tile_bends(body, low_tile, high_tile, place_tile)))
    return np.concatenate(found)[: len(low)] * _SAFETY + _ROUNDING_M


@jax.jit
def _tile_bends(
    body: Body, low: Int[Array, " N"], high: Int[Array, " N"], place: Float[Array, "N 3"]
) -> Float[Array, " N"]:
    ends = (body.root[low], body.rotations[low]), _placed(body, high, place)

    def spheres(root: Array, rotations: Array) -> Array:
        positions, _ = forward(body.skeleton, root, rotations)
        share = body.share[None]
        return positions[:, body.first] * (1 - share) + positions[:, body.second] * share

    first, last = spheres(*ends[0]), spheres(*ends[1])
    worst = jnp.zeros(low.shape, jnp.float32)
    for share in _SHARES:
        at = jnp.full((1, 1), share, jnp.float32)
        root = ends[0][0] * (1 - share) + ends[1][0] * share
        turned = spheres(root, quaternion.slerp(ends[0][1], ends[1][1], at))
        off = turned - (first * (1 - share) + last * share)
        worst = jnp.maximum(worst, jnp.max(jnp.sum(off * off, axis=-1), axis=1))
    return jnp.sqrt(worst)


def _placed(body: Body, frames: Array, place: Array) -> tuple[Array, Array]:
    rotations = body.rotations[frames]
    root, first = planar.apply_pose(place, body.root[frames], rotations[:, 0])
    return root, jnp.concatenate([first[:, None], rotations[:, 1:]], axis=1)
