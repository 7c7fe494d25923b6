"""Kicks for the experiments: captured with their labels, or the embedded ones."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mgjax.clips.folder import load_clips
from mgjax.clips.oddities import first_clean_frame
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.clips.types import Clip
from mgjax.core.kinematics import global_positions, joint_velocities
from mgjax.core.motion import cut


@dataclass(frozen=True, kw_only=True)
class Kick:
    """A labelled kick: the foot and the moment of its greatest speed, s from the first frame."""

    foot: str
    kind: str
    peak_s: float


def captured(folder: str, exclude: tuple[str, ...]) -> list[Clip]:
    """The clips below a folder; "" for none."""
    return load_clips(folder, exclude=exclude)[0] if folder else []


def captured_kicks(folder: str) -> dict[str, list[Kick]]:
    """The labelled kicks of the folder's ``labels.json`` by clip name."""
    document = json.loads((Path(folder) / "labels.json").read_text(encoding="utf-8"))
    return {
        name: [Kick(foot=k["foot"], kind=k["kind"], peak_s=k["peak_s"]) for k in kicks]
        for name, kicks in document["clips"].items()
    }


def embedded_kicks(seed: int, frame_rate: float) -> tuple[list[Clip], dict[str, list[Kick]]]:
    """The embedded clips and their kicks; the peak is the fastest frame of the labelled toe."""
    clips, labels = synthetic_kicks(seed=seed, frame_rate=frame_rate)
    kicks: dict[str, list[Kick]] = {}
    for clip in clips:
        positions = np.asarray(global_positions(clip.skeleton, clip.motion))
        kicks[clip.name] = []
        for label in labels.get(clip.name, ()):
            toe = clip.skeleton.index(f"{label.direction[0]}toes")
            speed = np.linalg.norm(
                np.asarray(joint_velocities(positions[:, [toe]], frame_rate))[:, 0], axis=-1
            )
            a, b = round(label.start_s * frame_rate), round(label.end_s * frame_rate)
            peak = (a + int(np.argmax(speed[a:b]))) / frame_rate
            kicks[clip.name].append(Kick(foot=label.direction, kind=label.kind, peak_s=peak))
    return clips, kicks


def without_t_pose(clip: Clip) -> tuple[Clip, int]:
    """The clip without a T-pose at its beginning, and the frames cut off."""
    first = first_clean_frame(clip.skeleton, clip.motion)
    motion = cut(clip.motion, first, clip.motion.num_frames) if first else clip.motion
    return Clip(name=clip.name, skeleton=clip.skeleton, motion=motion), first
