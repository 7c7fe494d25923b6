"""All clips of a graph on one axis of frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgjax.clips.interpolated import interpolated
from mgjax.clips.prepare import PreparedClip, graph_skeleton, prepare_clips
from mgjax.clips.types import Clip, Label, Labels
from mgjax.core.body.height import body_scale
from mgjax.core.body.rest import standing_rest
from mgjax.core.body.roles import find_role
from mgjax.core.contacts import foot_joints, planted
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.graph.config import GraphConfig
from mgjax.graph.parts.margins import label_margins
from mgjax.graph.transition import frame_positions


@dataclass(frozen=True, kw_only=True)
class ClipTimeline:
    """All prepared clips on one axis of frames.

    ``core_starts`` and ``core_stops`` are what is left of the labels without the margins that
    blends may overlap; ``between`` of the clips, the last ones, are interpolated.
    """

    skeleton: Skeleton
    clips: list[PreparedClip]
    starts: np.ndarray
    stops: np.ndarray
    root: np.ndarray
    rotations: np.ndarray
    positions: np.ndarray
    plants: np.ndarray
    label_starts: np.ndarray
    label_stops: np.ndarray
    core_starts: np.ndarray
    core_stops: np.ndarray
    labels: list[Label]
    between: int


def make_timeline(
    clips: list[Clip],
    labels: Labels,
    skeleton: Skeleton,
    config: GraphConfig,
    example: Motion | None = None,
) -> tuple[ClipTimeline, list[str]]:
    """Prepares clips and lays them out; notes say what was changed.

    ``example``: a motion of the skeleton, for retargeting.
    """
    if example is not None and (rest := standing_rest(skeleton)) is not None:
        example = rest.motion(example)
    skeleton = graph_skeleton(skeleton)
    prepared, notes = prepare_clips(
        clips,
        labels,
        skeleton=skeleton,
        frame_rate=config.frame_rate,
        mirrored=config.mirror,
        retarget=config.retarget,
        example=example,
    )
    between: list[PreparedClip] = []
    if config.interpolate_m > 0:
        between = interpolated(skeleton, prepared, config.interpolate_m * body_scale(skeleton))
        prepared += between
        notes.append(f"{len(between)} clips interpolated between parts that are alike")
    lengths = np.array([c.motion.num_frames for c in prepared])
    stops = np.cumsum(lengths)
    starts = stops - lengths
    root = np.concatenate([_centred(np.asarray(c.motion.root_translation)) for c in prepared])
    rotations = np.concatenate([np.asarray(c.motion.local_rotations) for c in prepared])
    positions = frame_positions(skeleton, root, rotations)
    plants = _plants(skeleton, positions, starts, stops, config.frame_rate)
    frames = np.concatenate(
        [c.label_frames + a for c, a in zip(prepared, starts, strict=True)]
    ).astype(np.int64)
    margins = label_margins(
        positions, frames, quiet=config.label_quiet, overlap=config.label_overlap
    )
    timeline = ClipTimeline(
        skeleton=skeleton,
        clips=prepared,
        starts=starts,
        stops=stops,
        root=root,
        rotations=rotations,
        positions=positions,
        plants=plants,
        label_starts=frames[:, 0],
        label_stops=frames[:, 1],
        core_starts=frames[:, 0] + margins[:, 0],
        core_stops=frames[:, 1] - margins[:, 1],
        labels=[label for c in prepared for label in c.labels],
        between=len(between),
    )
    return timeline, notes


def _plants(
    skeleton: Skeleton,
    positions: np.ndarray,
    starts: np.ndarray,
    stops: np.ndarray,
    frame_rate: float,
) -> np.ndarray:
    """[F,2] when each foot is planted; never, where there are no legs."""
    if find_role(skeleton, "left_ankle") is None or find_role(skeleton, "right_ankle") is None:
        return np.zeros((len(positions), 2), dtype=bool)
    feet = list(foot_joints(skeleton))
    scale = body_scale(skeleton)
    return np.concatenate(
        [
            planted(positions[a:b, feet], frame_rate, scale=scale)
            for a, b in zip(starts, stops, strict=True)
        ]
    )


def _centred(root: np.ndarray) -> np.ndarray:
    """Moves a clip to the middle of the floor: nothing depends on where it was captured."""
    middle = root.astype(np.float64).mean(axis=0) * [1, 0, 1]
    return (root - middle).astype(np.float32)
