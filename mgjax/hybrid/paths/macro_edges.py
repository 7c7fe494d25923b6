"""What the path search needs of a graph, computed once: strides and where they can lead.

A *stride* is a shortest sequence of edges that lasts at least Δ = 1/3 s. Every walk is one sequence
of strides, so searching strides is searching walks; but where a graph has a choice at every frame,
edges of one frame would make the search thirty rounds deep for each second, and strides make it
two or three. Edges longer than Δ are cut into pieces, so that a stride has less than 2 Δ and all
arrays one shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.core import planar
from mgjax.core.errors import GraphError
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.types import MotionGraph

STRIDE_S = 1.0 / 3.0
CREEP_M_S = 0.2
"""Arc length grows at least so fast, else standing still would cost nothing (eq. 7).

Deviation: 1 mm a frame does for free paths; but then standing for 4 s before an obstacle or a
corner costs 0.6 m², less than any way around it, and the walk stops there. At 0.2 m/s it costs
26 m².
"""

LOCOMOTION_S, LOCOMOTION_M_S = 3.0, 0.3
"""A graph can follow a path if some walk of this duration keeps up this speed."""

NO_PIECE = -1


@dataclass(frozen=True, kw_only=True, eq=False)
class Pieces:
    """Edges cut into pieces of at most Δ. The first stops are the graph's nodes.

    Attributes:
        source, target: stops. [Q]
        first, frames: first frame and number of frames. [Q]
        exit: planar transform after the piece. [Q, 3]
        edge: the edge it belongs to. [Q]
        blend: squared distance of the windows that it blends, m²; 0 in captured motion. [Q]
        out_first, out: the pieces out of stop n are out[out_first[n]:out_first[n+1]].
        plane: planar frame of the body at each stop. [N, 3]
        body: the same at every frame of the graph, in its edge's coordinates. [F, 3]
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Strides:
    """The strides of a graph; all places are in the planar frame of the stop they begin at.

    Attributes:
        pieces: what they are made of.
        delta: frames that a stride lasts at least.
        first: the strides from stop n are first[n] … first[n+1] − 1. [N + 1]
        target: stop at the end. [K]
        frames: how many. [K]
        members: pieces, padded with ``NO_PIECE``. [K, D]
        end: planar frame of the body at the end. [K, 3]
        arc: arc length of the stride, m. [K]
        track: root x, root z, arc length so far and squared distance of the windows blended there
            (0 in captured motion), by frame after the first; the last repeats. K' is K padded to a
            bucket. [K', 4, W]
        manner: speed of the root and heading of the body, by the same frames. [K', 2, W]
        ahead: disc that holds the root τ = 1 … 2 Δ frames after a stop, whatever follows: x, z, arc
            length so far, and the radius, which also covers the spread of the arc. [N', 4, 2 Δ]
    """

    pieces: Pieces
    delta: int
    first: Int[np.ndarray, " N1"]
    target: Int[np.ndarray, " K"]
    frames: Int[np.ndarray, " K"]
    members: Int[np.ndarray, "K D"]
    end: Float[np.ndarray, "K 3"]
    arc: Float[np.ndarray, " K"]
    track: Float[jax.Array, "K1 4 W"]
    manner: Float[jax.Array, "K1 2 W"]
    ahead: Float[jax.Array, "N2 4 T"]


@lru_cache(maxsize=8)
def stride_tables(graph: MotionGraph) -> Strides:
    """The strides of a graph.

    Raises:
        GraphError: no walk gets anywhere.
    """
    delta = max(1, round(STRIDE_S * graph.frame_rate))
    positions = forward(graph.skeleton, graph.root_translation, graph.local_rotations)[0]
    planes = np.asarray(planar_frames(graph.skeleton, np.asarray(positions)), dtype=np.float64)
    pieces = cut_edges(graph, planes, delta)
    members, frames = _enumerate(pieces, delta)
    source = pieces.source[members[:, 0]]
    last = (members != NO_PIECE).sum(axis=1) - 1
    target = pieces.target[members[np.arange(len(members)), last]]
    places, after = _places(pieces, members, source)
    track = _tracks(graph, pieces, members, places, 2 * delta - 1)
    first = np.searchsorted(source, np.arange(len(pieces.plane) + 1))
    end = np.asarray(planar.compose(after, pieces.plane[target]))
    _require_locomotion(graph, first, target, frames, end)
    ahead = _ahead(first, target, frames, end, track, delta)
    return Strides(
        pieces=pieces,
        delta=delta,
        first=first,
        target=target,
        frames=frames,
        members=members,
        end=end,
        arc=track[:, 2, -1],
        track=_padded(track[:, :4], 4096),
        manner=_padded(track[:, 4:], 4096),
        ahead=_padded(ahead, 1024),
    )


