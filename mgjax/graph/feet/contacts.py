"""When heels and toes stand: read from the capture, carried into what is played."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.kinematics import joint_velocities
from mgjax.graph.cache import cached
from mgjax.graph.feet.legs import foot_chains
from mgjax.graph.plants import inherited_frames
from mgjax.graph.types import NO_CLIP, MotionGraph

LOWEST = 0.02
"""Share of a clip's frames in which a point of a foot is as low as its floor."""
ABOVE_M = 0.03
"""A point of an adult's foot stands below this height over its floor, m."""
SPEED_M_S = 0.2
"""A point of an adult's foot stands below this speed, m/s."""
HIGHEST_M = 0.03
"""A clip's floor under a point of an adult's foot is at most so far above that of the other clips:
in some clips a foot never stands."""
_GAP_S = 0.07
"""Shorter gaps in a stance are closed: the speed of a standing foot trembles around its limit."""


def foot_points(graph: MotionGraph) -> tuple[tuple[int, int], tuple[int, int]]:
    """The two points of each foot: its ball and its ankle, of the left and the right foot.

    Raises:
        SkeletonError: a joint of the legs is missing.
    """
    chains = foot_chains(graph.skeleton)
    return (chains.balls[0], chains.ankles[0]), (chains.balls[1], chains.ankles[1])


def floors(graph: MotionGraph) -> Float[np.ndarray, "K 2 2"]:
    """The height at which balls and ankles stand in each clip, m.

    It is the lowest hundredths of each point's own height (:data:`LOWEST`): calibration shifts a
    foot of one clip by centimetres against that of another.
    """
    heights = graph.positions[:, foot_points(graph), 1]
    own = np.array(
        [
            np.quantile(heights[a:b], LOWEST, axis=0)
            for a, b in zip(graph.clip_starts, graph.clip_stops, strict=True)
        ]
    )
    return np.minimum(own, np.median(own, axis=0) + graph.body_scale * HIGHEST_M)


def standing_points(graph: MotionGraph) -> Bool[np.ndarray, "F 2 2"]:
    """In which frames of a graph the ball and the ankle of the left and the right foot stand.

    In a clip, where they are low over their floor and slow; a transition inherits that from the
    clip it leaves in its first half and from the clip it arrives in in its second. It is a
    heuristic, with an error of its own.
    """
    return cached(graph, ("feet", "standing"), lambda: _standing_points(graph))


def _standing_points(graph: MotionGraph) -> Bool[np.ndarray, "F 2 2"]:
    points = graph.positions[:, foot_points(graph)]  # [F, 2, 2, 3]
    floor, scale, rate = floors(graph), graph.body_scale, graph.frame_rate
    stands = np.zeros(points.shape[:3], dtype=bool)
    for clip, (a, b) in enumerate(zip(graph.clip_starts, graph.clip_stops, strict=True)):
        own = points[a:b]
        speed = joint_velocities(own.reshape(b - a, 4, 3), rate).reshape(own.shape)
        low = own[..., 1] < floor[clip] + scale * ABOVE_M
        slow = (speed * speed).sum(axis=-1) < (scale * SPEED_M_S) ** 2
        stands[a:b] = _closed(low & slow, low, max(round(_GAP_S * rate), 1))
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    step = np.arange(graph.window + 1)[None]
    leave = graph.node_frame[graph.edge_source[edges]][:, None]
    arrive = graph.node_frame[graph.edge_target[edges]][:, None] - graph.window
    inherited = inherited_frames(leave, arrive, step, graph.window)
    stands[graph.edge_starts[edges][:, None] + step] = stands[inherited]
    return stands


def _closed(
    stands: Bool[np.ndarray, "F 2 2"], low: Bool[np.ndarray, "F 2 2"], gap: int
) -> Bool[np.ndarray, "F 2 2"]:
    """Fills gaps of up to ``gap`` frames between stances in which the point stays low."""
    closed = stands.copy()
    for foot in range(2):
        for point in range(2):
            on = np.flatnonzero(stands[:, foot, point])
            for before, after in zip(on[:-1], on[1:], strict=True):
                if 1 < after - before <= gap + 1 and low[before:after, foot, point].all():
                    closed[before:after, foot, point] = True
    return closed
