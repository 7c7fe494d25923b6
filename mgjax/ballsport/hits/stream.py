"""Hits found in a stream: frame by frame, each one given out as soon as nothing can change it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.config import AnalysisConfig, validate_analysis
from mgjax.ballsport.hits.detect import NO_FRAME, Hit, Marks, mark, sections
from mgjax.ballsport.hits.smoothing import half_width
from mgjax.core.errors import MotionError


class HitStream:
    """Finds the hits of one bone in a stream of its positions.

    The hits are those that :func:`mgjax.ballsport.hits.detect.find_hits` finds in the whole path,
    in the same order. Each is given out when no later frame can change it: mostly ``reach_s`` after
    the last F_H or F_S of the hit, which is some tenths of a second after the bone is back on the
    floor, and never more than ``delay_frames`` after it. Only the last seconds are kept.
    """

    def __init__(self, frame_rate: float, config: AnalysisConfig | None = None) -> None:
        self._config = config or AnalysisConfig()
        validate_analysis(self._config)
        if not 0 < frame_rate <= 10000:
            raise MotionError(f"frame rate is {frame_rate}, expected 0 … 10000 per second")
        self._rate = frame_rate
        self._reach = round(self._config.reach_s * frame_rate)
        self._merge = int(np.ceil(self._config.merge_s * frame_rate))
        # So many of the newest frames can still become or cease to be a maximum: the smoothing
        # and the central difference look ahead, and a maximum needs the frame after it.
        self._open = half_width(frame_rate, self._config.smoothing_s) + 2
        # A hit that is not certain yet depends on less than this.
        self._kept = 8 * self._reach + 3 * self._merge + 4 * self._open
        self._places: list[np.ndarray] = []
        self._first = 0
        self._high = -1
        self._last_given = NO_FRAME

    @property
    def delay_frames(self) -> int:
        """Most frames from the last F_H or F_S of a hit to the frame that gives it out."""
        return 2 * self._reach + self._merge + self._open

    @property
    def kept_frames(self) -> int:
        """A hit that is given out began less than this before."""
        return self._kept

    @property
    def num_frames(self) -> int:
        """Frames received so far."""
        return self._first + len(self._places)

    def push(self, position: Float[np.ndarray, "3"]) -> list[Hit]:
        """Takes the next frame; returns the hits that have become certain, mostly none.

        Raises:
            MotionError: the position is not finite; the frame is not taken.
        """
        place = np.asarray(position, np.float64)
        if not np.isfinite(place).all():
            raise MotionError(f"got the position {place.tolist()}, expected finite numbers")
        self._places.append(place)
        if len(self._places) >= 2 * self._kept:
            cut = len(self._places) - self._kept
            del self._places[:cut]
            self._first += cut
        if place[1] > self._config.height_m:
            self._high = self.num_frames
        # Nothing was high for so long that no hit can be open.
        if self.num_frames - self._high > 2 * self.delay_frames:
            return []
        return self._give(certain_only=True)

    def finish(self) -> list[Hit]:
        """The stream is over: the hits that were still open."""
        return self._give(certain_only=False)

    def _give(self, *, certain_only: bool) -> list[Hit]:
        if len(self._places) < 3:
            return []
        marks = mark(np.array(self._places), self._rate, self._config)
        certain: list[Hit] = []
        for hit in sections(marks, self._rate, self._config):
            if self._first + hit.top <= self._last_given:
                continue
            if certain_only and not self._certain(marks, hit):
                break
            certain.append(hit.shifted(self._first))
        if certain:
            self._last_given = certain[-1].highest[-1]
        return certain

    def _certain(self, marks: Marks, hit: Hit) -> bool:
        """No later frame can change the hit, or add an F_H to it."""
        known = len(self._places) - 1 - self._open
        last = max(hit.fastest, hit.highest[-1])
        if last + self._reach > known:
            return False
        near = marks.highest[
            (marks.highest >= hit.highest[0]) & (marks.highest <= last + self._reach)
        ]
        for top in near:
            after = marks.fastest[marks.fastest > top]
            is_known = len(after) > 0 and after[0] + self._merge <= known
            if not is_known and top + self._reach + self._merge > known:
                return False
        return True