def _padded(table: np.ndarray, minimum: int) -> jax.Array:
    return jnp.asarray(pad_axis(table.astype(np.float32), bucket_size(len(table), minimum)))


def cut_edges(graph: MotionGraph, planes: Float[np.ndarray, "F 3"], longest: int) -> Pieces:
    """Cuts the edges of a graph into pieces of at most ``longest`` frames, about equally long."""
    frames = graph.edge_frames
    counts = -(-frames // longest)
    edge = np.repeat(np.arange(graph.num_edges), counts)
    part = np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)
    begin = graph.edge_starts[edge] + part * frames[edge] // counts[edge]
    stop = graph.edge_starts[edge] + (part + 1) * frames[edge] // counts[edge]
    # A cut has a stop of its own, numbered after the nodes.
    inner = part + 1 < counts[edge]
    number = graph.num_nodes + np.cumsum(inner) - 1
    target = np.where(inner, number, graph.edge_target[edge])
    source = np.where(part > 0, np.roll(number, 1), graph.edge_source[edge])
    order = np.argsort(source, kind="stable")
    stops = graph.num_nodes + int(inner.sum())
    counted = np.bincount(source, minlength=stops)
    return Pieces(
        source=source,
        target=target,
        first=begin,
        frames=stop - begin,
        exit=np.where(inner[:, None], 0.0, graph.edge_exit[edge].astype(np.float64)),
        edge=edge,
        blend=graph.edge_distance[edge].astype(np.float64) ** 2,
        out_first=np.concatenate([[0], np.cumsum(counted)]),
        out=order,
        plane=np.concatenate([graph.node_plane.astype(np.float64), planes[stop[inner]]]),
        body=planes,
    )


def _enumerate(pieces: Pieces, delta: int) -> tuple[np.ndarray, np.ndarray]:
    """All strides, sorted by the stop they begin at: their pieces and their frames."""
    members = pieces.out[:, None]
    frames = pieces.frames[pieces.out]
    done: list[tuple[np.ndarray, np.ndarray]] = []
    while True:
        full = frames >= delta
        done.append((members[full], frames[full]))
        members, frames = members[~full], frames[~full]
        if not len(members):
            break
        stop = pieces.target[members[:, -1]]
        degree = np.diff(pieces.out_first)[stop]
        row = np.repeat(np.arange(len(members)), degree)
        rank = np.arange(len(row)) - np.repeat(np.cumsum(degree) - degree, degree)
        following = pieces.out[pieces.out_first[stop][row] + rank]
        members = np.concatenate([members[row], following[:, None]], axis=1)
        frames = frames[row] + pieces.frames[following]
    depth = done[-1][0].shape[1]
    joined = np.concatenate(
        [pad_axis(m, depth, axis=1, value=NO_PIECE).astype(np.int64) for m, _ in done]
    )
    count = np.concatenate([f for _, f in done])
    order = np.argsort(pieces.source[joined[:, 0]], kind="stable")
    return joined[order], count[order]


