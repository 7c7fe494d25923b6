"""Hits found in the path of one bone: highest and fastest frames, and the sections they bound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from mgjax.ballsport.config import AnalysisConfig, hit_bone, validate_analysis
from mgjax.ballsport.hits.smoothing import smooth
from mgjax.core.body.roles import find_role, require_roles
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import joint_velocities
from mgjax.core.skeleton import Skeleton

NO_FRAME = -1
"""Where a hit has no F_S on one side."""


@dataclass(frozen=True, kw_only=True)
class Hit:
    """One hit of one bone; frames count from the beginning of the clip, stops are exclusive.

    Attributes:
        highest: F_H that belong to this hit, in order.
        fastest: F_S, the fastest of their neighbours, which all of them share; before ``start``
            only where the hit before it takes in that frame.
        top: the highest of ``highest``, the middle key pose.
        before, after: F_S next to ``top`` on either side, inside S_H, or ``NO_FRAME``.
        hit_start, hit_stop: S_B, in which the ball can be hit.
        start, stop: S_H, the hit motion.
    """

    highest: tuple[int, ...]
    fastest: int
    top: int
    before: int
    after: int
    hit_start: int
    hit_stop: int
    start: int
    stop: int

    @property
    def key_frames(self) -> tuple[int, int, int, int, int]:
        """First, F_S before, F_H, F_S after, last (Fig. 3); where there is no F_S, the end."""
        last = self.stop - 1
        before = self.start if self.before == NO_FRAME else self.before
        return self.start, before, self.top, last if self.after == NO_FRAME else self.after, last

    def shifted(self, frames: int) -> Hit:
        """The hit on an axis of frames that begins earlier by so many."""
        moved = {
            name: value if value == NO_FRAME else value + frames
            for name, value in vars(self).items()
            if name != "highest"
        }
        return replace(self, highest=tuple(f + frames for f in self.highest), **moved)


@dataclass(frozen=True, kw_only=True)
class Marks:
    """The curves of a bone and the frames marked on them (Fig. 2).

    Attributes:
        height: over the floor, m.
        speed: m/s.
        highest: all F_H.
        fastest: all F_S that are left after merging.
    """

    height: Float[np.ndarray, " F"]
    speed: Float[np.ndarray, " F"]
    highest: Int[np.ndarray, " A"]
    fastest: Int[np.ndarray, " B"]


def hit_joint(skeleton: Skeleton, bone: str) -> int:
    """The joint whose path is that of a hit bone; see :class:`mgjax.ballsport.config.HitBone`.

    Raises:
        SkeletonError: no such hit bone, or the skeleton has no joint for it.
    """
    row = hit_bone(bone)
    for role in row.roles[:-1]:
        joint = find_role(skeleton, role)
        if joint is not None:
            return joint
    (last,) = require_roles(skeleton, row.roles[-1:])
    if not row.at_end:
        return last
    return next((j for j in skeleton.end_joints if skeleton.parents[j] == last), last)


def mark(positions: Float[np.ndarray, "F 3"], frame_rate: float, config: AnalysisConfig) -> Marks:
    """Height, speed, F_H and F_S of a bone.

    A frame is a local maximum if it is higher than the one before and not lower than the one
    after, so a plateau counts with its first frame; the first and the last frame of a clip are
    never one. F_S merge pairwise: one is dropped if a faster one (or an equal one that is earlier)
    is closer than ``merge_s`` with no F_H between them. What is dropped can still drop another, so
    a chain of slower and slower ripples merges into its beginning.
    """
    places = smooth(positions, frame_rate, config.smoothing_s)
    height = places[:, 1]
    speed = np.linalg.norm(joint_velocities(places[:, None], frame_rate)[:, 0], axis=-1)
    highest = _maxima(height)
    highest = highest[height[highest] > config.height_m]
    ripples = _maxima(speed)
    # How many F_H lie at or before each F_S: equal numbers mean that none lies between.
    passed = np.searchsorted(highest, ripples, side="left")
    distance = np.abs(ripples[:, None] - ripples[None])
    stronger = (speed[ripples][None] > speed[ripples][:, None]) | (
        (speed[ripples][None] == speed[ripples][:, None]) & (ripples[None] < ripples[:, None])
    )
    near = (distance < config.merge_s * frame_rate - 1e-6) & (passed[:, None] == passed[None])
    return Marks(
        height=height,
        speed=speed,
        highest=highest,
        fastest=ripples[~(near & stronger).any(axis=1)],
    )


def sections(marks: Marks, frame_rate: float, config: AnalysisConfig) -> list[Hit]:
    """The hits of marked curves, in order; none is an empty list.

    S_B runs from an F_H to the faster of the two F_S next to it; F_H that share that F_S are one
    hit. S_H goes on to the lowest height on either side and ends at the first frame, going
    outwards, within ``margin_m`` of it. The lowest height is looked for as far as the F_H of the
    neighbouring hit. Where two S_H would share frames they belong to the earlier.

    Deviation: both searches end ``reach_s`` from the hit; without a bound nothing could be known
    before the next hit. An F_H without an F_S in reach is no hit.
    """
    reach = round(config.reach_s * frame_rate)
    groups: list[tuple[int, list[int]]] = []
    for top in marks.highest:
        near = [f for f in _neighbours(marks, int(top), reach) if f != NO_FRAME]
        if not near:
            continue
        fastest = max(near, key=lambda f: marks.speed[f])
        # An F_H on the very frame of the F_S of the hit before is part of that hit.
        if groups and groups[-1][0] in (fastest, top):
            groups[-1][1].append(int(top))
        else:
            groups.append((fastest, [int(top)]))
    hits: list[Hit] = []
    for number, (fastest, highest) in enumerate(groups):
        first, last = min(fastest, highest[0]), max(fastest, highest[-1])
        low = groups[number - 1][1][-1] if number else 0
        high = groups[number + 1][1][0] if number + 1 < len(groups) else len(marks.height) - 1
        start = _outwards(marks.height, first, max(low, first - reach), config.margin_m)
        stop = _outwards(marks.height, last, min(high, last + reach), config.margin_m) + 1
        start = max(start, hits[-1].stop) if hits else start
        top = max(highest, key=lambda f: marks.height[f])
        before, after = _neighbours(marks, top, reach)
        hits.append(
            Hit(
                highest=tuple(highest),
                fastest=fastest,
                top=top,
                before=before if before >= start else NO_FRAME,
                after=after if after < stop else NO_FRAME,
                hit_start=max(first, start),
                hit_stop=last + 1,
                start=start,
                stop=stop,
            )
        )
    return hits


def find_hits(
    positions: Float[np.ndarray, "F 3"], frame_rate: float, config: AnalysisConfig | None = None
) -> list[Hit]:
    """All hits in the path of one bone (Choi et al. 2019, §3), in order.

    Args:
        positions: of the bone, Y up over the floor, m.
        frame_rate: frames per second.
        config: thresholds.

    Raises:
        MotionError: there is no hit; the message says how high the bone gets.
        ConfigError: a threshold that cannot be.
    """
    config = config or AnalysisConfig()
    validate_analysis(config)
    if not 0 < frame_rate <= 10000:
        raise MotionError(got=f"frame rate {frame_rate:g}", expected="0 … 10000 per second")
    if len(positions) < 3 or not np.isfinite(positions).all():
        raise MotionError(
            f"got {len(positions)} frames with {int((~np.isfinite(positions)).sum())} values that"
            " are not finite, expected at least 3 finite places of a hit bone"
        )
    marks = mark(np.asarray(positions, np.float64), frame_rate, config)
    hits = sections(marks, frame_rate, config)
    if not hits:
        reached = float(marks.height.max())
        why = "every frame is below" if reached <= config.height_m else "no hit is above"
        raise MotionError(
            f"no hit found: {why} the threshold height of {config.height_m:g} m, the bone reaches"
            f" {reached:.2f} m"
        )
    return hits


def links(hits: Sequence[Hit], num_frames: int) -> list[tuple[int, int]]:
    """S_L: start and stop of everything outside the hit motions, heads and tails included."""
    free = np.ones(num_frames + 2, bool)
    free[[0, -1]] = False
    for hit in hits:
        free[hit.start + 1 : hit.stop + 1] = False
    edges = np.flatnonzero(np.diff(free.astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _maxima(curve: np.ndarray) -> np.ndarray:
    return 1 + np.flatnonzero((curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:]))


def _neighbours(marks: Marks, top: int, reach: int) -> tuple[int, int]:
    """F_S at or before an F_H and after it, at most ``reach`` frames away, or ``NO_FRAME``."""
    place = int(np.searchsorted(marks.fastest, top, side="right"))
    before = int(marks.fastest[place - 1]) if place else NO_FRAME
    after = int(marks.fastest[place]) if place < len(marks.fastest) else NO_FRAME
    if before != NO_FRAME and top - before > reach:
        before = NO_FRAME
    if after != NO_FRAME and after - top > reach:
        after = NO_FRAME
    return before, after


def _outwards(height: np.ndarray, inner: int, outer: int, margin: float) -> int:
    """The first frame from ``inner`` to ``outer`` within ``margin`` of the lowest height there."""
    step = 1 if outer >= inner else -1
    path = height[np.arange(inner, outer + step, step)]
    return inner + step * int(np.argmax(path <= path.min() + margin))
