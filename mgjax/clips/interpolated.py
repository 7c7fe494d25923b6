"""Clips between two clips: motion halfway between parts of one kind that are alike.

Motion between similar clips is near to both, so that a graph with it has transitions where two
clips alone are too far apart (Zhao & Safonova 2009, Achieving good connectivity in motion graphs).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from mgjax.clips.prepare import PreparedClip
from mgjax.clips.types import Label
from mgjax.core import planar, quaternion
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion, sample
from mgjax.core.skeleton import Skeleton

AROUND_S = 0.8
"""So much of the motion before and after a part is interpolated, too, where there is so much."""
STRETCH = 1.5
"""Parts are alike only if neither is longer than so many times the other."""


@dataclass(frozen=True, kw_only=True)
class _Part:
    """A label of a clip, in frames of it."""

    clip: PreparedClip
    start: int
    stop: int
    label: Label


def interpolated(
    skeleton: Skeleton, clips: Sequence[PreparedClip], most_m: float
) -> list[PreparedClip]:
    """A clip halfway between each labelled part and the one that is most like it.

    Both must be of one kind and direction, and both genuine or both not; before one, within it and
    after it time runs evenly, and the bodies stand in the same place, turned the same way, in the
    middle of the parts. Each pair is interpolated once.

    Args:
        skeleton: of the clips.
        clips: with their labels.
        most_m: largest mean distance of joints over the two pieces of motion, m.

    Returns:
        Clips with one label each, named after both.
    """
    parts = [
        _Part(clip=clip, start=int(a), stop=int(b), label=label)
        for clip in clips
        for label, (a, b) in zip(clip.labels, clip.label_frames, strict=True)
    ]
    nearest: dict[int, tuple[float, int, int]] = {}
    for first, second in _alike(parts):
        poses, _ = _aligned(skeleton, parts[first], parts[second])
        places = [forward(skeleton, m.root_translation, m.local_rotations)[0] for m in poses]
        away = float(np.linalg.norm(places[0] - places[1], axis=-1).mean())
        for own in (first, second):
            nearest[own] = min(nearest.get(own, (np.inf, 0, 0)), (away, first, second))
    pairs = sorted({(a, b) for away, a, b in nearest.values() if away <= most_m})
    return [_between(skeleton, parts[a], parts[b]) for a, b in pairs]


def _alike(parts: Sequence[_Part]) -> Iterator[tuple[int, int]]:
    """Pairs that may be interpolated, by number, the first before the second."""
    for first, second in combinations(range(len(parts)), 2):
        one, other = parts[first], parts[second]
        lengths = sorted((one.stop - one.start, other.stop - other.start))
        same = all(
            getattr(one.label, name) == getattr(other.label, name)
            for name in ("kind", "direction", "genuine")
        )
        if same and lengths[1] <= STRETCH * lengths[0]:
            yield first, second


def _aligned(
    skeleton: Skeleton, first: _Part, second: _Part
) -> tuple[tuple[Motion, Motion], tuple[int, int]]:
    """Both pieces of motion at the same moments and in the same place, and where the part lies."""
    parts = (first, second)
    around = round(AROUND_S * first.clip.motion.frame_rate)
    before = min(around, *(part.start for part in parts))
    after = min(around, *(part.clip.motion.num_frames - part.stop for part in parts))
    inside = max(round(sum(part.stop - part.start for part in parts) / 2), 1)
    poses: list[Motion] = []
    for part in parts:
        frames = np.concatenate(
            [
                np.arange(part.start - before, part.start),
                part.start + np.arange(inside) * (part.stop - part.start) / inside,
                np.arange(part.stop, part.stop + after),
            ]
        )
        poses.append(_placed(skeleton, sample(part.clip.motion, frames), before + inside // 2))
    return (poses[0], poses[1]), (before, before + inside)


def _placed(skeleton: Skeleton, motion: Motion, middle: int) -> Motion:
    """The motion moved and turned so that the body stands at the origin in a frame of it."""
    root = np.asarray(motion.root_translation, np.float64)
    turns = np.asarray(motion.local_rotations, np.float64)
    places, _ = forward(skeleton, root[middle], turns[middle])
    back = planar.inverse(np.asarray(planar_frames(skeleton, np.asarray(places))))
    root, turns[:, 0] = planar.apply_pose(back, root, turns[:, 0])
    return replace(motion, root_translation=np.asarray(root), local_rotations=turns)


def _between(skeleton: Skeleton, first: _Part, second: _Part) -> PreparedClip:
    """The clip halfway between two parts."""
    (one, other), (start, stop) = _aligned(skeleton, first, second)
    half = np.full(one.local_rotations.shape[:2], 0.5)
    turns = np.asarray(quaternion.slerp(one.local_rotations, other.local_rotations, half))
    root = (one.root_translation + other.root_translation) / 2
    motion = Motion(
        root_translation=np.asarray(root, np.float32),
        local_rotations=turns.astype(np.float32),
        frame_rate=one.frame_rate,
    )
    rate = one.frame_rate
    names = (f"{part.clip.name}@{part.start / rate:.2f}" for part in (first, second))
    return PreparedClip(
        name="~".join(names),
        motion=motion,
        label_frames=np.array([[start, stop]], np.int64),
        labels=(replace(first.label, start_s=start / rate, end_s=stop / rate),),
    )
