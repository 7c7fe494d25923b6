"""Clocks that do not tell the time."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.sensor.body import LEARNING_FRAMES
from mgjax.sensor.frames import FrameAssembler, SensorFrame
from mgjax.sensor.packets import parse_packet
from mgjax.sensor.sender_clock import FRAMES, SenderClock
from tests.sensor.test_frames import NAMES, hips, legs
from tests.sensor.test_packets import bone, bundle, message

RATE = 60.0
COUNT = 50


def test_steps_by_hand() -> None:
    clock = SenderClock()
    for k in range(FRAMES + 1):
        assert not clock.judged
        clock.look(k / RATE, [0], k / RATE)
        clock.look(k / RATE, [1, 2], k / RATE)  # the rest of the frame
    assert clock.judged
    assert clock.fault == ""
    # What comes late and in a heap, or is played 40 times as fast, is in order.
    for scale in (0.0, 1 / 40):
        clock = SenderClock()
        for k in range(30):
            clock.look(k / RATE, [0], scale * k / RATE)
        assert clock.fault == ""
    still = SenderClock()
    for k in range(6):
        assert not still.fault
        still.look(3.0, [0, 1], k / RATE)
    assert still.fault == "stands still in 5 of 5 frames"


def test_a_packet_that_comes_twice_is_no_clock_that_stands_still() -> None:
    clock = SenderClock()
    for k in range(30):
        clock.look(k / RATE, [0, 1], k / RATE)
        clock.look(k / RATE, [0, 1], k / RATE + 1e-5)
    assert clock.fault == ""


def test_a_sender_that_begins_anew_is_no_clock_that_jumps() -> None:
    clock = SenderClock()
    for k in range(60):
        clock.look(k / RATE - 1000.0 * (k >= 20) + 7.0 * (k >= 40), [0], k / RATE)
    assert clock.fault == ""


CLOCKS = {
    "never changes": (lambda t, k: 5.0, "stands still"),
    "milliseconds": (lambda t, k: 1000.0 * t, "counts milliseconds"),
    "milliseconds since 1970": (lambda t, k: 1.7e12 + 1000.0 * t, "stands still"),
    "float32 after 30 days": (lambda t, k: np.float32(30 * 86400 + t), "stands still"),
    "jumps": (lambda t, k: t + 100.0 * (k % 3), "jumps by more than 1 s"),
}


def play(clock, *, two: bool = False) -> tuple[FrameAssembler, list[SensorFrame]]:
    assembler, frames = FrameAssembler(), []
    for k in range(COUNT):
        stamp = message("/VMC/Ext/T", float(clock(k / RATE, k)))
        pieces = [legs(k)[:3], legs(k)[3:]] if two else [legs(k)]
        for number, piece in enumerate(pieces):
            frames += assembler.feed(bundle(stamp, *piece), 100 + k / RATE + 1e-4 * number)
    return assembler, frames


@pytest.mark.parametrize("two", [False, True])
@pytest.mark.parametrize("kind", CLOCKS)
def test_the_time_of_arrival_takes_over(kind: str, two: bool) -> None:
    """From the first frame on: no frame is lost, and none is of two times."""
    clock, fault = CLOCKS[kind]
    assembler, frames = play(clock, two=two)
    counts = assembler.counts
    assert counts.clock_fault.startswith(fault)
    assert (counts.streams, counts.stale, counts.malformed) == (1, 0, 0)
    assert [hips(frame) for frame in frames] == list(range(LEARNING_FRAMES - 1, COUNT))
    np.testing.assert_allclose(
        [frame.time_s for frame in frames],
        [100 + hips(frame) / RATE for frame in frames],
        atol=1e-3,
    )
    assert all(frame.held == 0 for frame in frames)


def test_a_clock_that_stops_later() -> None:
    assembler, frames = play(lambda t, k: min(t, 25 / RATE))
    assert assembler.counts.clock_fault.startswith("stands still in 5 of 8")
    assert assembler.counts.streams == 2
    assert frames[-1].stream == 1
    for k in range(COUNT, COUNT + LEARNING_FRAMES + 5):
        frames += assembler.feed(bundle(message("/VMC/Ext/T", 0.4), *legs(k)), 100 + k / RATE)
    assert frames[-1].stream == 2
    times = [frame.time_s for frame in frames if frame.stream == 2]
    np.testing.assert_allclose(np.diff(times), 1 / RATE, atol=1e-6)


def test_names_of_vrm_1() -> None:
    names = [name[:1].lower() + name[1:] for name in NAMES]
    places = [parse_packet(part).bones[name][:3] for part, name in zip(legs(0), NAMES, strict=True)]
    usual, lower = FrameAssembler(), FrameAssembler()
    for k in range(30):
        stamp = message("/VMC/Ext/T", k / RATE)
        small = [bone(name, places[i]) for i, name in enumerate(names)]
        expected = usual.feed(bundle(stamp, *legs(0)), k / RATE)
        found = lower.feed(bundle(stamp, *small), k / RATE)
        for a, b in zip(expected, found, strict=True):
            np.testing.assert_array_equal(a.positions, b.positions)
    assert lower.counts.frames == usual.counts.frames > 0
