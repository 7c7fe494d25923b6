"""What the path search needs of a graph, computed once: macro edges and where they can lead.

A *macro edge* is a shortest sequence of edges that lasts at least Δ = 1/3 s. Every walk is one
sequence of macro edges, so searching these is searching walks; but where a graph has a choice at
every frame, edges of one frame would make the search thirty rounds deep for each second, and macro
edges make it two or three. Edges longer than Δ are cut into pieces, so that a macro edge has less
than 2 Δ and all arrays one shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.core import csr, planar
from mgjax.core.errors import GraphError
from mgjax.core.kinematics import planar_frames
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.macro.look_ahead import look_ahead
from mgjax.hybrid.macro.pieces import NO_PIECE, EdgePieces, cut_edges

MACRO_EDGE_S = 1.0 / 3.0
"""A macro edge lasts at least so long, s."""
MIN_PROGRESS_M_S = 0.2
"""Arc length grows at least so fast for an adult, else standing still would cost nothing (eq. 7).

Deviation: 1 mm a frame does for free paths; but then standing for 4 s before an obstacle or a
corner costs 0.6 m², less than any way around it, and the walk stops there. At 0.2 m/s it costs
26 m².
"""

LOCOMOTION_S, LOCOMOTION_M_S = 3.0, 0.3
"""A graph can follow a path if some walk of this duration keeps up this speed, for an adult."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MacroEdges:
    """The macro edges of a graph; places are in the planar frame of the stop they begin at.

    Attributes:
        pieces: what they are made of.
        delta: frames that a macro edge lasts at least.
        first: the macro edges from stop n are first[n] … first[n+1] − 1. [N + 1]
        target: stop at the end. [K]
        frames: how many. [K]
        members: pieces, padded with ``NO_PIECE``. [K, D]
        end: planar frame of the body at the end. [K, 3]
        arc: arc length of the macro edge, m. [K]
        track: root x, root z, arc length so far and squared distance of the windows blended there
            (0 in captured motion), by frame after the first; the last repeats. K' is K padded to a
            bucket. [K', 4, W]
        speed_heading: speed of the root and heading of the body, by the same frames. [K', 2, W]
        ahead: disc that holds the root τ = 1 … 2 Δ frames after a stop, whatever follows: x, z, arc
            length so far, and the radius, which also covers the spread of the arc. [N', 4, 2 Δ]
    """

    pieces: EdgePieces
    delta: int
    first: Int[np.ndarray, " N1"]
    target: Int[np.ndarray, " K"]
    frames: Int[np.ndarray, " K"]
    members: Int[np.ndarray, "K D"]
    end: Float[np.ndarray, "K 3"]
    arc: Float[np.ndarray, " K"]
    track: Float[jax.Array, "K1 4 W"]
    speed_heading: Float[jax.Array, "K1 2 W"]
    ahead: Float[jax.Array, "N2 4 T"]


def build_macro_edges(graph: MotionGraph) -> MacroEdges:
    """The macro edges of a graph.

    Raises:
        GraphError: no walk gets anywhere.
    """
    delta = max(1, round(MACRO_EDGE_S * graph.frame_rate))
    planes = np.asarray(planar_frames(graph.skeleton, graph.positions), dtype=np.float64)
    pieces = cut_edges(graph, planes, delta)
    members, frames = _enumerate(pieces, delta)
    source = pieces.source[members[:, 0]]
    last = (members != NO_PIECE).sum(axis=1) - 1
    target = pieces.target[members[np.arange(len(members)), last]]
    places, after = _places(pieces, members, source)
    progress = graph.body_scale * MIN_PROGRESS_M_S
    track = _tracks(pieces, members, places, 2 * delta - 1, graph.frame_rate, progress)
    first = np.searchsorted(source, np.arange(len(pieces.plane) + 1))
    end = np.asarray(planar.compose(after, pieces.plane[target]))
    _require_locomotion(graph, first, target, frames, end)
    ahead = look_ahead(first, target, frames, end, track, delta)
    return MacroEdges(
        pieces=pieces,
        delta=delta,
        first=first,
        target=target,
        frames=frames,
        members=members,
        end=end,
        arc=track[:, 2, -1].copy(),
        track=_padded(track[:, :4], 4096),
        speed_heading=_padded(track[:, 4:], 4096),
        ahead=_padded(ahead, 1024),
    )


