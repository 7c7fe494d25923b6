"""A body that stands still, and balls at it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.core.body.roles import require_roles
from mgjax.core.kinematics import forward, planar_frames
from mgjax.graph.transition import frame_positions
from mgjax.graph.types import MotionGraph
from tests.avoidance.made import make_graph

CONFIG = AvoidanceConfig()


def still_graph() -> MotionGraph:
    """An edge on which a body stands with bent knees for 3 s, and one in which joints turn."""
    graph = make_graph([(0, 0, 90), (0, 0, 120)], [(0, 40, 50)], sway=0.05, seed=3)
    rotations, root = graph.local_rotations.copy(), graph.root_translation.copy()
    skeleton = graph.skeleton
    still = np.zeros_like(rotations[0])
    still[:, 0] = 1
    for side in ("left", "right"):
        for joint, degrees in (
            (f"{side}_hip", -25.0),
            (f"{side}_knee", 50.0),
            (f"{side}_ankle", -25.0),
        ):
            half = 0.5 * np.radians(degrees)
            still[_joint(graph, joint)] = (np.cos(half), np.sin(half), 0, 0)
    places, _ = forward(skeleton, np.zeros((1, 3), np.float32), still[None])
    rotations[:91], root[:91] = still, (0, -np.asarray(places)[0, :, 1].min(), 0)
    positions = frame_positions(skeleton, root, rotations)
    return replace(
        graph,
        local_rotations=rotations,
        root_translation=root,
        node_plane=np.asarray(planar_frames(skeleton, positions[:1]), np.float32),
        edge_exit=np.zeros_like(graph.edge_exit),
    )


def _joint(graph: MotionGraph, role: str) -> int:
    return require_roles(graph.skeleton, (role,))[0]


def asked(graph: MotionGraph) -> tuple[Prepared, AvoidanceConfig]:
    """The graph prepared, and settings of its body."""
    return prepared_for(graph, CONFIG), for_body(CONFIG, graph.body_scale)
