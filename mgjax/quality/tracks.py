"""Motions as the measures see them: places of joints at fixed rates, padded to one length."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, resample
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.core.xla.pytree import register
from mgjax.quality.subject import Subject

RATE = 30.0
"""Frames per second at which all but skating is measured."""
SKATE_RATE = 20.0
"""Frames per second at which skating is."""
LEAST_FRAMES = 56
"""Motions are padded to this times a power of four."""
MOST_FRAMES = 1 << 14
"""Frames of motions that are measured at once."""


@register()
@dataclass(frozen=True, kw_only=True, eq=False)
class Tracks:
    """M motions of one skeleton, or pieces of them.

    Attributes:
        places: of all joints at 30 frames per second, m. [M, F, J, 3]
        turns: their local rotations. [M, F, J, 4]
        counts: frames of each that are there. [M]
        spans: first and last of those that are counted; the others are there so that windows around
            these are whole. [M, 2]
        toes: places of the left and right toe at 20 frames per second. [M, G, 2, 3]
        toe_counts, toe_spans: likewise, of these. [M], [M, 2]
        rests: heights of toes and ankles where they rest, m. [M, 4]
    """

    places: Float[Array, "*m F J 3"]
    turns: Float[Array, "*m F J 4"]
    counts: Int[Array, "*m"]
    spans: Int[Array, "*m 2"]
    toes: Float[Array, "*m G K 3"]
    toe_counts: Int[Array, "*m"]
    toe_spans: Int[Array, "*m 2"]
    rests: Float[Array, "*m R"]

    def take(self, rows: np.ndarray) -> Tracks:
        """Some of them."""
        return Tracks(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})


def make_tracks(
    skeleton: Skeleton,
    subject: Subject,
    motions: Sequence[Motion],
    *,
    spans_s: Sequence[tuple[float, float]] | None = None,
    rests: Sequence[np.ndarray] | None = None,
) -> Tracks:
    """Tracks of motions at any rates; padded to the longest, and to one of few lengths.

    Places are computed with double precision and moved over the floor to the origin, which changes
    no measure and keeps their differences exact.

    Args:
        skeleton: of all motions.
        subject: made of it.
        motions: with two frames or more.
        spans_s: seconds between which frames are counted, of each; default: all of them.
        rests: where toes and ankles rest in each, m; default: the lowest 1 % of each joint's own
            heights there.

    Raises:
        MotionError: a motion with fewer than two frames at 30 per second.
    """
    rows = [
        _track(
            skeleton,
            subject,
            motion,
            None if spans_s is None else spans_s[i],
            None if rests is None else rests[i],
        )
        for i, motion in enumerate(motions)
    ]
    sizes = {
        name: bucket_size(max(len(row[name]) for row in rows), LEAST_FRAMES, 4)
        for name in ("places", "toes")
    }
    sizes["turns"] = sizes["places"]
    return Tracks(
        **{
            name: np.stack(
                [pad_axis(row[name], sizes[name]) if name in sizes else row[name] for row in rows]
            )
            for name in rows[0]
        }
    )


def resting(skeleton: Skeleton, subject: Subject, motion: Motion) -> Float[np.ndarray, " K"]:
    """Heights at which toes and ankles rest in a motion, m: the lowest 1 % of each."""
    heights = _places(skeleton, resample(motion, RATE))[:, np.asarray(subject.feet), 1]
    return _lowest(heights)


def in_groups(
    skeleton: Skeleton,
    subject: Subject,
    motions: Sequence[Motion],
    *,
    spans_s: Sequence[tuple[float, float]] | None = None,
    rests: Sequence[np.ndarray] | None = None,
) -> Iterator[tuple[Tracks, Int[np.ndarray, " m"]]]:
    """All motions as tracks, those of similar length together; and which they are.

    The tracks are padded to one of few numbers of motions, too: those after the named ones repeat
    the last of them. See :func:`make_tracks` for the arguments.
    """
    lengths = [bucket_size(int(m.seconds * RATE) + 1, LEAST_FRAMES, 4) for m in motions]
    for length in sorted(set(lengths)):
        members = np.flatnonzero(np.array(lengths) == length)
        most = max(MOST_FRAMES // length, 1)
        for i in range(0, len(members), most):
            chosen = members[i : i + most]
            tracks = make_tracks(
                skeleton,
                subject,
                [motions[k] for k in chosen],
                spans_s=None if spans_s is None else [spans_s[k] for k in chosen],
                rests=None if rests is None else [rests[k] for k in chosen],
            )
            size = min(bucket_size(len(chosen), 1, 4), most)
            yield tracks.take(pad_axis(np.arange(len(chosen)), size)), chosen


def _track(
    skeleton: Skeleton,
    subject: Subject,
    motion: Motion,
    span_s: tuple[float, float] | None,
    rests: np.ndarray | None,
) -> dict[str, np.ndarray]:
    fine = resample(motion, RATE)
    if fine.num_frames < 2:
        got = f"a motion of {motion.num_frames} frames at {motion.frame_rate:g} per second"
        raise MotionError(got=got, expected="two frames or more at 30 per second")
    feet = np.asarray(subject.feet)
    places = _places(skeleton, fine)
    middle = places[0, 0] * [1, 0, 1]
    toes = _places(skeleton, resample(motion, SKATE_RATE))[:, feet[:2]]
    if rests is None:
        rests = _lowest(places[:, feet, 1])
    return {
        "places": (places - middle).astype(np.float32),
        "turns": np.asarray(fine.local_rotations, np.float32),
        "counts": np.int32(len(places)),
        "spans": span_frames(span_s, RATE, len(places)),
        "toes": (toes - middle).astype(np.float32),
        "toe_counts": np.int32(len(toes)),
        "toe_spans": span_frames(span_s, SKATE_RATE, len(toes)),
        "rests": rests.astype(np.float32),
    }  # pyright: ignore[reportReturnType]


def _lowest(heights: np.ndarray) -> np.ndarray:
    return np.quantile(heights, 0.01, axis=0)


def span_frames(
    span_s: tuple[float, float] | None, rate: float, count: int
) -> Int[np.ndarray, "2"]:
    """First and last frame that are not outside of the span."""
    if span_s is None:
        return np.array([0, count - 1], np.int32)
    start, end = span_s
    first, last = np.ceil(start * rate - 1e-6), np.floor(end * rate + 1e-6)
    return np.clip([first, last], 0, count - 1).astype(np.int32)


def _places(skeleton: Skeleton, motion: Motion) -> np.ndarray:
    """[F, J, 3] with double precision."""
    double = Motion(
        root_translation=np.asarray(motion.root_translation, np.float64),
        local_rotations=np.asarray(motion.local_rotations, np.float64),
        frame_rate=motion.frame_rate,
        joint_offsets=motion.joint_offsets,
    )
    return np.asarray(global_positions(skeleton, double))
