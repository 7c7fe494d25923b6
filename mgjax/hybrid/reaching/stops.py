"""A walk that slows down, stands still for a while, and goes on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from mgjax.core.timing.time_warp import TimeWarp, even_warp

EASE_S = 0.5
"""Time in which a walk comes to a stand, and gets going again."""


@dataclass(frozen=True, kw_only=True)
class Stop:
    """Where a walk stands still.

    Attributes:
        frame: of the walk.
        frames: how long it stands there, in frames.
    """

    frame: int
    frames: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Playback:
    """Which frame of a walk is shown when.

    Attributes:
        warp: of the walk; times and positions are frames.
        stands: for each stop the first and the last shown frame of the stand.
    """

    warp: TimeWarp
    stands: tuple[tuple[int, int], ...]

    @cached_property
    def frames(self) -> Float[np.ndarray, " N"]:
        """What is shown in each frame: frames of the walk, between which poses are interpolated."""
        return np.asarray(self.warp.at(np.arange(float(self.warp.times[-1]) + 1)))

    def shown(self, frame: int) -> int:
        """The first shown frame in which the walk has come to a frame."""
        return int(np.searchsorted(self.frames, frame - 1e-6))


def play(last: int, frame_rate: float, stops: Sequence[Stop]) -> Playback:
    """Plays a walk's frames 0 … last with stops, in their order.

    The walk's speed goes to zero and back as a half cosine, so the motion has no jumps in velocity,
    and planted feet stay planted.
    """
    ease = max(round(EASE_S * frame_rate), 2)
    profile = 0.5 + 0.5 * np.cos(np.pi * (np.arange(ease) + 0.5) / ease)
    steps: list[float] = []
    stands: list[tuple[int, int]] = []
    here = 0.0
    for number, stop in enumerate(stops):
        full = max(int(stop.frame - here - ease / 2), 0)
        steps += [1.0] * full
        left = stop.frame - here - full
        if left > 0:
            steps += (profile * left / profile.sum()).tolist()
        stands.append((len(steps), len(steps) + stop.frames))
        steps += [0.0] * stop.frames
        following = stops[number + 1].frame if number + 1 < len(stops) else last
        # Of a short way to the next stop half is for getting going, half for coming to a stand.
        share = 0.5 if number + 1 < len(stops) else 1.0
        left = min(ease / 2, share * (following - stop.frame))
        if left > 0:
            steps += (profile[::-1] * left / profile.sum()).tolist()
        here = stop.frame + left
    full = int(last - here)
    steps += [1.0] * full
    if last - here - full > 1e-6:
        steps.append(last - here - full)
    frames = np.minimum(np.concatenate([[0.0], np.cumsum(steps)]), last)
    warp = even_warp(np.arange(len(frames), dtype=np.float64), frames)
    return Playback(warp=warp, stands=tuple(stands))
