"""Frames of a body, put together from packets of a VMC stream that may lose or reorder them."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from mgjax.core.skeleton import Skeleton
from mgjax.sensor.body import ROOT, HeldBody, Parts
from mgjax.sensor.bone_table import BONES, NEEDED, find_bone, is_unused
from mgjax.sensor.bones import usual_places
from mgjax.sensor.counts import Counts
from mgjax.sensor.packets import Packet, Transform, parse_packet
from mgjax.sensor.sender_clock import SenderClock

BREAK_S = 1.0
"""A jump of the time by more than this is a new stream; a sender silent for longer is replaced."""
WAIT_S = 0.03
"""How much later, by the sender's clock, something has to be to end the wait for missing bones."""
_MOST_OPEN = 16
"""Frames that wait at a time."""
_MOST_HELD = 256
"""Packets that wait at most until the sender's clock is trusted or not."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SensorFrame:
    """One frame of a received body.

    Attributes:
        time_s: by the sender's clock, s, or that of the arrivals where the sender's is wrong; rises
            from frame to frame of a stream.
        arrival_s: when the last of it came, by the receiver's clock, s.
        stream: rises by one where the sender starts anew; then the frames before are history.
        body: the sender's body in the T-pose, with the joint names of the embedded skeleton.
        positions: of its joints, Y up over the floor, right-handed, m; the first is the root.
        rotations: local ones of its joints, wxyz.
        held: joints that were not sent, and stay as they were against their parent.
    """

    time_s: float
    arrival_s: float
    stream: int
    body: Skeleton
    positions: Float[np.ndarray, "J 3"]
    rotations: Float[np.ndarray, "J 4"]
    held: int


@runtime_checkable
class FrameSource(Protocol):
    """Whatever gives the frames of a sender, such as a receiver."""

    @property
    def counts(self) -> Counts:
        """What became of all packets so far."""
        ...

    def frames(self, seconds: float) -> Iterator[SensorFrame]:
        """The frames that come within so many seconds, as they come."""
        ...


class FrameAssembler:
    """Puts frames together; no packet makes it raise, or keep more than a few poses.

    A frame is what has the same time: that of ``/VMC/Ext/T``, in the same bundle or, where it
    comes alone, before or after the bones. It is given out as soon as all bones of the body are
    there. If some are missing it waits for them, and so do the frames after it, until something
    comes that is ``WAIT_S`` later; bones that are missing then are held. Without any
    ``/VMC/Ext/T`` a frame ends where a bone comes again, and has the time tag of its bundle or
    that of its arrival. What belongs to a frame that is over, or to an earlier one, is dropped.
    The first frames only show what bones there are (:class:`HeldBody`), and whether the sender's
    clock tells the time (:class:`SenderClock`). Where it does not, the stream is taken as one
    without any times, and frames have that of their arrival.
    """

    def __init__(self) -> None:
        self.counts = Counts()
        self._usual = usual_places()
        self._heard_s = -np.inf
        self._hear(None)
        self._start()

    def _hear(self, source: Hashable) -> None:
        """From now on listens to this sender."""
        self._source = source
        self._clock = SenderClock()
        self._held: list[tuple[Packet, Parts, float]] | None = []
        self._needed = set(NEEDED)
        self.counts.clock_fault = ""

    def _start(self) -> None:
        """Forgets everything about the stream."""
        self._body = HeldBody(self._usual)
        self._open: dict[float, dict[int, Transform]] = {}
        self._over: set[float] = set()
        self._loose: dict[int, Transform] = {}
        self._loose_s = 0.0
        self._stamp: float | None = None
        self._stamped = False
        self._newest: float | None = None
        self._last = -np.inf
        self._loaded = True

    def feed(self, datagram: bytes, arrival_s: float, source: Hashable = None) -> list[SensorFrame]:
        """Takes one datagram; returns the frames that are over now, mostly one or none.

        Args:
            datagram: as received; anything.
            arrival_s: by a clock that never goes back, s.
            source: who sent it.
        """
        self.counts.datagrams += 1
        if source != self._source and arrival_s - self._heard_s < BREAK_S:
            self.counts.foreign += 1
            return []
        packet = parse_packet(datagram)
        self.counts.malformed += packet.malformed
        self.counts.unknown += packet.unknown
        if not packet.useful:
            return []
        if source != self._source or self.counts.streams == 0:
            self._hear(source)
            self._begin_stream()
            self.counts.sender = ":".join(map(str, source)) if isinstance(source, tuple) else ""
        self._heard_s = arrival_s
        parts = self._parts(packet)
        self._look(packet, parts, arrival_s)
        if self._held is None:
            return self._take(packet, parts, arrival_s)
        self._held.append((packet, parts, arrival_s))
        if not self._clock.judged and len(self._held) < _MOST_HELD:
            return []
        held, self._held = self._held, None
        return [frame for one in held for frame in self._take(*one)]

    def _look(self, packet: Packet, parts: Parts, arrival_s: float) -> None:
        """Judges the sender's clock; one that goes wrong later begins a new stream."""
        bones = parts.keys() - {ROOT}
        self._clock.look(packet.time_s, bones, arrival_s)
        if self._clock.fault and not self.counts.clock_fault:
            self.counts.clock_fault = self._clock.fault
            if self._held is None:
                self._begin_stream()
        if self._needed:
            self._needed -= bones
            self.counts.missing_bones = tuple(BONES[bone] for bone in sorted(self._needed))

    def _take(self, packet: Packet, parts: Parts, arrival_s: float) -> list[SensorFrame]:
        """Adds a packet to its frame; returns the frames that are over now."""
        if packet.loaded is not None:
            self._loaded = packet.loaded
        if self._clock.fault:
            if parts:
                self._take_unstamped(arrival_s, parts)
        elif packet.time_s is not None:
            self._take_stamped(packet.time_s, parts)
        elif parts and self._stamped:
            self._take_after_stamp(parts)
        elif parts:
            self._take_unstamped(arrival_s if packet.tag_s is None else packet.tag_s, parts)
        return self._release(arrival_s)

    def _begin_stream(self) -> None:
        self._start()
        self.counts.streams += 1

    def _parts(self, packet: Packet) -> dict[int, Transform]:
        """What a packet says of the bones that are used."""
        parts: dict[int, Transform] = {} if packet.root is None else {ROOT: packet.root}
        for name, transform in packet.bones.items():
            bone = find_bone(name)
            if bone is None and not self.counts.strange_bone and not is_unused(name):
                self.counts.strange_bone = name
            if bone is None or (self._body.bones and bone not in self._body.bones):
                self.counts.unknown += 1
            else:
                parts[bone] = transform
                self.counts.bones += 1
        return parts

    def _take_stamped(self, time_s: float, parts: Parts) -> None:
        if not self._stamped:
            # What came before the first stamp is of another clock.
            self._open, self._over, self._newest, self._last = {}, set(), None, -np.inf
            self._stamped = True
        if parts:
            self._put(time_s, parts)
        elif self._loose:
            if self._put(time_s, self._loose):
                self._over.add(time_s)
            self._loose = {}
        else:
            self._stamp = time_s

    def _take_after_stamp(self, parts: Parts) -> None:
        if self._stamp is None:
            self._loose.update(parts)
        else:
            self._put(self._stamp, parts)

    def _take_unstamped(self, time_s: float, parts: Parts) -> None:
        if self._loose.keys() & parts.keys():
            if self._put(self._loose_s, self._loose):
                self._over.add(self._loose_s)
            self._loose = {}
        if not self._loose:
            self._loose_s = time_s
        self._loose.update(parts)
        if self._complete(self._loose):
            self._put(self._loose_s, self._loose)
            self._loose = {}

    def _put(self, time_s: float, parts: Parts) -> bool:
        """Adds to the frame of a time; whether it is not over yet."""
        if self._newest is not None and abs(time_s - self._newest) > BREAK_S:
            kept = self._stamped, self._stamp, self._loaded
            self._begin_stream()
            self._stamped, self._stamp, self._loaded = kept
        if time_s <= self._last:
            self.counts.stale += 1
            return False
        self._open.setdefault(time_s, {}).update(parts)
        self._newest = time_s if self._newest is None else max(self._newest, time_s)
        return True

    def _release(self, arrival_s: float) -> list[SensorFrame]:
        """Gives out all frames that need not wait, in order."""
        released: list[SensorFrame] = []
        while self._open and self._newest is not None:
            first = min(self._open)
            complete = self._complete(self._open[first])
            waited = self._newest - first > WAIT_S or len(self._open) > _MOST_OPEN
            if not (complete or waited or first in self._over):
                break
            self._over.discard(first)
            released += self._close(first, self._open.pop(first), arrival_s)
        return released

    def _complete(self, parts: Parts) -> bool:
        return bool(self._body.bones) and self._body.held(parts) == 0

    def _close(self, time_s: float, parts: Parts, arrival_s: float) -> list[SensorFrame]:
        """A frame is over."""
        self._last = time_s
        self._body.update(parts)
        skeleton = self._body.skeleton
        self.counts.no_body += not self._loaded
        if skeleton is None or not self._loaded:
            return []
        self.counts.frames += 1
        positions, rotations = self._body.pose(skeleton)
        return [
            SensorFrame(
                time_s=time_s,
                arrival_s=arrival_s,
                stream=self.counts.streams,
                body=skeleton,
                positions=positions,
                rotations=rotations,
                held=self._body.held(parts),
            )
        ]
