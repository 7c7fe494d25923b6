"""Where the user's body comes from: a motion sensor, or a clip that is sent as if by one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol, runtime_checkable

from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.sensor.config import HOST, PORT, ReplayConfig
from mgjax.sensor.counts import why_nothing
from mgjax.sensor.frames import FrameAssembler, SensorFrame
from mgjax.sensor.receiver import SensorReceiver
from mgjax.sensor.replay import Recording

REPLAY_RATE = 60.0
"""Frames a second of a clip that is sent."""


@runtime_checkable
class Source(Protocol):
    """Gives a body's frames as they come."""

    def frames(self, now_s: float) -> Iterator[SensorFrame]:
        """Those that have come by a second of the match, and were not given before."""
        ...

    @property
    def over(self) -> bool:
        """Whether no more will come."""
        ...

    @property
    def silence(self) -> str:
        """One sentence that says why nothing has come yet; "" where something has."""
        ...

    def close(self) -> None:
        """Frees what it holds."""
        ...


class SensorSource:
    """A sender of the VMC protocol on this machine.

    Raises:
        ConfigError: the port is taken.
    """

    def __init__(self, port: int = PORT) -> None:
        self._receiver = SensorReceiver(HOST, port)
        self.place = f"{HOST}:{self._receiver.port}"
        self.over = False

    def frames(self, now_s: float) -> Iterator[SensorFrame]:
        """See :class:`Source`; what has arrived, whatever the time of the match."""
        return self._receiver.frames(0.0)

    @property
    def silence(self) -> str:
        return why_nothing(self._receiver.counts, self.place)

    def close(self) -> None:
        self._receiver.close()


class ClipSource:
    """A clip as the packets of a sensor, received at the pace of the match.

    Args:
        skeleton: of the clip.
        motion: the clip.
        start_s: second of the match at which it begins.

    Raises:
        ConfigError: python-osc is not there.
        SkeletonError: the skeleton has no legs.
    """

    silence = ""

    def __init__(self, skeleton: Skeleton, motion: Motion, start_s: float) -> None:
        self._packets = iter(Recording(skeleton, motion, ReplayConfig(rate=REPLAY_RATE)))
        self._assembler = FrameAssembler()
        self._start = start_s
        self._next = next(self._packets, None)

    @property
    def over(self) -> bool:
        return self._next is None

    def frames(self, now_s: float) -> Iterator[SensorFrame]:
        """See :class:`Source`."""
        while self._next is not None and self._start + self._next[0] <= now_s:
            due, datagram = self._next
            yield from self._assembler.feed(datagram, self._start + due, "clip")
            self._next = next(self._packets, None)

    def close(self) -> None:
        self._next = None
