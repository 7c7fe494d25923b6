"""Frames that wait to be taken: assembled from datagrams as they come, the oldest dropped first."""

from __future__ import annotations

import contextlib
import queue
from collections.abc import Hashable, Iterator
from dataclasses import replace

from mgjax.sensor.clock import Clock, clock
from mgjax.sensor.counts import Counts
from mgjax.sensor.frames import FrameAssembler, SensorFrame

WAITING_FRAMES = 512
"""Frames that wait to be taken; when there are more, the oldest is dropped."""


class FrameInbox:
    """What lies between whatever carries the datagrams and whoever takes the frames.

    One thread puts, another takes. Whatever is put, it keeps at most a fixed number of frames; see
    :class:`mgjax.sensor.frames.FrameAssembler` for the rest.

    Args:
        capacity: frames that wait at a time.
        clock: stamps arrivals and ends the waiting.
    """

    def __init__(self, capacity: int = WAITING_FRAMES, *, clock: Clock = clock) -> None:
        self._clock = clock
        self._assembler = FrameAssembler()
        self._waiting: queue.Queue[SensorFrame] = queue.Queue(capacity)

    @property
    def counts(self) -> Counts:
        """What became of all datagrams so far."""
        return replace(self._assembler.counts)

    def put(self, datagram: bytes, source: Hashable = None) -> None:
        """Takes a datagram that arrives now; anything may be in it.

        Args:
            datagram: as received.
            source: who sent it.
        """
        for frame in self._assembler.feed(datagram, self._clock(), source):
            if self._waiting.full():
                with contextlib.suppress(queue.Empty):  # it may just have been taken
                    self._waiting.get_nowait()
                    self._assembler.counts.overrun += 1
            self._waiting.put_nowait(frame)

    def frames(self, seconds: float) -> Iterator[SensorFrame]:
        """The frames that come within so many seconds, as they come; 0: those that wait already.

        A slow taker still gets what had come when the time was over.
        """
        end = self._clock() + seconds
        while (left := end - self._clock()) > 0:
            try:
                yield self._waiting.get(timeout=left)
            except queue.Empty:
                break
        for _ in range(self._waiting.qsize()):
            yield self._waiting.get_nowait()
