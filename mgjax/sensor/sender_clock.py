"""Whether a sender's clock tells the time: it is compared with the times of arrival.

The VMC protocol's ``/VMC/Ext/T`` is a relative time in seconds, a float of four bytes. Some senders
never change it, some send milliseconds, some jump; and as a float the seconds since a machine
was started 30 days ago have a resolution of 0.25 s, so that a dozen frames have the same time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection

FRAMES = 8
"""So many steps from frame to frame are looked at, and waited for before the first are trusted."""
_STILL = 5
"""Steps of these without any time between them, from which on the clock stands still."""
_JUMPS = 4
"""Jumps within :data:`_WITHIN_S` from which on the clock jumps; fewer are a sender begun anew."""
_WITHIN_S = 10.0
_JUMP_S = 1.0
"""A step longer than this, and as much off that of the arrivals, is a jump."""
_QUICK_S = 1e-3
"""Packets that come twice come sooner than this after one another."""


class SenderClock:
    """Compares the times that frames are stamped with, and the times at which they come.

    A frame begins where a bone comes again or the time is another. Motion that is played faster or
    slower than it was captured is in order: what counts are steps of none, and of seconds.

    Attributes:
        fault: what is wrong, in words; "" while nothing is.
    """

    def __init__(self) -> None:
        self.fault = ""
        self._stamp: float | None = None
        self._of_frame: float | None = None
        self._began_s: float | None = None
        self._seen: set[int] = set()
        self._still: deque[bool] = deque(maxlen=FRAMES)
        self._jumped: deque[tuple[float, float]] = deque(maxlen=_JUMPS)

    @property
    def judged(self) -> bool:
        """Whether enough frames have been looked at, or the clock is known to be wrong."""
        return bool(self.fault) or len(self._still) == FRAMES

    def look(self, stamp: float | None, bones: Collection[int], arrival_s: float) -> None:
        """Takes what came in a packet, which may be a time, bones, or both."""
        if stamp is not None:
            self._stamp = stamp
        if not bones or self.fault:
            return
        if self._began_s is None or self._stamp != self._of_frame or self._seen & set(bones):
            self._begin(arrival_s)
        self._seen.update(bones)

    def _begin(self, arrival_s: float) -> None:
        """Compares the steps from the last frame to one that begins now."""
        if self._began_s is not None:
            came = arrival_s - self._began_s
            step = came
            if self._stamp is not None and self._of_frame is not None:
                step = self._stamp - self._of_frame
            self._still.append(step == 0 and came > _QUICK_S)
            if abs(step) > _JUMP_S and abs(step - came) > _JUMP_S:
                self._jumped.append((arrival_s, abs(step / came) if came else 0.0))
        self._of_frame, self._began_s, self._seen = self._stamp, arrival_s, set()
        self._judge()

    def _judge(self) -> None:
        jumped = self._jumped
        if sum(self._still) >= _STILL:
            self.fault = f"stands still in {sum(self._still)} of {len(self._still)} frames"
        elif len(jumped) == _JUMPS and jumped[-1][0] - jumped[0][0] < _WITHIN_S:
            quick = sum(500 < ratio < 2000 for _, ratio in jumped) > _JUMPS // 2
            self.fault = "counts milliseconds" if quick else f"jumps by more than {_JUMP_S:g} s"
