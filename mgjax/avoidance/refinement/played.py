"""Walks as they are written: poses and planted feet over time, and what changing them takes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import BodySpheres, preset_spheres
from mgjax.avoidance.checks.written import walk_motion
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.refinement import (
    free_feet,
)
from mgjax.avoidance.refinement.rig import Rig, make_rig
from mgjax.avoidance.timing.walk_warps import linear_warp, natural_starts
from mgjax.core.motion import Motion
from mgjax.core.shown import like
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.cache import cached
from mgjax.graph.feet.course import FeetState
from mgjax.graph.plants import planted_frames
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, extend, frames_at


@dataclass(frozen=True, kw_only=True, eq=False)
class Refiner:
    """What changing motions of a graph takes.

    Attributes:
        rig: the channels of its body.
        spheres: of its body.
        plants: which foot of each leg of the rig stands in which frame of the graph. [F, L]
    """

    rig: Rig
    spheres: BodySpheres
    plants: Bool[np.ndarray, "F L"]


def refiner_of(graph: MotionGraph) -> Refiner:
    """The refiner of a graph, made once."""
    return cached(graph, ("avoidance", "refiner"), lambda: _make(graph))


def _make(graph: MotionGraph) -> Refiner:
    spheres = preset_spheres(graph.skeleton)
    rig = make_rig(graph, spheres)
    plants = planted_frames(graph)[:, : len(rig.legs)]
    return Refiner(rig=rig, spheres=spheres, plants=plants)


@dataclass(frozen=True, kw_only=True, eq=False)
class Played:
    """A walk as it is written, its feet kept.

    Attributes:
        graph, walk: the walk, as long as the motion needs.
        timing: which moment of it, as captured, is shown when.
        written: the motion from now on.
    """

    graph: MotionGraph
    walk: Walk
    timing: TimeWarp
    written: Motion

    def motion(self, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses of the written frames nearest to some times."""
        frames = np.round(np.asarray(times) * EXPORT_RATE).astype(np.int64)
        motion = replace(
            self.written,
            root_translation=self.written.root_translation[frames],
            local_rotations=self.written.local_rotations[frames],
        )
        return like(motion, self.written)

    def planted(self, plants: Bool[np.ndarray, "F L"], times: np.ndarray) -> np.ndarray:
        """Which feet stand at some times, where either of the two frames says so."""
        captured = Walk(edges=self.walk.edges, scales=np.ones(len(self.walk.edges)))
        frames = frames_at(self.graph, captured, np.asarray(self.timing.at(times)))
        return plants[frames.low] | plants[frames.high]


def played(
    graph: MotionGraph,
    walk: Walk,
    seconds: float,
    *,
    timing: TimeWarp | None = None,
    begin: FeetState | None = None,
) -> Played:
    """A walk as it is written until so many seconds from now.

    Args:
        graph: the graph.
        walk: first out-edges follow it where it ends earlier.
        seconds: at least.
        timing: how it is played; default: as its scales say.
        begin: what the feet are off now; default: nothing.
    """
    timing = timing or linear_warp(graph, walk)
    beyond = float(timing.at(np.array([seconds]))[0] - natural_starts(graph, walk)[-1])
    longer = extend(graph, walk, float(walk.starts(graph)[-1]) + beyond)
    motion = walk_motion(graph, longer, seconds, timing, begin)
    return Played(graph=graph, walk=longer, timing=timing, written=motion)


def written_frames(attack: Attack) -> Float[np.ndarray, " T"]:
    """Times of the written frames from just before an attack is there until just after, s."""
    first = int(np.floor(max(attack.start, 0.0) * EXPORT_RATE))
    last = max(int(np.ceil(attack.end * EXPORT_RATE)), first + 1)
    return np.arange(first, last + 1) / EXPORT_RATE


def free_at(
    refiner: Refiner, played: Played, start: float, stop: float, times: Float[np.ndarray, " T"]
) -> Float[np.ndarray, "T L"]:
    """How far feet may be moved at some times within a window."""
    around = np.arange(round((start - 0.2) * EXPORT_RATE), round((stop + 0.2) * EXPORT_RATE) + 1)
    grid = around / EXPORT_RATE
    free = free_feet(played.planted(refiner.plants, grid), grid)
    columns = [np.interp(times, grid, free[:, k]) for k in range(free.shape[1])]
    return np.stack(columns, axis=1) if columns else np.zeros((len(times), 0))
