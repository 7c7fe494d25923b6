"""What a path search returns, measured again in double precision on the walk itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float

from mgjax.core import planar
from mgjax.core.kinematics import global_positions, planar_frames
from mgjax.core.motion import Motion
from mgjax.core.shown import Shown, made_of
from mgjax.graph.feet.played import play_walk
from mgjax.graph.plants import foot_slide, walk_plants
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk
from mgjax.hybrid.config import PathConfig
from mgjax.hybrid.macro.macro_edges import MIN_PROGRESS_M_S
from mgjax.hybrid.macro.pieces import EdgePieces
from mgjax.hybrid.paths.curve import Curve
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.hybrid.prepared import Prepared

Status = Literal["followed", "lost", "time_limit"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """The root of a walk on the floor, one place per frame after the first.

    Attributes:
        places: x and z, m. [F, 2]
        arc: arc length from the beginning, growing at least at 0.2 m/s of an adult, m. [F]
        speed: m/s. [F]
        heading: of the body, rad. [F]
        blend: squared distance of the windows that are blended there, m². [F]
        end: planar frame of the body at the end. [3]
    """

    places: Float[np.ndarray, "F 2"]
    arc: Float[np.ndarray, " F"]
    speed: Float[np.ndarray, " F"]
    heading: Float[np.ndarray, " F"]
    blend: Float[np.ndarray, " F"]
    end: Float[np.ndarray, "3"]

    def squares(self, curve: Curve) -> Float[np.ndarray, " F"]:
        """‖P'(s_i) − P(s_i)‖², m² (eq. 7)."""
        off = self.places - curve.at(np.minimum(self.arc, curve.length))
        return (off * off).sum(axis=1)

    def costs(self, curve: Curve, config: PathConfig) -> Float[np.ndarray, " F"]:
        """The squares, with what blends and a wrong speed add."""
        wanted = np.interp(self.arc, curve.arc, curve.speed)
        slow = np.where(np.isnan(wanted), 0.0, self.speed - wanted)
        return (
            self.squares(curve) + config.blend_weight * self.blend + config.speed_weight * slow**2
        )


