"""A recorded clip as a motion sensor: its frames sent in real time by the VMC protocol."""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import ModuleType

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.errors import ConfigError
from mgjax.core.motion import Motion, resample
from mgjax.core.skeleton import Skeleton
from mgjax.sensor.bones import BONES, BonePoses, encode
from mgjax.sensor.clock import Clock, clock
from mgjax.sensor.config import HOST, PORT, ReplayConfig, validate_replay
from mgjax.sensor.receiver import address

_BONES_A_PACKET = 12
"""So that a packet is shorter than the 1,472 bytes that common networks carry in one piece."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Replayed:
    """What was sent.

    Attributes:
        frames: of the clip at the rate of sending.
        packets: sent.
        lost: packets left out on purpose.
        seconds: how long it took.
        late_s: the most that a packet was sent after its time, s.
        start_s: when it began, by the clock of :func:`mgjax.sensor.clock.clock`.
    """

    frames: int
    packets: int
    lost: int
    seconds: float
    late_s: float
    start_s: float


def replay(
    skeleton: Skeleton,
    motion: Motion,
    *,
    host: str = HOST,
    port: int = PORT,
    config: ReplayConfig | None = None,
) -> Replayed:
    """Sends a clip, each frame at its time; returns when the last has been sent.

    Each frame is two bundles of bones, either with ``/VMC/Ext/T``; the first has the model's root
    and ``/VMC/Ext/OK`` too. See :mod:`mgjax.sensor.bones` for bones, axes and rest pose.

    Raises:
        ConfigError: python-osc is not there, the host is not known, or a setting that cannot be.
        SkeletonError: the skeleton has no legs.
    """
    config = config or ReplayConfig()
    validate_replay(config)
    place = address(host, port)
    recording = Recording(skeleton, motion, config)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:

        def send(datagram: bytes) -> None:
            try:
                sender.sendto(datagram, place)
            except OSError as error:
                raise ConfigError(
                    f"got {host}:{port} to send to ({error.strerror}), expected a host that can be"
                    " reached"
                ) from None

        return play(recording, send)


class Recording:
    """A clip as the packets that a sensor sends, in the order and at the times of sending.

    Attributes:
        frames: of the clip at the rate of sending.
        packets: that are sent.
        lost: packets left out on purpose.

    Raises:
        ConfigError: python-osc is not there.
        SkeletonError: the skeleton has no legs.
    """

    def __init__(self, skeleton: Skeleton, motion: Motion, config: ReplayConfig) -> None:
        if config.rate is not None:
            motion = resample(motion, config.rate)
        self._poses, self._rate = encode(skeleton, motion), motion.frame_rate
        self._pieces = math.ceil(len(self._poses.bones) / _BONES_A_PACKET)
        self.frames = len(self._poses.places)
        self._due, self._order = schedule(self.frames, self._pieces, self._rate, config)
        self._build = packet_builder()
        self.packets = len(self._order)
        self.lost = len(self._due) - self.packets

    def __iter__(self) -> Iterator[tuple[float, bytes]]:
        """When each packet is due, s from the start, and its bytes."""
        for number in self._order:
            frame, piece = divmod(int(number), self._pieces)
            yield (
                float(self._due[number]),
                self._build(self._poses, frame, piece, frame / self._rate),
            )


def play(
    recording: Recording,
    send: Callable[[bytes], None],
    *,
    clock: Clock = clock,
    sleep: Callable[[float], None] = time.sleep,
) -> Replayed:
    """Sends each packet of a recording when it is due.

    Args:
        recording: the packets.
        send: takes one datagram.
        clock: tells the time, s.
        sleep: waits so many seconds of that clock.
    """
    late, start = 0.0, clock()
    for due, datagram in recording:
        at = start + due
        sleep(max(at - clock(), 0.0))
        late = max(late, clock() - at)
        send(datagram)
    return Replayed(
        frames=recording.frames,
        packets=recording.packets,
        lost=recording.lost,
        seconds=clock() - start,
        late_s=late,
        start_s=start,
    )


def schedule(
    frames: int, pieces: int, rate: float, config: ReplayConfig
) -> tuple[Float[np.ndarray, " P"], Int[np.ndarray, " Q"]]:
    """When each packet is due, s from the start, and which are sent, in this order."""
    rng = np.random.default_rng(config.seed)
    period = 1 / (rate * config.speed)
    due = np.repeat(np.arange(frames) * period, pieces)
    lost, swapped, late = rng.uniform(size=(3, len(due)))
    # Half a period after the next frame.
    due += 1.5 * period * (swapped < config.reorder) + late * config.jitter_s
    order = np.argsort(due, kind="stable")
    return due, order[lost[order] >= config.loss]


class PacketBuilder:
    """Makes packets with python-osc."""

    def __init__(self, bundles: ModuleType, messages: ModuleType) -> None:
        self._bundles, self._messages = bundles, messages

    def __call__(self, poses: BonePoses, frame: int, piece: int, time_s: float) -> bytes:
        """One of the packets of a frame."""
        bundle = self._bundles.OscBundleBuilder(self._bundles.IMMEDIATELY)
        for path, values in self._contents(poses, frame, piece, time_s):
            message = self._messages.OscMessageBuilder(path)
            for value in values:
                kind = {str: "s", int: "i", float: "f"}[type(value)]
                message.add_arg(value, kind)
            bundle.add_content(message.build())
        return bundle.build().dgram

    def _contents(
        self, poses: BonePoses, frame: int, piece: int, time_s: float
    ) -> Iterator[tuple[str, list[str | int | float]]]:
        if piece == 0:
            yield "/VMC/Ext/OK", [1]
        yield "/VMC/Ext/T", [float(time_s)]
        if piece == 0:
            yield "/VMC/Ext/Root/Pos", ["root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        first = piece * _BONES_A_PACKET
        for number, bone in enumerate(poses.bones[first : first + _BONES_A_PACKET], start=first):
            w, x, y, z = poses.rotations[frame, number].tolist()
            place = poses.places[frame, number].tolist()
            yield "/VMC/Ext/Bone/Pos", [BONES[bone], *place, x, y, z, w]


def packet_builder() -> PacketBuilder:
    """Needs python-osc; :class:`ConfigError` says how to get it."""
    try:
        from pythonosc import osc_bundle_builder, osc_message_builder
    except ImportError:
        raise ConfigError(
            "got no python-osc, with which packets are made, expected it to be installed:"
            " pip install 'mgjax[sensor]'"
        ) from None
    return PacketBuilder(osc_bundle_builder, osc_message_builder)
