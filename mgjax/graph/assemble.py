"""Nodes, edges and labels from the transitions that are left."""

from __future__ import annotations

from typing import Any

import numpy as np

from mgjax.core.body.height import body_scale
from mgjax.core.kinematics import planar_frames
from mgjax.graph.config import GraphConfig
from mgjax.graph.pruning.prune import (
    Candidates,
)
from mgjax.graph.timeline import ClipTimeline
from mgjax.graph.types import NO_CLIP, MotionGraph


def assemble(
    timeline: ClipTimeline,
    candidates: Candidates,
    kept: np.ndarray,
    blended: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    window: int,
    config: GraphConfig,
    report: dict[str, Any],
) -> MotionGraph:
    """The graph of the transitions that were kept, and its statistics in ``report``."""
    roots, rotations, transforms, slides = blended
    leave, arrive = candidates.leave[kept], candidates.arrive[kept]
    frames = np.unique(np.concatenate([leave, arrive]))
    clip = np.searchsorted(timeline.starts, frames, side="right") - 1
    along = np.flatnonzero(clip[1:] == clip[:-1])
    first = len(timeline.root) + np.arange(len(kept)) * (window + 1)
    source = np.concatenate([along, np.searchsorted(frames, leave)])
    target = np.concatenate([along + 1, np.searchsorted(frames, arrive)])
    edge_starts = np.concatenate([frames[along], first])
    edge_stops = np.concatenate([frames[along + 1], first + window])
    edge_clip = np.concatenate([clip[along], np.full(len(kept), NO_CLIP)])
    distances = body_scale(timeline.skeleton) * candidates.distances[kept]
    distances = np.concatenate([np.zeros(len(along)), distances])
    exits = np.concatenate([np.zeros((len(along), 3)), transforms]).astype(np.float32)
    order = np.argsort(source, kind="stable")
    out_first = np.concatenate([[0], np.cumsum(np.bincount(source, minlength=len(frames)))])
    # A label belongs to the one piece of a clip that holds its core whole.
    at = np.searchsorted(edge_starts[: len(along)], timeline.core_starts, side="right") - 1
    piece = np.maximum(at, 0)
    holds = (at >= 0) & (timeline.core_stops <= edge_stops[piece])
    # What blends overlap of its ends is cut off on both sides alike, so that its middle stays.
    cut = np.maximum(
        edge_starts[piece] - timeline.label_starts, timeline.label_stops - edge_stops[piece]
    ).clip(0)
    label_starts, label_stops = timeline.label_starts + cut, timeline.label_stops - cut
    inside = np.flatnonzero(holds)
    genuine = np.array([label.genuine for label in timeline.labels], dtype=bool)
    middle = (timeline.label_starts + timeline.label_stops) / 2 - edge_starts[piece]
    enterable = holds & (middle <= config.horizon_s * config.frame_rate)
    report.update(
        frames=int((timeline.stops - timeline.starts).sum()),
        transitions=len(kept),
        nodes=len(frames),
        edges=len(source),
        labels_kept=int(holds.sum()),
        labels_enterable=int(enterable.sum()),
        # As they were given; the graph's own leave out what blends overlap.
        label_frames=np.stack([timeline.label_starts, timeline.label_stops], axis=1)[
            inside
        ].tolist(),
        genuine_total=int(genuine.sum()),
        genuine_kept=int((holds & genuine).sum()),
        genuine_enterable=int((enterable & genuine).sum()),
        foot_slide_before=float(slides[:, 0].mean()),
        foot_slide_after=float(slides[:, 1].mean()),
    )
    node_plane = planar_frames(timeline.skeleton, timeline.positions[frames])
    return MotionGraph(
        skeleton=timeline.skeleton,
        frame_rate=config.frame_rate,
        window=window,
        root_translation=np.concatenate([timeline.root, roots.reshape(-1, 3)]).astype(np.float32),
        local_rotations=np.concatenate(
            [timeline.rotations, rotations.reshape(-1, *rotations.shape[2:])]
        ).astype(np.float32),
        clip_names=tuple(c.name for c in timeline.clips),
        clip_starts=timeline.starts,
        clip_stops=timeline.stops,
        node_frame=frames,
        node_clip=clip,
        node_plane=np.asarray(node_plane, dtype=np.float32),
        edge_source=source,
        edge_target=target,
        edge_starts=edge_starts,
        edge_stops=edge_stops,
        edge_clip=edge_clip,
        edge_exit=exits,
        edge_distance=distances.astype(np.float32),
        out_first=out_first,
        out_edges=order,
        label_edge=at[inside],
        label_starts=label_starts[inside],
        label_stops=label_stops[inside],
        label_kind=tuple(timeline.labels[i].kind for i in inside),
        label_direction=tuple(timeline.labels[i].direction for i in inside),
        label_genuine=genuine[inside],
        report=report,
    )
