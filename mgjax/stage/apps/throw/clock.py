"""The time of a session: it runs at any pace, and stands still."""

from __future__ import annotations

import time
from collections.abc import Callable


class SessionClock:
    """Seconds of the show, which may run slower or faster than real ones, or not at all.

    Args:
        real: tells real seconds.
    """

    def __init__(self, real: Callable[[], float] = time.perf_counter) -> None:
        self._real = real
        self._since, self._at, self.pace = real(), 0.0, 1.0

    def now(self) -> float:
        return self._at + (self._real() - self._since) * self.pace

    def run(self, pace: float) -> None:
        """Goes on at ``pace`` seconds a real second; 0 stands still."""
        self._at, self._since = self.now(), self._real()
        self.pace = pace


class Ahead:
    """A clock that is some seconds ahead of another: what is shown then is decided now."""

    def __init__(self, clock: SessionClock, seconds: float) -> None:
        self._clock, self._seconds = clock, seconds

    def now(self) -> float:
        return self._clock.now() + self._seconds