def _padded(table: np.ndarray, minimum: int) -> jax.Array:
    return jnp.asarray(pad_axis(table.astype(np.float32), bucket_size(len(table), minimum)))


def _enumerate(pieces: EdgePieces, delta: int) -> tuple[np.ndarray, np.ndarray]:
    """All macro edges, sorted by the stop they begin at: their pieces and their frames."""
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
        row, place = csr.expand_rows(pieces.out_first, stop)
        following = pieces.out[place]
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
    pieces: EdgePieces, members: np.ndarray, source: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Planar transforms of each piece, and of what follows the last, to the macro edge's begin."""
    here = np.asarray(planar.inverse(pieces.plane[source]))
    places = np.zeros((*members.shape, 3))
    for i in range(members.shape[1]):
        places[:, i] = here
        real = members[:, i] != NO_PIECE
        moved = planar.compose(here, pieces.exit[members[:, i]])
        here = np.where(real[:, None], moved, here)
    return places, here


def _tracks(
    pieces: EdgePieces,
    members: np.ndarray,
    places: np.ndarray,
    width: int,
    frame_rate: float,
    progress: float,
) -> np.ndarray:
    """Track and, as the columns 4 and 5, speed_heading of :class:`MacroEdges`; arc length
    grows by at least ``progress`` m/s. [K, 6, W]"""
    rows, levels = np.nonzero(members != NO_PIECE)
    piece = members[rows, levels]
    count = pieces.frames[piece]
    which, inside = csr.expand(count)
    durations = np.where(members == NO_PIECE, 0, pieces.frames[members])
    begins = np.cumsum(durations, axis=1) - durations
    column = begins[rows, levels][which] + inside
    frames = pieces.first[piece][which] + inside + 1
    body = planar.compose(places[rows, levels][which], pieces.body[frames])
    track = np.zeros((len(members), 6, width))
    track[rows[which], 0, column] = np.asarray(body)[:, 1]
    track[rows[which], 1, column] = np.asarray(body)[:, 2]
    track[rows[which], 5, column] = np.asarray(body)[:, 0]
    track[rows[which], 3, column] = pieces.blend[piece[which]]
    valid = np.arange(width) < durations.sum(axis=1)[:, None]
    final = durations.sum(axis=1) - 1
    track = np.where(valid[:, None], track, np.take_along_axis(track, final[:, None, None], axis=2))
    steps = np.linalg.norm(np.diff(track[:, :2], axis=2, prepend=0.0), axis=1)
    track[:, 4] = steps * frame_rate
    track[:, 2] = np.cumsum(np.where(valid, np.maximum(steps, progress / frame_rate), 0.0), axis=1)
    return track


def _require_locomotion(
    graph: MotionGraph, first: np.ndarray, target: np.ndarray, frames: np.ndarray, end: np.ndarray
) -> None:
    """Bounds the way of any walk from above, each of its macro edges counted straight."""
    rate = np.linalg.norm(end[:, 1:], axis=1) / frames * graph.frame_rate
    best = np.zeros(len(first) - 1)
    rounds = round(LOCOMOTION_S / MACRO_EDGE_S)
    for _ in range(rounds):
        best = np.maximum.reduceat(rate + best[target], first[:-1])
    fastest = float(best.max()) / rounds
    least = graph.body_scale * LOCOMOTION_M_S
    if fastest < least:
        raise GraphError(
            f"got a graph without locomotion (no walk of {LOCOMOTION_S:g} s is faster than"
            f" {fastest:.2f} m/s), expected walking or running at {least:.3g} m/s or more"
        )
