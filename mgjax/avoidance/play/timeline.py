"""The timeline of edges that the planner plays (§6)."""

from __future__ import annotations

import bisect
import math
from collections import OrderedDict
from dataclasses import dataclass, replace

import jax
import numpy as np
from jaxtyping import Float

from mgjax.avoidance.parry.course import turn_arm
from mgjax.avoidance.parry.guard import guard_of
from mgjax.avoidance.parry.parry import Parry
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.refine import refiner_of
from mgjax.avoidance.refinement.refinement import Refinement, change_motion
from mgjax.core import planar
from mgjax.core.motion import Motion
from mgjax.graph.feet.course import FeetState, at_rest, turned
from mgjax.graph.feet.played import at_times, legs_of, play, with_feet
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk, sample_walk

_KEPT_EDGES = 64
"""Edges of which it is remembered what the feet are off; of others, where they begin."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PlayedFeet:
    """What the feet are off at some moments, s on the planner's clock and in the world. [K]"""

    times: Float[np.ndarray, " K"]
    states: FeetState


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedChange:
    """A change of what is played.

    Attributes:
        change: a refinement, or an arm that parries.
        begins: the moment from which its times are counted, s.
        angle: about the vertical, rad, from its frame to the world.
    """

    change: Refinement | Parry
    begins: float
    angle: float

    @property
    def start(self) -> float:
        """When it begins to show, s."""
        return self.begins + self.change.start

    @property
    def stop(self) -> float:
        """When it no longer shows, s."""
        return self.begins + self.change.stop

    def made(self, graph: MotionGraph, motion: Motion, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses at some times, s on the planner's clock, with the change."""
        own, since = self.change, times - self.begins
        if isinstance(own, Parry):
            return turn_arm(motion, guard_of(graph).arm(own.side), since, own.values, own.start)
        rig = refiner_of(graph).rig
        return change_motion(rig, motion, since, own.values, own.start, angle=self.angle)


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """A stretch of the timeline.

    Attributes:
        walk: its edges.
        begins: when the first of them begins, s.
        start: planar frame of the body there, in the world. [3]
        feet: what the feet are off while it is played; None: the poses are as captured.
        changes: refinements and parries that show in it.
    """

    walk: Walk
    begins: float
    start: Float[np.ndarray, "3"]
    feet: PlayedFeet | None = None
    changes: tuple[PlacedChange, ...] = ()

    def seen_from(self, place: Float[np.ndarray, "3"], moment: float) -> Piece:
        """The same in a planar frame of the world, its times counted from a moment."""
        angle = -float(place[0])
        feet = self.feet
        if feet is not None:
            feet = PlayedFeet(times=feet.times - moment, states=turned(feet.states, angle))
        return replace(
            self,
            begins=self.begins - moment,
            start=np.asarray(planar.compose(planar.inverse(place), self.start)),
            feet=feet,
            changes=tuple(
                replace(c, begins=c.begins - moment, angle=c.angle + angle) for c in self.changes
            ),
        )

    def sample(self, graph: MotionGraph, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses at ascending times, s on the planner's clock."""
        motion = sample_walk(graph, self.walk, times - self.begins, start=self.start)
        if self.feet is not None:
            states = at_times(self.feet.states, self.feet.times, times)
            motion = with_feet(graph, motion, states)
        for change in self.changes:
            motion = change.made(graph, motion, times)
        return motion


class Timeline:
    """The edges that were played or are decided, in the world and on the planner's clock.

    Beside them it has the refinements and parries that were decided on, which show in all that is
    sampled.

    The last stretch of an edge, of one frame, leads to the first pose of the edge that follows (as
    in :func:`mgjax.graph.walk.sample_walk`). So the next edge has to be known at ``deadline``, one
    frame before the end; from then on what is shown is what will be written.

    Feet that stand are kept in place (:mod:`mgjax.graph.feet`). What they are off is followed edge
    by edge, once the edge after it is known, and only as far as poses are asked for.

    Args:
        graph: a motion graph.
        node: where the body stands at the beginning.
        start: its planar frame in the world; default: at the origin, heading +Z.
        begin: the beginning, s.
        feet: what the feet are off then, in the world; default: nothing.
    """

    def __init__(
        self,
        graph: MotionGraph,
        node: int,
        start: Float[np.ndarray, "3"] | None = None,
        begin: float = 0.0,
        feet: FeetState | None = None,
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
        self._feet = [feet or at_rest()]
        self._followed: OrderedDict[tuple[int, bool], PlayedFeet] = OrderedDict()

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
        """Shows a change, if any, instead of all those that begin to show at ``since`` s."""
        self.changes = [c for c in self.changes if c.start < since]
        if change is not None:
            self.changes.append(change)

    def frame_at_end(self) -> Float[np.ndarray, "3"]:
        """Planar frame of the body, in the world, where the last edge arrives."""
        plane = self.graph.node_plane[self.node].astype(np.float64)
        return np.asarray(planar.compose(np.array(self._places[-1]), plane))

    def feet_at_end(self) -> FeetState:
        """What the feet are off, in the world, where the last edge arrives."""
        if not self.edges or legs_of(self.graph) is None:
            return self._feet[0]
        states = self._follow(len(self.edges) - 1).states
        return jax.tree.map(lambda x: x[-1], states)

    def between(self, first: float, last: float, *, feet: bool = False) -> Piece:
        """The edges that are played from ``first`` to ``last`` s, and the next one if decided.

        With ``feet``, what the feet are off then belongs to it.
        """
        a = self._index(first)
        b = min(self._index(last) + 2, len(self.edges))
        edges = np.array(self.edges[a:b])
        return Piece(
            walk=Walk(edges=edges, scales=np.array(self.scales[a:b])),
            begins=self.starts[a],
            start=self._start_of(a),
            feet=self._played_feet(a, self._index(last)) if feet else None,
            changes=tuple(c for c in self.changes if c.start < last and c.stop > first),
        )

    def sample(self, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses in the world at ascending times."""
        return self.between(float(times[0]), float(times[-1]), feet=True).sample(self.graph, times)

    def walk(self) -> Walk:
        """The history as a walk; with ``start`` as its start it gives the poses that are shown,
        but for refinements and parries."""
        return make_walk(self.graph, self.edges, self.scales)

    def _start_of(self, index: int) -> Float[np.ndarray, "3"]:
        """Planar frame of the body, in the world, where an edge begins."""
        plane = self.graph.node_plane[self.graph.edge_source[self.edges[index]]]
        return np.asarray(planar.compose(np.array(self._places[index]), plane.astype(np.float64)))

    def _played_feet(self, first: int, last: int) -> PlayedFeet | None:
        """What the feet are off from the first of these edges to the end of the last."""
        if legs_of(self.graph) is None:
            return None
        parts = [self._follow(index) for index in range(first, last + 1)]
        return PlayedFeet(
            times=np.concatenate([part.times for part in parts]),
            states=jax.tree.map(lambda *x: np.concatenate(x), *[part.states for part in parts]),
        )

    def _follow(self, index: int) -> PlayedFeet:
        """What the feet are off while an edge is played."""
        known = index + 1 < len(self.edges)
        key = (index, known)
        if key in self._followed:
            self._followed.move_to_end(key)
            return self._followed[key]
        while len(self._feet) <= index:
            self._follow(len(self._feet) - 1)
        begin, end = self.starts[index], self.starts[index + 1]
        steps = max(math.ceil((end - begin) * EXPORT_RATE), 1)
        times = np.linspace(0.0, end - begin, steps + 1)
        chosen = slice(index, index + 2)
        states = play(
            self.graph,
            Walk(edges=np.array(self.edges[chosen]), scales=np.array(self.scales[chosen])),
            times,
            rate=steps / (end - begin),
            start=self._start_of(index),
            begin=self._feet[index],
        )[1]
        if known and len(self._feet) == index + 1:
            self._feet.append(jax.tree.map(lambda x: x[-1].copy(), states))  # not a view of all
        self._followed[key] = PlayedFeet(times=begin + times, states=states)
        while len(self._followed) > _KEPT_EDGES:
            self._followed.popitem(last=False)
        return self._followed[key]

    def _index(self, when: float) -> int:
        return min(max(bisect.bisect_right(self.starts, when) - 1, 0), len(self.edges) - 1)


def line_of(graph: MotionGraph, node: int, walk: Walk, feet: FeetState | None = None) -> Timeline:
    """The timeline of a walk that begins at 0 s, in the planar frame of its first node."""
    line = Timeline(graph, node, feet=feet)
    for edge, scale in zip(walk.edges.tolist(), walk.scales.tolist(), strict=True):
        line.append(edge, scale)
    return line
