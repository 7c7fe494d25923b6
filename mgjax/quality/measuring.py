"""How good one motion is, beside capture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import SkeletonError
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, first_difference
from mgjax.core.xla.padding import bucket_size
from mgjax.quality.kernel import Curves, measured, measured_curves, no_extremes, speeds
from mgjax.quality.known import Captured, speed_distances
from mgjax.quality.result import NEEDS_CAPTURE, Quality, faults_of, percentiles
from mgjax.quality.same_joints import in_order_of
from mgjax.quality.subject import Subject, subject_of
from mgjax.quality.tracks import RATE, SKATE_RATE, Tracks, in_groups, make_tracks, span_frames

OTHER = "the capture has other joints: nothing is said of jerk, angles and speeds beside it"
SLOW = "fewer than 30 frames a second: poses between them are interpolated, which costs smoothness"


def measure(
    skeleton: Skeleton,
    motion: Motion,
    *,
    against: Captured | None = None,
    seams: Sequence[tuple[float, float]] = (),
) -> Quality:
    """The figures of a motion, beside those of capture.

    All but skating is measured at 30 frames per second, skating at 20. The motion's floor is at 0.

    Args:
        skeleton: of the motion.
        motion: two frames or more.
        against: what capture does; see :func:`mgjax.quality.captured`.
        seams: first and last second of each.

    Raises:
        MotionError: it does not fit the skeleton, is not finite or too short.
    """
    validate_motion(skeleton, motion)
    skeleton, motion, known = beside_capture(skeleton, motion, against)
    subject, notes = subject_of(skeleton)
    if against is not None and known is None:
        notes = (*notes, OTHER)
    if motion.frame_rate < RATE - 1e-6:
        notes = (*notes, SLOW)
    tracks = make_tracks(skeleton, subject, [motion])
    figures = _figures(tracks, subject, known)
    beside: dict[str, tuple[float, float]] = {}
    if against is not None:
        windows = against.windows(motion.seconds)
        beside = {name: percentiles(values) for name, values in windows.items()}
        if known is None:
            beside = {k: v for k, v in beside.items() if k not in NEEDS_CAPTURE}
    return Quality(
        seconds=motion.seconds,
        figures=figures,
        at_seams=_at_seams(subject, motion, tracks, known, seams),
        beside=beside,
        faults=faults_of(figures, beside, float(subject.scale)),
        notes=notes,
    )


def measure_many(
    skeleton: Skeleton,
    motions: Sequence[Motion],
    *,
    against: Captured | None = None,
    spans_s: Sequence[tuple[float, float]] | None = None,
    rests: Sequence[np.ndarray] | None = None,
) -> tuple[dict[str, Float[np.ndarray, " M"]], Float[np.ndarray, "J B"]]:
    """The figures of many motions of one skeleton, and the histograms of all their joint speeds.

    Args:
        skeleton: of the motions.
        motions: of any lengths and rates.
        against: capture with the joints in this order.
        spans_s: seconds between which frames are counted, of each; default: all.
        rests: see :func:`mgjax.quality.make_tracks`.

    Raises:
        MotionError: a motion is shorter than two frames.
        SkeletonError: the capture has other joints, or another order of them.
    """
    subject, _ = subject_of(skeleton)
    if against is not None and first_difference(against.clips[0][0], skeleton) is not None:
        differs = first_difference(against.clips[0][0], skeleton)
        raise SkeletonError(got=str(differs), expected="the joints of the capture")
    extremes = no_extremes(subject) if against is None else against.extremes
    found: dict[str, np.ndarray] = {}
    fast: list[np.ndarray] = []
    groups = in_groups(skeleton, subject, motions, spans_s=spans_s, rests=rests)
    for tracks, rows in groups:
        for key, value in measured(tracks, subject, extremes).items():
            found.setdefault(key, np.full(len(motions), np.nan))[rows] = value[: len(rows)]
        fast.append(np.asarray(speeds(tracks, subject), np.float64)[: len(rows)].sum(axis=0))
    return found, np.sum(fast, axis=0)


def beside_capture(
    skeleton: Skeleton, motion: Motion, against: Captured | None
) -> tuple[Skeleton, Motion, Captured | None]:
    """The motion with its joints in the order of the capture, if that has the same; else None."""
    ordered = None if against is None else in_order_of(against.clips[0][0], skeleton, motion)
    return (skeleton, motion, None) if ordered is None else (*ordered, against)


def curves_of(skeleton: Skeleton, motion: Motion, against: Captured | None = None) -> Curves:
    """The measures over time of one motion, without padding, as NumPy arrays."""
    skeleton, motion, known = beside_capture(skeleton, motion, against)
    subject, _ = subject_of(skeleton)
    extremes = no_extremes(subject) if known is None else known.extremes
    tracks = make_tracks(skeleton, subject, [motion])
    found = measured_curves(tracks, subject, extremes)
    counts = {"frames": found.frames, "steps": found.steps, "toe_steps": found.toe_steps}
    counts |= {"inner": found.inner, "windows": found.windows}
    lengths = {key: int(np.asarray(mask)[0].sum()) for key, mask in counts.items()}
    own = {
        "skates": "toe_steps",
        "sink": "frames",
        "height": "frames",
        "depth": "frames",
        "outside": "frames",
        "jerk": "windows",
        "jump": "inner",
    } | {key: key for key in lengths}
    values = {
        key: np.asarray(value)[0, : lengths[own.get(key, "steps")]]
        for key, value in vars(found).items()
    }
    return Curves(**values)


def _figures(tracks: Tracks, subject: Subject, known: Captured | None) -> dict[str, float]:
    extremes = no_extremes(subject) if known is None else known.extremes
    values = measured(tracks, subject, extremes)
    found: dict[str, float] = {key: float(value[0]) for key, value in values.items()}
    if not len(subject.pairs.reach):
        found["self_penetration"] = math.nan
    if known is None:
        found |= dict.fromkeys(NEEDS_CAPTURE, math.nan)
    else:
        distances = speed_distances(tracks, subject, known.speeds)
        found["speed_distance"] = float(distances[0])
    return found


def _at_seams(
    subject: Subject,
    motion: Motion,
    tracks: Tracks,
    known: Captured | None,
    seams: Sequence[tuple[float, float]],
) -> dict[str, float]:
    """The figures of all seams: of largest ones the largest, of others the mean over the seams."""
    inside = [(a, b) for a, b in seams if a < motion.seconds and b > 0]
    if not inside:
        return {}
    extremes = no_extremes(subject) if known is None else known.extremes
    # The same track for all, with spans of their own; padded to few numbers of seams.
    padded = inside + [inside[-1]] * (bucket_size(len(inside), 4, 4) - len(inside))
    counted = replace(
        tracks.take(np.zeros(len(padded), int)),
        spans=np.stack([span_frames(span, RATE, int(tracks.counts[0])) for span in padded]),
        toe_spans=np.stack(
            [span_frames(span, SKATE_RATE, int(tracks.toe_counts[0])) for span in padded]
        ),
    )
    found = measured(counted, subject, extremes)
    values = {key: np.asarray(value)[: len(inside)] for key, value in found.items()}
    whole = ("jerk_ratio", "velocity_jump", "sink", "self_penetration", "limits")
    joined = {
        key: float(np.nanmax(v) if key in whole else np.nanmean(v))
        if np.isfinite(v).any()
        else math.nan
        for key, v in values.items()
    }
    if known is None:
        joined |= dict.fromkeys((key for key in NEEDS_CAPTURE if key in joined), math.nan)
    return joined
