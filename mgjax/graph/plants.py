"""Planted feet: where they are in a graph, and how far they slide."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Int

from mgjax.core.arrays import Array, namespace
from mgjax.core.contacts import floor_steps, foot_joints, planted, stays_planted
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.graph.types import NO_CLIP, MotionGraph


def inherited_frames(
    leave: Int[Array, "*m"], arrive: Int[Array, "*m"], step: Int[Array, "*s"], window: int
) -> Int[Array, "*ms"]:
    """The captured frames whose plants a blend has: the first clip's in its first half.

    Args:
        leave, arrive: frames at which the windows of the two clips begin.
        step: frames of the blend, 0 … ``window``.
        window: frames of the blend.
    """
    return namespace(leave, arrive, step).where(step < window // 2, leave + step, arrive + step)


def planted_frames(graph: MotionGraph) -> Bool[np.ndarray, "F 2"]:
    """In which frames of a graph the left and the right foot should stand still.

    In a clip, where they do. A transition inherits that, from the clip it leaves in its first half
    and from the clip it arrives in in its second: a foot that slides is still a planted one.
    """
    feet = list(foot_joints(graph.skeleton))
    positions = graph.positions[:, feet]
    plants = np.zeros((len(graph.root_translation), 2), dtype=bool)
    for a, b in zip(graph.clip_starts, graph.clip_stops, strict=True):
        plants[a:b] = planted(positions[a:b], graph.frame_rate, scale=graph.body_scale)
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    step = np.arange(graph.window + 1)[None]
    leave = graph.node_frame[graph.edge_source[edges]][:, None]
    arrive = graph.node_frame[graph.edge_target[edges]][:, None] - graph.window
    inherited = inherited_frames(leave, arrive, step, graph.window)
    plants[graph.edge_starts[edges][:, None] + step] = plants[inherited]
    return plants


def walk_plants(
    graph: MotionGraph, plants: Bool[np.ndarray, "G 2"], edges: list[int], frames: int
) -> Bool[np.ndarray, "F 2"]:
    """The planted feet of a walk's first frames.

    Args:
        graph: the graph.
        plants: of its frames; see :func:`planted_frames`.
        edges: of the walk.
        frames: how many.
    """
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
    moved, root = np.asarray(floor_steps(feet)), np.asarray(floor_steps(positions[:, 0]))
    on = np.asarray(stays_planted(plants))
    slid, travelled = float(moved[on].sum()), float((root[:, None] * on).sum())
    return slid / max(len(moved), 1), slid / travelled if travelled > 0 else 0.0
