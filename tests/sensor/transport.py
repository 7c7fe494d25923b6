"""A sender and a receiver in one process and in simulated time, and waiting for a condition."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.sensor.config import ReplayConfig, validate_replay
from mgjax.sensor.counts import Counts
from mgjax.sensor.frames import SensorFrame
from mgjax.sensor.inbox import WAITING_FRAMES, FrameInbox
from mgjax.sensor.replay import Recording

SAFETY_S = 120.0
"""After so long a condition that is waited for is taken to never come."""


class SimulatedClock:
    """Shows a time that is set; each reading takes a microsecond, so that order can be seen."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 1e-6
        return self.now

    def sleep(self, seconds: float) -> None:
        """Time passes."""
        self.now += seconds

    def until(self, time: float) -> None:
        """Time passes up to a moment, or has passed."""
        self.now = max(self.now, time)


class Loopback:
    """A clip that is sent, and the frames that arrive: what a receiver gives, without a socket.

    Packets arrive when they are due by the simulated clock, as they are taken.
    """

    def __init__(
        self,
        skeleton: Skeleton,
        motion: Motion,
        config: ReplayConfig | None = None,
        *,
        capacity: int = WAITING_FRAMES,
    ) -> None:
        config = config or ReplayConfig()
        validate_replay(config)
        self.clock = SimulatedClock()
        self.recording = Recording(skeleton, motion, config)
        self._inbox = FrameInbox(capacity, clock=self.clock)
        self._packets = iter(self.recording)
        self._next = next(self._packets, None)

    @property
    def counts(self) -> Counts:
        return self._inbox.counts

    def put(self, datagram: bytes, source: object = "other") -> None:
        """A datagram of somebody else arrives now."""
        self._inbox.put(datagram, source)

    def arrive(self) -> bool:
        """The next packet arrives, if there is one."""
        if self._next is None:
            return False
        due, datagram = self._next
        self.clock.until(due)
        self._inbox.put(datagram, "sender")
        self._next = next(self._packets, None)
        return True

    def frames(self, seconds: float) -> Iterator[SensorFrame]:
        """The frames that come within so many seconds of simulated time."""
        end = self.clock() + seconds
        yield from self._inbox.frames(0.0)
        while self._next is not None and self._next[0] <= end:
            self.arrive()
            yield from self._inbox.frames(0.0)
        self.clock.until(end)


class PlayedReceiver(Loopback):
    """Stands for a receiver where a command opens one: hears a clip in simulated time."""

    port = 1

    @classmethod
    def of(cls, skeleton: Skeleton, motion: Motion) -> Callable[[str, int], PlayedReceiver]:
        """What makes one from a host and a port."""
        return lambda host, port: cls(skeleton, motion)

    def __enter__(self) -> PlayedReceiver:
        return self

    def __exit__(self, *_: object) -> None:
        pass


def wait_until(condition: Callable[[], bool]) -> None:
    """Returns once the condition holds; fails where it does not within a generous time."""
    pause = threading.Event()
    for _ in range(round(SAFETY_S / 0.01)):
        if condition():
            return
        pause.wait(0.01)
    raise AssertionError(f"nothing came of it in {SAFETY_S:g} s")
