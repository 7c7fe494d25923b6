"""The walk that a reach is put on: where the body is in each frame, and how it stands there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from mgjax.core import planar
from mgjax.core.kinematics import global_positions, planar_frames
from mgjax.core.motion import Motion
from mgjax.graph.feet.played import play_walk
from mgjax.graph.plants import walk_plants
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk, place_edges
from mgjax.hybrid.prepared import Prepared, ReachBody


@dataclass(frozen=True, kw_only=True, eq=False)
class SampledWalk:
    """A walk, played up to some frame.

    Attributes:
        graph: whose edges it has.
        prepared: state of the graph, for reaching.
        edges: of the walk.
        frames: played; the motion has one pose more.
        start: planar frame of the body at the beginning. [3]
        motion: the poses.
        positions: of all joints, m. [F, J, 3]
        planes: planar frame of the body in each frame. [F, 3]
        plants: whether the left and the right foot stand still. [F, 2]
    """

    graph: MotionGraph
    prepared: Prepared
    edges: tuple[int, ...]
    frames: int
    start: Float[np.ndarray, "3"]
    motion: Motion
    positions: Float[np.ndarray, "F J 3"]
    planes: Float[np.ndarray, "F 3"]
    plants: Bool[np.ndarray, "F 2"]

    @property
    def body(self) -> ReachBody:
        """The body as reaching reads it."""
        return self.prepared.reach_body

    def with_edges(self, edges: tuple[int, ...], frames: int) -> SampledWalk:
        """The first frames of a walk along other edges from the same beginning."""
        return make_sampled_walk(self.graph, self.prepared, edges, frames, self.start)

    def edge_at(self, frame: int) -> int:
        """Number of the edge that is played at a frame, counted from 0."""
        ends = np.cumsum(self.graph.edge_frames[list(self.edges)])
        return int(min(np.searchsorted(ends, frame, side="right"), len(self.edges) - 1))

    def frame_of(self, number: int) -> int:
        """The frame at which so many edges are over."""
        return int(self.graph.edge_frames[list(self.edges[:number])].sum())

    def plane_after(self, number: int) -> Float[np.ndarray, "3"]:
        """Planar frame of the body where so many edges are over, at the node that they lead to."""
        if number == 0:
            return self.start
        graph, edge = self.graph, self.edges[number - 1]
        place = place_edges(graph, np.array(self.edges[:number]), self.start)[-1]
        after = planar.compose(place, graph.edge_exit[edge].astype(np.float64))
        node = graph.node_plane[graph.edge_target[edge]].astype(np.float64)
        return np.asarray(planar.compose(np.asarray(after), node))

    def node_after(self, number: int) -> int:
        """The node to which so many edges lead."""
        if number == 0:
            return int(self.graph.edge_source[self.edges[0]])
        return int(self.graph.edge_target[self.edges[number - 1]])


def make_sampled_walk(
    graph: MotionGraph,
    prepared: Prepared,
    edges: tuple[int, ...],
    frames: int,
    start: Float[np.ndarray, "3"],
) -> SampledWalk:
    """The first frames of a walk as sampled; edges after them are left out."""
    ends = np.cumsum(graph.edge_frames[list(edges)])
    kept = edges[: int(np.searchsorted(ends, frames)) + 1]
    frames = int(min(frames, ends[len(kept) - 1]))
    walk = make_walk(graph, kept)
    motion = play_walk(graph, walk, np.arange(frames + 1) / graph.frame_rate, start=start)
    positions = np.asarray(global_positions(graph.skeleton, motion), np.float64)
    return SampledWalk(
        graph=graph,
        prepared=prepared,
        edges=kept,
        frames=frames,
        start=start,
        motion=motion,
        positions=positions,
        planes=np.asarray(planar_frames(graph.skeleton, positions)),
        plants=walk_plants(graph, prepared.plants, list(kept), frames + 1),
    )