def place_pieces(
    graph: MotionGraph, pieces: EdgePieces, played: list[int], start: Float[np.ndarray, "3"]
) -> Track:
    """The root's track over pieces of a walk, from the planar frame of the body at the start."""
    chosen = np.asarray(played, dtype=np.int64)
    here = planar.compose(start, np.asarray(planar.inverse(pieces.plane[pieces.source[chosen[0]]])))
    parts = []
    for one in chosen.tolist():
        frames = int(pieces.first[one]) + 1 + np.arange(int(pieces.frames[one]))
        parts.append(planar.compose(here, pieces.body[frames]))
        here = planar.compose(here, pieces.exit[one])
    body = np.concatenate(parts)
    places = np.concatenate([start[None, 1:], body[:, 1:]])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    return Track(
        places=body[:, 1:],
        arc=_arc_length(graph, steps),
        speed=steps * graph.frame_rate,
        heading=body[:, 0],
        blend=np.repeat(pieces.blend[chosen], pieces.frames[chosen]),
        end=np.asarray(planar.compose(here, pieces.plane[pieces.target[chosen[-1]]])),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class PathResult(Shown):
    """A walk along a path.

    Attributes:
        status: ``"followed"``; ``"lost"``: no walk stays near the path beyond ``failed_at``;
            ``"time_limit"``: the time was over before any walk was complete.
        walk: edges; the last one is played only until ``seconds``.
        start: planar frame of the body at the beginning.
        frames, seconds: of the motion.
        motion: the poses, one per frame, at the graph's rate.
        plants: in which frames the left and the right foot should stand still. [F + 1, 2]
        track: the root's.
        error: Σ ‖P'(s) − P(s)‖² over the frames, m² (eq. 7).
        distance: of each frame's root to the path, m. [F]
        failed_at: place on the path up to which the walk leads; None if it was followed. [2]
        failed_s: arc length there, m. The walk ends where it is that far.
        interrupted: the time limit ended the search; with ``"followed"``, of a better walk.
        end_off: metres and radians off a given end; NaN where there is none.
        prepare_s: seconds of preparation: tables of the graph and compilation, both only once.
        search_s: seconds of search.
        expanded, pruned: partial walks extended, and given up.
        windows, proven: horizons of the exact search, and how many are proven to be the best.
        slide: metres that planted feet travel per frame, both feet together.
        slide_share: metres that a foot travels while planted, by those the root travels meanwhile.
    """

    status: Status
    walk: Walk
    start: Float[np.ndarray, "3"]
    frames: int
    seconds: float
    motion: Motion
    plants: Bool[np.ndarray, "F1 2"]
    track: Track
    error: float
    distance: Float[np.ndarray, " F"]
    failed_at: Float[np.ndarray, "2"] | None
    failed_s: float | None
    interrupted: bool
    end_off: tuple[float, float]
    prepare_s: float
    search_s: float
    expanded: int
    pruned: int
    windows: int
    proven: int
    slide: float
    slide_share: float

    @property
    def mean_distance(self) -> float:
        """Mean distance of the root to the path, m."""
        return float(self.distance.mean())

    @property
    def largest_distance(self) -> float:
        """Largest distance of the root to the path, m."""
        return float(self.distance.max())


def measure_walk(
    graph: MotionGraph,
    prepared: Prepared,
    curve: Curve,
    sketch: Sketch,
    *,
    pieces: list[int],
    frames: int,
    start: Float[np.ndarray, "3"],
    status: Status,
    **counts: Any,
) -> PathResult:
    """Measures a walk, given as pieces of edges and the frames of them that are played."""
    parts = prepared.macro_edges.pieces
    # An edge counts with its first piece; a walk begins at a node.
    edges = [int(parts.edge[p]) for p in pieces if parts.source[p] < graph.num_nodes]
    track = place_pieces(graph, parts, pieces, start)
    failed_s = None
    if status != "followed":
        frames, failed_s = _until_lost(track, curve, frames)
    kept = int(np.searchsorted(np.cumsum(graph.edge_frames[edges]), frames)) + 1
    walk = make_walk(graph, edges[:kept])
    motion = play_walk(graph, walk, np.arange(frames + 1) / graph.frame_rate, start=start)
    track = track_of(graph, motion, track.blend[:frames])
    plants = walk_plants(graph, prepared.plants, edges[:kept], frames + 1)
    slide, share = foot_slide(graph.skeleton, motion, plants)
    result = PathResult(
        status=status,
        walk=walk,
        start=start,
        frames=frames,
        seconds=frames / graph.frame_rate,
        motion=motion,
        plants=plants,
        track=track,
        error=float(track.squares(curve).sum()),
        distance=curve.nearest(track.places, track.arc)[0],
        failed_at=None if failed_s is None else curve.at(np.array(failed_s)),
        failed_s=failed_s,
        end_off=_end_off(track, sketch),
        slide=slide,
        slide_share=share,
        **counts,
    )
    return made_of(result, graph, sketch)


def _until_lost(track: Track, curve: Curve, frames: int) -> tuple[int, float]:
    """The frames until a walk is as far along the path as it gets, and how far that is.

    Arc length alone would count a body that walks on the spot before an obstacle as getting on.
    """
    _, along = curve.nearest(track.places[:frames], track.arc[:frames])
    last = int(np.argmax(along > along.max() - 0.02 * curve.scale))
    return last + 1, float(along[last])


def track_of(graph: MotionGraph, motion: Motion, blend: Float[np.ndarray, " F"]) -> Track:
    """The track of a motion itself, as in its file.

    The search lets an edge end with its own last pose; in the motion the first pose of what follows
    stands there, which is up to a few millimetres off where a transition begins. The root also
    follows the feet that are kept (:mod:`mgjax.graph.feet`), by centimetres.
    """
    positions = np.asarray(global_positions(graph.skeleton, motion), dtype=np.float64)
    body = np.asarray(planar_frames(graph.skeleton, positions))
    steps = np.linalg.norm(np.diff(body[:, 1:], axis=0), axis=1)
    return Track(
        places=body[1:, 1:],
        arc=_arc_length(graph, steps),
        speed=steps * graph.frame_rate,
        heading=body[1:, 0],
        blend=blend,
        end=body[-1],
    )


def _arc_length(graph: MotionGraph, steps: Float[np.ndarray, " F"]) -> Float[np.ndarray, " F"]:
    """Arc length after each frame, of the steps of the root; it grows at standing, too."""
    least = graph.body_scale * MIN_PROGRESS_M_S / graph.frame_rate
    return np.cumsum(np.maximum(steps, least))


def _end_off(track: Track, sketch: Sketch) -> tuple[float, float]:
    if sketch.end is None:
        return math.nan, math.nan
    turn = track.heading[-1] - sketch.end[2]
    return (
        float(np.linalg.norm(track.places[-1] - np.array(sketch.end[:2]))),
        float(abs(np.arctan2(np.sin(turn), np.cos(turn)))),
    )
