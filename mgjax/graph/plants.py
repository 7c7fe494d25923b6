"""How far planted feet slide."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from jaxtyping import Bool

from mgjax.core.contacts import foot_joints, planted
from mgjax.core.kinematics import forward, global_positions
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.graph.types import NO_CLIP, MotionGraph


@lru_cache(maxsize=8)
def planted_frames(graph: MotionGraph) -> Bool[np.ndarray, "F 2"]:
    """In which frames of a graph the left and the right foot should stand still.

    In a clip, where they do. A transition inherits that, from the clip it leaves in its first half
    and from the clip it arrives in in its second: a foot that slides is still a planted one.
    """
    feet = list(foot_joints(graph.skeleton))
    stop = int(graph.clip_stops[-1])
    root, rotations = graph.root_translation[:stop], graph.local_rotations[:stop]
    positions = np.asarray(forward(graph.skeleton, root, rotations)[0])[:, feet]
    plants = np.zeros((len(graph.root_translation), 2), dtype=bool)
    for a, b in zip(graph.clip_starts, graph.clip_stops, strict=True):
        plants[a:b] = planted(positions[a:b], graph.frame_rate)
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    window, half = graph.window, graph.window // 2
    step = np.arange(window + 1)
    leave = graph.node_frame[graph.edge_source[edges]][:, None] + step
    arrive = graph.node_frame[graph.edge_target[edges]][:, None] - window + step
    inherited = np.where(step < half, leave, arrive)
    plants[graph.edge_starts[edges][:, None] + step] = plants[inherited]
    return plants


def walk_plants(graph: MotionGraph, edges: list[int], frames: int) -> Bool[np.ndarray, "F 2"]:
    """The planted feet of a walk's first frames."""
    plants = planted_frames(graph)
    spans = [np.arange(graph.edge_starts[e], graph.edge_stops[e]) for e in edges]
    return plants[np.concatenate([*spans, [graph.edge_stops[edges[-1]]]])[:frames]]


def foot_slide(
    skeleton: Skeleton, motion: Motion, plants: Bool[np.ndarray, "F 2"]
) -> tuple[float, float]:
    """Slide of a motion's planted feet.

    Returns:
        Metres per frame, both feet together; and metres that a foot travels over the floor while
        planted, by the metres that the root travels meanwhile (0 for a motion without stances).
    """
    positions = np.asarray(global_positions(skeleton, motion), dtype=np.float64)
    feet = positions[:, list(foot_joints(skeleton))]
    moved = np.linalg.norm(np.diff(feet[..., ::2], axis=0), axis=-1)
    root = np.linalg.norm(np.diff(positions[:, 0, ::2], axis=0), axis=-1)
    on = plants[1:] & plants[:-1]
    slid, way = float(moved[on].sum()), float((root[:, None] * on).sum())
    return slid / max(len(moved), 1), slid / way if way > 0 else 0.0
