"""The motion graph: nodes, edges, their motion and their labels, as flat arrays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.core.body.height import body_scale
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton

NO_CLIP = -1
"""In ``edge_clip``: the edge is a transition."""
_LOT = 1024
"""Frames that forward kinematics takes at a time: so many fit into caches."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionGraph:
    """Pieces of motion and which can follow which.

    All frames lie on one axis: first those of the clips, then those of the transitions. An edge
    plays the frames ``edge_starts … edge_stops − 1``; frame ``edge_stops`` is also there and is
    the pose at which the edge arrives, so that poses between frames can be read up to the end.

    Every node belongs to a clip, and its coordinates are that clip's. A transition's frames are in
    the coordinates of the clip it leaves; ``edge_exit`` maps the coordinates of the clip it arrives
    in to them (see :mod:`mgjax.core.planar`). For a piece of a clip it is the identity.

    Attributes:
        skeleton: of all motion.
        frame_rate: frames per second.
        window: frames of a compared and blended window.
        root_translation, local_rotations: the poses, m and unit quaternions.
        clip_names, clip_starts, clip_stops: the clips on the axis of frames. [K]
        node_frame, node_clip: the frame at which a node stands. [N]
        node_plane: the planar frame of the body at the node, in the clip's coordinates. [N, 3]
        edge_source, edge_target: nodes. [E]
        edge_starts, edge_stops: frames. [E]
        edge_clip: the clip, or ``NO_CLIP`` for a transition. [E]
        edge_exit: planar transform after the edge. [E, 3]
        edge_distance: distance of a transition's windows, m; 0 for a piece of a clip. [E]
        out_first, out_edges: the edges out of node n are out_edges[out_first[n]:out_first[n+1]].
        label_edge: the edge that holds a labelled part. [P]
        label_starts, label_stops: its frames, less those that blends overlap, as many at either
            end. [P]
        label_kind, label_direction: what it is. [P]
        label_genuine: a real evasion, not an exercise that resembles one. [P]
        report: how the graph came about, as JSON values.
    """

    skeleton: Skeleton
    frame_rate: float
    window: int
    root_translation: Float[np.ndarray, "F 3"]
    local_rotations: Float[np.ndarray, "F J 4"]
    clip_names: tuple[str, ...]
    clip_starts: Int[np.ndarray, " K"]
    clip_stops: Int[np.ndarray, " K"]
    node_frame: Int[np.ndarray, " N"]
    node_clip: Int[np.ndarray, " N"]
    node_plane: Float[np.ndarray, "N 3"]
    edge_source: Int[np.ndarray, " E"]
    edge_target: Int[np.ndarray, " E"]
    edge_starts: Int[np.ndarray, " E"]
    edge_stops: Int[np.ndarray, " E"]
    edge_clip: Int[np.ndarray, " E"]
    edge_exit: Float[np.ndarray, "E 3"]
    edge_distance: Float[np.ndarray, " E"]
    out_first: Int[np.ndarray, " N1"]
    out_edges: Int[np.ndarray, " E"]
    label_edge: Int[np.ndarray, " P"]
    label_starts: Int[np.ndarray, " P"]
    label_stops: Int[np.ndarray, " P"]
    label_kind: tuple[str, ...]
    label_direction: tuple[str, ...]
    label_genuine: Bool[np.ndarray, " P"]
    report: dict[str, Any]

    @property
    def num_nodes(self) -> int:
        return len(self.node_frame)

    @property
    def num_edges(self) -> int:
        return len(self.edge_source)

    @cached_property
    def edge_frames(self) -> Int[np.ndarray, " E"]:
        """Frames that each edge plays."""
        return self.edge_stops - self.edge_starts

    @cached_property
    def positions(self) -> Float[np.ndarray, "F J 3"]:
        """Joint positions of all frames, in the coordinates of their clips, m."""
        kind = np.result_type(self.root_translation, self.local_rotations, self.skeleton.offsets)
        places = np.empty((*self.local_rotations.shape[:2], 3), kind)
        for first in range(0, len(places), _LOT):
            lot = slice(first, first + _LOT)
            poses = self.root_translation[lot], self.local_rotations[lot]
            places[lot] = forward(self.skeleton, *poses)[0]
        return places

    @cached_property
    def body_scale(self) -> float:
        """How large the body is; see :func:`mgjax.core.body.height.body_scale`."""
        return body_scale(self.skeleton)

    @cached_property
    def plants(self) -> Bool[np.ndarray, "F 2"]:
        """In which frames the left and the right foot stand: see :mod:`mgjax.graph.plants`."""
        from mgjax.graph.plants import planted_frames  # it is written for this class

        return planted_frames(self)

    def edges_from(self, node: int) -> Int[np.ndarray, " M"]:
        """The edges that leave a node."""
        return self.out_edges[self.out_first[node] : self.out_first[node + 1]]


NO_EDGE = -1
"""Pads the walks of candidates."""
