"""Clips of several skeletons on one: bodies made once per skeleton, and what is said about it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mgjax.clips.retarget.body import Body, make_body
from mgjax.clips.retarget.clip import Retargeted, carry
from mgjax.clips.retarget.same import same_build
from mgjax.clips.types import Clip
from mgjax.core.errors import SkeletonError
from mgjax.core.motion import Motion, resample
from mgjax.core.skeleton import Skeleton

_LINES = 10
"""As many clips at most have a note each."""


class Retargeter:
    """Puts motions on one skeleton.

    What all clips of a skeleton show together says how its joints turn and its feet stand, so
    that every clip of it is treated alike.

    Args:
        target: the skeleton, with a rest pose that stands.
        clips: all clips, with rest poses that stand.
        frame_rate: of the motions looked at, frames per second.
        example: a motion of the target.
    """

    def __init__(
        self,
        target: Skeleton,
        clips: Sequence[Clip],
        frame_rate: float,
        *,
        example: Motion | None = None,
    ) -> None:
        self._groups: list[tuple[Skeleton, list[Motion]]] = [(target, [example] if example else [])]
        for clip in clips:
            known = (g for s, g in self._groups if same_build(s, clip.skeleton))
            group = next(known, None)
            if group is None:
                self._groups.append((clip.skeleton, [clip.motion]))
            else:
                group.append(clip.motion)
        self._frame_rate = frame_rate
        self._bodies: dict[int, Body] = {}

    def __call__(self, clip: Clip, motion: Motion, name: str) -> tuple[Motion, Retargeted | None]:
        """A motion of a clip on the target, and how that went; None where it is the target's.

        Raises:
            SkeletonError: one of the two has no legs.
        """
        group = self._group(clip)
        if group == 0:
            return motion, None
        return carry(self._body(group, clip.name), self._body(0, name), motion, name)

    def _group(self, clip: Clip) -> int:
        return next(i for i, (s, _) in enumerate(self._groups) if same_build(s, clip.skeleton))

    def _body(self, group: int, name: str) -> Body:
        if group not in self._bodies:
            skeleton, seen = self._groups[group]
            motions = (resample(motion, self._frame_rate) for motion in seen)
            try:
                self._bodies[group] = make_body(skeleton, motions)
            except SkeletonError as error:
                raise SkeletonError(
                    got=f"a skeleton that cannot be retargeted ({error})",
                    expected="legs",
                    place=name,
                ) from None
        return self._bodies[group]


def notes_on(rows: Sequence[Retargeted]) -> list[str]:
    """One line for each clip, or one for all where there are many."""
    if len(rows) <= _LINES:
        return [f"{row.clip}: {_line([row])}" for row in rows]
    return [f"{len(rows)} clips {_line(rows)}"]


def _line(rows: Sequence[Retargeted]) -> str:
    frames = [row.frames for row in rows]

    def mean(attribute: str) -> float:
        return float(np.average([getattr(row, attribute) for row in rows], weights=frames))

    before, after = (1000 * mean(f"foot_slide_{when}_m") for when in ("before", "after"))
    beyond = [sum(getattr(row, f"limits_{when}") for row in rows) for when in ("before", "after")]
    scales = _span(sorted({f"{row.scale:.2f}" for row in rows}))
    joints = _span([str(n) for n in sorted({row.joints for row in rows})])
    return (
        f"put on the skeleton from one of {joints} joints, scale {scales}; planted feet travel"
        f" {before:.2f} mm per frame as captured, {after:.2f} mm now; joints are beyond limits in"
        f" {beyond[0]} frames as captured, {beyond[1]} now; hands, feet and head are"
        f" {100 * mean('end_error_m'):.1f} cm off on average"
    )


def _span(values: list[str]) -> str:
    return values[0] if len(values) == 1 else f"{values[0]} … {values[-1]}"
