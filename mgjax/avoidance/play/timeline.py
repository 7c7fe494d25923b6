"""The timeline of edges that the planner plays (§6)."""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.refinement.refine import refiner_of
from mgjax.avoidance.refinement.refinement import Refinement, change_motion
from mgjax.core import planar
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk, sample_walk


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedChange:
    """A refinement of what is played.

    Attributes:
        refinement: the change.
        begins: the moment from which its times are counted, s.
        angle: about the vertical, rad, from its frame to the world.
    """

    refinement: Refinement
    begins: float
    angle: float

    @property
    def start(self) -> float:
        """When it begins to show, s."""
        return self.begins + self.refinement.start

    @property
    def stop(self) -> float:
        """When it no longer shows, s."""
        return self.begins + self.refinement.stop


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """A stretch of the timeline.

    Attributes:
        walk: its edges.
        begins: when the first of them begins, s.
        start: planar frame of the body there, in the world. [3]
        changes: refinements that show in it.
    """

    walk: Walk
    begins: float
    start: Float[np.ndarray, "3"]
    changes: tuple[PlacedChange, ...] = ()

    def seen_from(self, place: Float[np.ndarray, "3"], moment: float) -> Piece:
        """The same in a planar frame of the world, its times counted from a moment."""
        return replace(
            self,
            begins=self.begins - moment,
            start=np.asarray(planar.compose(planar.inverse(place), self.start)),
            changes=tuple(
                replace(c, begins=c.begins - moment, angle=c.angle - float(place[0]))
                for c in self.changes
            ),
        )

    def sample(self, graph: MotionGraph, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses at ascending times."""
        motion = sample_walk(graph, self.walk, times - self.begins, start=self.start)
        for change in self.changes:
            own = change.refinement
            motion = change_motion(
                refiner_of(graph).rig,
                motion,
                times - change.begins,
                own.values,
                own.start,
                angle=change.angle,
            )
        return motion


class Timeline:
    """The edges that were played or are decided, in the world and on the planner's clock.

    Beside them it has the refinements that were decided on, which show in all that is sampled.

    The last stretch of an edge, of one frame, leads to the first pose of the edge that follows (as
    in :func:`mgjax.graph.walk.sample_walk`). So the next edge has to be known at ``deadline``, one
    frame before the end; from then on what is shown is what will be written.

    Args:
        graph: a motion graph.
        node: where the body stands at the beginning.
        start: its planar frame in the world; default: at the origin, heading +Z.
        begin: the beginning, s.
    """

    def __init__(
        self,
        graph: MotionGraph,
        node: int,
        start: Float[np.ndarray, "3"] | None = None,
        begin: float = 0.0,
    ) -> None:
        self.graph = graph
        self.node = node
        self.start = np.zeros(3) if start is None else np.asarray(start, dtype=np.float64)
        self.edges: list[int] = []
        self.scales: list[float] = []
        self.starts = [begin]
        self.changes: list[PlacedChange] = []
        inverse = np.asarray(planar.inverse(graph.node_plane[node].astype(np.float64)))
        self._places = [tuple(float(v) for v in planar.compose(self.start, inverse))]

    @property
    def end(self) -> float:
        """When the last edge ends, s."""
        return self.starts[-1]

    @property
    def deadline(self) -> float:
        """When the edge after the last has to be known, s."""
        if not self.edges:
            return self.end
        return self.end - self.scales[-1] / self.graph.frame_rate

    def append(self, edge: int, scale: float = 1.0) -> None:
        """Plays an edge after the last one, at ``scale`` times its natural duration."""
        turn, x, z = self.graph.edge_exit[edge].tolist()
        theta, x0, z0 = self._places[-1]
        c, s = math.cos(theta), math.sin(theta)
        self.edges.append(edge)
        self.scales.append(scale)
        seconds = float(self.graph.edge_frames[edge] / self.graph.frame_rate * scale)
        self.starts.append(self.end + seconds)
        self._places.append((theta + turn, x * c + z * s + x0, z * c - x * s + z0))
        self.node = int(self.graph.edge_target[edge])

    def change(self, change: PlacedChange | None, since: float) -> None:
        """Shows a refinement, if any, instead of all those that begin to show at ``since`` s."""
        self.changes = [c for c in self.changes if c.start < since]
        if change is not None:
            self.changes.append(change)

    def frame_at_end(self) -> Float[np.ndarray, "3"]:
        """Planar frame of the body, in the world, where the last edge arrives."""
        plane = self.graph.node_plane[self.node].astype(np.float64)
        return np.asarray(planar.compose(np.array(self._places[-1]), plane))

    def between(self, first: float, last: float) -> Piece:
        """The edges that are played from ``first`` to ``last`` s, and the next one if decided."""
        a = self._index(first)
        b = min(self._index(last) + 2, len(self.edges))
        edges = np.array(self.edges[a:b])
        plane = self.graph.node_plane[self.graph.edge_source[edges[0]]].astype(np.float64)
        return Piece(
            walk=Walk(edges=edges, scales=np.array(self.scales[a:b])),
            begins=self.starts[a],
            start=np.asarray(planar.compose(np.array(self._places[a]), plane)),
            changes=tuple(c for c in self.changes if c.start < last and c.stop > first),
        )

    def sample(self, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses in the world at ascending times."""
        return self.between(float(times[0]), float(times[-1])).sample(self.graph, times)

    def walk(self) -> Walk:
        """The history as a walk; with ``start`` as its start it gives the poses that are shown,
        but for refinements."""
        return make_walk(self.graph, self.edges, self.scales)

    def _index(self, when: float) -> int:
        return min(max(bisect.bisect_right(self.starts, when) - 1, 0), len(self.edges) - 1)