def _places(
    pieces: Pieces, members: np.ndarray, source: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """From the coordinates of each piece to those of the stride's beginning, and after the last."""
    here = np.asarray(planar.inverse(pieces.plane[source]))
    places = np.zeros((*members.shape, 3))
    for i in range(members.shape[1]):
        places[:, i] = here
        there = members[:, i] != NO_PIECE
        moved = planar.compose(here, pieces.exit[members[:, i]])
        here = np.where(there[:, None], moved, here)
    return places, here


def _tracks(
    graph: MotionGraph,
    pieces: Pieces,
    members: np.ndarray,
    places: np.ndarray,
    width: int,
) -> np.ndarray:
    """[K, 6, W]: track and manner of :class:`Strides`."""
    rows, levels = np.nonzero(members != NO_PIECE)
    piece = members[rows, levels]
    count = pieces.frames[piece]
    which = np.repeat(np.arange(len(piece)), count)
    inside = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    lasts = np.where(members == NO_PIECE, 0, pieces.frames[members])
    begins = np.cumsum(lasts, axis=1) - lasts
    column = begins[rows, levels][which] + inside
    frames = pieces.first[piece][which] + inside + 1
    body = planar.compose(places[rows, levels][which], pieces.body[frames])
    track = np.zeros((len(members), 6, width))
    track[rows[which], 0, column] = np.asarray(body)[:, 1]
    track[rows[which], 1, column] = np.asarray(body)[:, 2]
    track[rows[which], 5, column] = np.asarray(body)[:, 0]
    track[rows[which], 3, column] = pieces.blend[piece[which]]
    valid = np.arange(width) < lasts.sum(axis=1)[:, None]
    final = lasts.sum(axis=1) - 1
    track = np.where(valid[:, None], track, np.take_along_axis(track, final[:, None, None], axis=2))
    steps = np.linalg.norm(np.diff(track[:, :2], axis=2, prepend=0.0), axis=1)
    track[:, 4] = steps * graph.frame_rate
    track[:, 2] = np.cumsum(
        np.where(valid, np.maximum(steps, CREEP_M_S / graph.frame_rate), 0.0), axis=1
    )
    return track


def _require_locomotion(
    graph: MotionGraph, first: np.ndarray, target: np.ndarray, frames: np.ndarray, end: np.ndarray
) -> None:
    """Bounds the way of any walk from above, stride by stride, each stride counted straight."""
    rate = np.linalg.norm(end[:, 1:], axis=1) / frames * graph.frame_rate
    best = np.zeros(len(first) - 1)
    rounds = round(LOCOMOTION_S / STRIDE_S)
    for _ in range(rounds):
        best = np.maximum.reduceat(rate + best[target], first[:-1])
    fastest = float(best.max()) / rounds
    if fastest < LOCOMOTION_M_S:
        raise GraphError(
            f"got a graph without locomotion (no walk of {LOCOMOTION_S:g} s is faster than"
            f" {fastest:.2f} m/s), expected walking or running at {LOCOMOTION_M_S:g} m/s or more"
        )


def _ahead(
    first: np.ndarray,
    target: np.ndarray,
    frames: np.ndarray,
    end: np.ndarray,
    track: np.ndarray,
    delta: int,
) -> np.ndarray:
    """[N, 4, 2 Δ]; see :class:`Strides`. The second Δ come from the discs of what follows."""
    discs = np.concatenate([track[:, :3, :delta], np.zeros((len(track), 1, delta))], axis=1)
    near = _enclosed(discs, first)
    step = np.arange(delta, 2 * delta)
    inside = step < frames[:, None]
    own = np.pad(track[:, :3], ((0, 0), (0, 0), (0, 1)), mode="edge")[:, :, delta:]
    later = near[target[:, None], :, np.clip(step - frames[:, None], 0, delta - 1)]
    c, s = np.cos(end[:, :1]), np.sin(end[:, :1])
    moved = np.stack(
        [
            later[..., 0] * c + later[..., 1] * s + end[:, 1:2],
            later[..., 1] * c - later[..., 0] * s + end[:, 2:],
            later[..., 2] + track[:, 2, -1:],
            later[..., 3],
        ],
        axis=1,
    )
    own = np.concatenate([own, np.zeros((len(own), 1, delta))], axis=1)
    far = _enclosed(np.where(inside[:, None], own, moved), first)
    return np.concatenate([near, far], axis=2)


def _enclosed(discs: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Per stop a disc around the discs [K, (x, z, arc, radius), T] of its strides.

    The radius also holds half the spread of the arc: P(s) moves no farther than s does.
    """
    low = np.minimum.reduceat(discs[:, :3], first[:-1], axis=0)
    high = np.maximum.reduceat(discs[:, :3], first[:-1], axis=0)
    middle = 0.5 * (low + high)
    owner = np.repeat(np.arange(len(first) - 1), np.diff(first))
    off = discs[:, :3] - middle[owner]
    reach = np.linalg.norm(off[:, :2], axis=1) + np.abs(off[:, 2]) + discs[:, 3]
    radius = np.maximum.reduceat(reach, first[:-1], axis=0) + 1e-5
    return np.concatenate([middle, radius[:, None]], axis=1)
