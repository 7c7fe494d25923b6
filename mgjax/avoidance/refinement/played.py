"""Walks as they are played: poses and planted feet at any time, and what changing them takes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import BodySpheres, preset_spheres
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.refinement import (
    free_feet,
)
from mgjax.avoidance.refinement.rig import Rig, make_rig
from mgjax.core.motion import Motion
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.cache import cached
from mgjax.graph.plants import planted_frames
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, frames_at, sample_walk


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
    return Refiner(rig=rig, spheres=spheres, plants=planted_frames(graph)[:, : len(rig.legs)])


@dataclass(frozen=True, kw_only=True, eq=False)
class Played:
    """A walk as it is played.

    Attributes:
        graph, walk: the walk.
        timing: which moment of it, as captured, is shown when.
    """

    graph: MotionGraph
    walk: Walk
    timing: TimeWarp

    def motion(self, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses at some times."""
        poses = sample_walk(self.graph, self._captured, self.timing.at(times))
        return replace(poses, frame_rate=EXPORT_RATE)

    def planted(self, plants: Bool[np.ndarray, "F L"], times: np.ndarray) -> np.ndarray:
        """Which feet stand at some times, where either of the two frames says so."""
        frames = frames_at(self.graph, self._captured, self.timing.at(times))
        return plants[frames.low] | plants[frames.high]

    @property
    def _captured(self) -> Walk:
        return Walk(edges=self.walk.edges, scales=np.ones(len(self.walk.edges)))


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
