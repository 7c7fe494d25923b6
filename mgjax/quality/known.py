"""What uncut capture does: the measure of all that is made from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.arrays import Array
from mgjax.core.body.capsules import pair_distances
from mgjax.core.errors import SkeletonError
from mgjax.core.motion import Motion, cut
from mgjax.core.skeleton import Skeleton, first_difference
from mgjax.quality.kernel import Extremes, measured, speeds
from mgjax.quality.limits import captured_ranges
from mgjax.quality.same_joints import in_order_of
from mgjax.quality.smoothness import normalised_jerk, window_frames, windows_counted
from mgjax.quality.speeds import hellinger
from mgjax.quality.subject import Subject, subject_of
from mgjax.quality.tracks import RATE, Tracks, in_groups, make_tracks, resting

JERK_QUANTILE = 0.999
MOST_WINDOWS = 64
"""Windows of capture beside one file."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Captured:
    """Capture of one hierarchy of joints, whatever the lengths of its bones.

    Attributes:
        clips: skeleton and motion of each.
        extremes: jerk, limbs in the body and angles.
        speeds: histograms of joint speeds. [J, B]
    """

    clips: tuple[tuple[Skeleton, Motion], ...]
    extremes: Extremes
    speeds: Float[np.ndarray, "J B"]

    @cached_property
    def _windows(self) -> dict[float, Mapping[str, np.ndarray]]:
        return {}

    def windows(self, seconds: float) -> Mapping[str, np.ndarray]:
        """The figures of its own pieces of this length, or of whole clips that are shorter.

        At most :data:`MOST_WINDOWS`, spread evenly over all. Kept.
        """
        length = round(seconds * RATE)
        if length not in self._windows:
            self._windows[length] = _figures_of_windows(self, length / RATE)
        return self._windows[length]


def captured(clips: Sequence[tuple[Skeleton, Motion]]) -> Captured:
    """What capture does: 99.9 % quantiles of jerk, limbs nearest to the body, angles, speeds.

    Args:
        clips: skeleton and motion of each, all with the same names and hierarchy of joints,
            in whatever order.

    Raises:
        SkeletonError: hierarchies differ, or there are no clips.
        MotionError: a clip is shorter than two frames.
    """
    if not clips:
        raise SkeletonError(got="no capture", expected="one clip or more")
    first = clips[0][0]
    ordered: list[tuple[Skeleton, Motion]] = []
    for skeleton, motion in clips:
        clip = in_order_of(first, skeleton, motion)
        if clip is None:
            differs = first_difference(first, skeleton)
            raise SkeletonError(got=f"capture of two skeletons: {differs}", expected="one")
        ordered.append(clip)
    clips = ordered
    jerk: list[np.ndarray] = []
    apart: list[np.ndarray] = []
    fast: list[np.ndarray] = []
    for skeleton, subject, rows in by_skeleton(clips):
        for tracks, own in in_groups(skeleton, subject, [clips[i][1] for i in rows]):
            values, counted, least = (np.asarray(x) for x in _extremes(tracks, subject))
            jerk.append(values[: len(own)][counted[: len(own)]])
            apart.append(least)
            fast.append(np.asarray(speeds(tracks, subject), np.float64)[: len(own)].sum(axis=0))
    every = np.concatenate(jerk)
    turns = np.concatenate([np.asarray(motion.local_rotations) for _, motion in clips])
    extremes = Extremes(
        jerk=np.quantile(every, JERK_QUANTILE, axis=0).astype(np.float32)
        if len(every)
        else np.full(every.shape[1], np.inf, np.float32),
        apart=np.min(apart, axis=0),
        ranges=captured_ranges(clips[0][0], turns),
    )
    return Captured(clips=tuple(clips), extremes=extremes, speeds=np.sum(fast, axis=0))


def by_skeleton(
    clips: Sequence[tuple[Skeleton, Motion]],
) -> Iterator[tuple[Skeleton, Subject, list[int]]]:
    """Clips of bodies of the same lengths together, by their numbers."""
    groups: dict[bytes, list[int]] = {}
    for row, (skeleton, _) in enumerate(clips):
        groups.setdefault(np.asarray(skeleton.offsets, np.float64).tobytes(), []).append(row)
    for rows in groups.values():
        skeleton = clips[rows[0]][0]
        yield skeleton, subject_of(skeleton)[0], rows


def speed_distances(
    tracks: Tracks, subject: Subject, known: Float[np.ndarray, "J B"]
) -> Float[np.ndarray, " M"]:
    """Hellinger distances of the histograms of joint speeds to others, the mean over joints."""
    found = np.asarray(speeds(tracks, subject), np.float64)
    return np.asarray(hellinger(found, known[None])).mean(axis=1)


@jax.jit
def _extremes(
    tracks: Tracks, subject: Subject
) -> tuple[Float[Array, "M W n"], Bool[Array, "M W"], Float[Array, " P"]]:
    """Jerk of all windows, which count, and the least distance of each pair of capsules."""

    def one(track: Tracks) -> tuple[Array, Array, Array]:
        places = track.places[:, subject.joints]
        jerk = normalised_jerk(places, rate=RATE, scale=subject.scale)
        first, last = track.spans
        windows = windows_counted(jerk.shape[0], window_frames(RATE), track.counts, first, last)
        distances = pair_distances(subject.pairs, track.places)
        there = jnp.arange(track.places.shape[0]) < track.counts
        return jerk, windows, jnp.min(jnp.where(there[:, None], distances, jnp.inf), axis=0)

    jerk, windows, least = jax.vmap(one)(tracks)
    return jerk, windows, jnp.min(least, axis=0)


def _figures_of_windows(known: Captured, seconds: float) -> dict[str, np.ndarray]:
    pieces: list[tuple[int, Motion]] = []
    for row, (_, motion) in enumerate(known.clips):
        length = min(max(round(seconds * motion.frame_rate), 2), motion.num_frames)
        count = motion.num_frames // length
        pieces += [(row, cut(motion, k * length, (k + 1) * length)) for k in range(count)]
    chosen = np.unique(np.linspace(0, len(pieces) - 1, MOST_WINDOWS).round().astype(int))
    pieces = [pieces[i] for i in chosen]
    found: list[dict[str, np.ndarray]] = []
    for skeleton, subject, rows in by_skeleton(known.clips):
        mine = [(row, piece) for row, piece in pieces if row in rows]
        if not mine:
            continue
        rests = {row: resting(skeleton, subject, known.clips[row][1]) for row, _ in mine}
        # Padded to one number of windows, so that few programs are compiled.
        padded = mine + [mine[-1]] * (MOST_WINDOWS - len(mine))
        tracks = make_tracks(
            skeleton,
            subject,
            [piece for _, piece in padded],
            rests=[rests[row] for row, _ in padded],
        )
        values = measured(tracks, subject, known.extremes)
        rows_of = {key: np.asarray(value)[: len(mine)] for key, value in values.items()}
        rows_of["speed_distance"] = speed_distances(tracks, subject, known.speeds)[: len(mine)]
        found.append(rows_of)
    return {key: np.concatenate([row[key] for row in found]) for key in found[0]}
