"""Frames from packets in all orders, and from packets that are none."""

from __future__ import annotations

import gc
import struct
import tracemalloc
from collections.abc import Iterable

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core.kinematics import global_positions
from mgjax.sensor.body import LEARNING_FRAMES
from mgjax.sensor.bone_table import BONES, PARENTS
from mgjax.sensor.bones import encode, find_bones, usual_places
from mgjax.sensor.config import ReplayConfig
from mgjax.sensor.frames import BREAK_S, FrameAssembler, SensorFrame
from mgjax.sensor.replay import packet_builder, schedule
from tests.sensor.test_packets import bone, bundle, message

NAMES = ("Hips", "LeftUpperLeg", "LeftLowerLeg", "LeftFoot")
NAMES = (*NAMES, "RightUpperLeg", "RightLowerLeg", "RightFoot")
STEP = 0.125
"""Seconds from frame to frame; a number that survives four bytes."""


def stamp(k: int) -> bytes:
    return message("/VMC/Ext/T", k * STEP)


def legs(k: int, names: Iterable[str] = NAMES) -> list[bytes]:
    """Frame k: the hips k cm to the body's right, which is +X in Unity; legs of 0.4 and 0.4 m."""
    places = {"Hips": (0.01 * k, 1.0, 0.0)}
    for side, x in (("Left", -0.1), ("Right", 0.1)):
        places[side + "UpperLeg"] = (x, 0.0, 0.0)
        places[side + "LowerLeg"] = places[side + "Foot"] = (0.0, -0.4, 0.0)
        places[side + "Toes"] = (0.0, -0.05, 0.1)
    return [bone(name, places.get(name, (0.0, 0.0, 0.0))) for name in names]


def whole(k: int) -> bytes:
    return bundle(stamp(k), *legs(k))


def feed(assembler: FrameAssembler, datagrams: Iterable[bytes], at: float = 0.0, source=None):
    """All frames given out for these, a millisecond apart."""
    frames: list[SensorFrame] = []
    for number, datagram in enumerate(datagrams):
        frames += assembler.feed(datagram, at + 0.001 * number, source)
    return frames


def settled() -> FrameAssembler:
    """One that knows the body; frames up to 99 are over."""
    assembler = FrameAssembler()
    # The first frames wait for bones that may come yet, the last of them for its successor.
    feed(assembler, [whole(k) for k in range(100 - LEARNING_FRAMES - 1, 100)])
    return assembler


def hips(frame: SensorFrame) -> float:
    """The k of a frame, as in :func:`legs`."""
    return round(-100 * float(frame.positions[0, 0]), 3)


def test_a_body_is_learnt_and_placed() -> None:
    frames = feed(FrameAssembler(), [whole(k) for k in range(LEARNING_FRAMES + 2)])
    assert [hips(frame) - LEARNING_FRAMES for frame in frames] == [-1, 0, 1]
    frame = frames[0]
    assert frame.body.names == ("root", "lfemur", "ltibia", "lfoot", "rfemur", "rtibia", "rfoot")
    assert (frame.held, frame.stream) == (0, 1)
    assert frame.time_s == (LEARNING_FRAMES - 1) * STEP
    x = -0.01 * (LEARNING_FRAMES - 1)
    expected = [[x, 1, 0], [x + 0.1, 1, 0], [x + 0.1, 0.6, 0], [x + 0.1, 0.2, 0]]
    np.testing.assert_allclose(frame.positions[:4], expected, atol=1e-6)


def test_the_root_moves_the_body() -> None:
    # Unity's root a quarter turned to the left, at (1, 0, 2): hips at (0.5, 1, 0) come to z = 2.5.
    half = float(np.sqrt(0.5))
    root = message("/VMC/Ext/Root/Pos", "root", 1.0, 0.0, 2.0, 0.0, -half, 0.0, half)
    (frame,) = feed(settled(), [bundle(stamp(101), root, *legs(50))])
    np.testing.assert_allclose(frame.positions[0], [-1.0, 1.0, 2.5], atol=1e-6)


ORDERS = {
    "one packet": lambda k: [whole(k)],
    "stamp last in the bundle": lambda k: [bundle(*legs(k), stamp(k))],
    "two bundles": lambda k: [bundle(stamp(k), *legs(k)[:3]), bundle(stamp(k), *legs(k)[3:])],
    "stamp before": lambda k: [stamp(k), *legs(k)],
    "stamp before a bundle": lambda k: [stamp(k), bundle(*legs(k))],
    "stamp after": lambda k: [*legs(k), stamp(k)],
    "stamp after a bundle": lambda k: [bundle(*legs(k)), stamp(k)],
}


@pytest.mark.parametrize("kind", ORDERS)
def test_orders_of_a_frame(kind: str) -> None:
    assembler = FrameAssembler()
    frames = feed(assembler, [p for k in range(40) for p in ORDERS[kind](k)])
    assert [hips(frame) for frame in frames] == list(range(LEARNING_FRAMES - 1, 40))
    assert [frame.time_s for frame in frames] == [STEP * k for k in range(LEARNING_FRAMES - 1, 40)]
    assert all(frame.held == 0 for frame in frames)
    assert (assembler.counts.stale, assembler.counts.streams) == (0, 1)


def test_without_stamps() -> None:
    frames = feed(FrameAssembler(), [p for k in range(40) for p in legs(k)], at=5.0)
    assert [hips(frame) for frame in frames] == list(range(LEARNING_FRAMES - 1, 40))
    times = [frame.time_s for frame in frames]
    np.testing.assert_allclose(np.diff(times), 0.001 * len(NAMES))  # arrivals of the first bones
    heads = [b"#bundle\0" + struct.pack(">Q", int((3e9 + k * STEP) * 2**32)) for k in range(40)]
    frames = feed(FrameAssembler(), [bundle(*legs(k), head=heads[k]) for k in range(40)])
    assert [frame.time_s - 3e9 for frame in frames] == [
        STEP * k for k in range(LEARNING_FRAMES - 1, 40)
    ]


def test_missing_bones_are_held() -> None:
    assembler = settled()
    assert feed(assembler, [bundle(stamp(100), *legs(100, NAMES[1:]))]) == []  # waits for them
    frames = feed(assembler, [whole(101)])
    assert [(hips(frame), frame.held) for frame in frames] == [(99, 1), (101, 0)]
    expected = [[side * 0.1, -0.4 * k, 0.0] for side in (1, -1) for k in range(3)]
    np.testing.assert_allclose(
        frames[0].positions[1:] - frames[0].positions[:1], expected, atol=1e-6
    )


def test_late_packets_are_dropped() -> None:
    assembler = settled()
    frames = feed(assembler, [whole(101), whole(100), whole(101), whole(102)])
    assert [hips(frame) for frame in frames] == [101, 102]
    assert assembler.counts.stale == 2


def test_parts_of_neighbours_may_mix() -> None:
    def quick(k: int, names: Iterable[str]) -> bytes:
        return bundle(message("/VMC/Ext/T", 99 * STEP + k / 128), *legs(k, names))

    a, b = NAMES[:3], NAMES[3:]
    order = [quick(1, a), quick(2, a), quick(3, b), quick(1, b), quick(3, a), quick(2, b)]
    frames = feed(settled(), order)
    assert [(hips(frame), frame.held) for frame in frames] == [(1, 0), (2, 0), (3, 0)]
    # What never comes is waited for only so long.
    frames = feed(settled(), [quick(k, a if k == 1 else NAMES) for k in range(1, 8)])
    assert [(hips(frame), frame.held) for frame in frames] == [
        *((1, 4), (2, 0), (3, 0), (4, 0), (5, 0)),
        *((6, 0), (7, 0)),
    ]


def test_a_new_stream() -> None:
    assembler = settled()
    jump = round(BREAK_S / STEP) + 2
    assert feed(assembler, [whole(100 - jump)]) == []  # a sender that began anew
    assert assembler.counts.streams == 2
    frames = feed(assembler, [whole(100 - jump + k) for k in range(1, 30)])
    assert {frame.stream for frame in frames} == {2}
    assert assembler.counts.stale == 0
    # A lie about the time costs some frames, never the stream for good.
    lie = bundle(message("/VMC/Ext/T", 9e8), bone("Hips"))
    frames = feed(assembler, [lie, *(whole(100 - jump + k) for k in range(30, 60))])
    assert [hips(frame) for frame in frames][-1] == 100 - jump + 59


NO_POSE = bundle(message("/VMC/Ext/Blend/Apply"))


def test_a_second_sender_is_not_heard() -> None:
    assembler = settled()
    assert feed(assembler, [whole(100)], at=0.2, source="other") == []
    assert (assembler.counts.foreign, assembler.counts.streams) == (1, 1)
    # Until the first has been silent for long enough. Noise takes nobody's place.
    assert feed(assembler, [b"noise", NO_POSE], at=5.0, source="noise") == []
    assert len(feed(assembler, [whole(k) for k in range(30)], at=5.1, source="other")) > 0
    assert (assembler.counts.foreign, assembler.counts.streams) == (1, 2)


def test_a_sender_without_a_body_says_so() -> None:
    assembler = settled()
    not_loaded, loaded = message("/VMC/Ext/OK", 0), message("/VMC/Ext/OK", 1)
    assert feed(assembler, [not_loaded, whole(100), whole(101)]) == []
    assert [hips(frame) for frame in feed(assembler, [loaded, whole(102)])] == [102]


def test_bones_of_no_use() -> None:
    assembler = settled()
    more = [bone("LeftEye"), bone("Tail"), bone("Spine"), bone("leftThumbMetacarpal")]
    (frame,) = feed(assembler, [bundle(stamp(100), *more, *legs(100))])
    assert len(frame.positions) == len(NAMES)
    assert assembler.counts.unknown == 4
    assert assembler.counts.strange_bone == "Tail"
    # Without legs there is no body, however long it takes.
    assert feed(FrameAssembler(), [bundle(stamp(k), *legs(k, NAMES[:4])) for k in range(200)]) == []


def test_places_of_zero_are_those_of_the_embedded_body() -> None:
    names = [name for name in BONES if name not in ("UpperChest", "LeftToes", "RightToes")]
    turned = [bone("Hips", (0.0, 0.9, 0.0)), *(bone(name) for name in names[1:])]
    frames = feed(FrameAssembler(), [bundle(stamp(k), *turned) for k in range(40)])
    head = frames[-1].body.index("head")
    expected = np.array([0.0, 0.9, 0.0])
    at = BONES.index("Head")
    while at > 0:
        expected, at = expected + usual_places()[at], PARENTS[at]
    np.testing.assert_allclose(frames[-1].positions[head], expected, atol=1e-6)


def test_a_clip_survives_the_wire(random_motion) -> None:
    """All joints with a bone stand where they stood, to a hundredth of a millimetre."""
    skeleton = synthetic_skeleton()
    motion = random_motion(skeleton, frames=30)
    poses, build, assembler = encode(skeleton, motion), packet_builder(), FrameAssembler()
    packets = [build(poses, frame, piece, frame / 120) for frame in range(30) for piece in range(2)]
    assert all(len(packet) <= 1472 for packet in packets)
    frames = feed(assembler, packets)
    assert assembler.counts.malformed == assembler.counts.unknown == 0
    places = np.asarray(global_positions(skeleton, motion))
    joints = [skeleton.index(name) for name in frames[0].body.names]
    assert len(frames) == 30 - LEARNING_FRAMES + 1
    assert sorted(joints) == sorted(find_bones(skeleton).values())
    for frame in frames:
        number = round(frame.time_s * 120)
        np.testing.assert_allclose(frame.positions, places[number, joints], atol=1e-5)


def test_floods_leave_nothing_behind() -> None:
    assembler = settled()
    rng = np.random.default_rng(0)
    noise = [rng.bytes(int(n)) for n in rng.integers(0, 2000, size=60)]
    many = [bone(f"Bone{k}") for k in range(60)]
    stamps = [message("/VMC/Ext/T", float(t)) for t in rng.normal(12.5, 2.0, size=60)]
    some = [bundle(message("/VMC/Ext/T", float(t)), bone("Hips")) for t in rng.uniform(12, 13, 180)]

    def flood() -> None:
        feed(assembler, noise)
        feed(assembler, many)
        feed(assembler, stamps)
        feed(assembler, some)
        feed(assembler, [bundle(*many)] * 4)

    flood()
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    for _ in range(3):
        flood()
    gc.collect()  # what is left is held, and not only not yet looked for
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert after - before < 50_000
    counts = assembler.counts
    assert counts.datagrams == 21 + 4 * (60 + 60 + 60 + 180 + 4)
    assert counts.malformed > 200
    assert counts.unknown > 4 * 4 * 60
    # And it still works.
    assert feed(assembler, [whole(k) for k in range(1000, 1030)])


@hypothesis.given(st.lists(st.integers(0, 60), max_size=60), st.integers(0, 2**32 - 1))
def test_any_order_gives_rising_times(order: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    assembler = settled()
    last = (1, 0.0)
    for k in order:
        names = [name for name in NAMES if rng.uniform() < 0.7]
        parts = legs(k, names) + [stamp(90 + k)] * int(rng.uniform() < 0.6)
        rng.shuffle(parts)
        for frame in assembler.feed(bundle(*parts), 0.1):
            assert np.isfinite(frame.positions).all()
            assert (frame.stream, frame.time_s) > last
            last = frame.stream, frame.time_s


def test_what_goes_wrong_on_the_way_is_drawn_by_the_seed() -> None:
    clean, order = schedule(50, 2, 100.0, ReplayConfig(speed=2.0))
    np.testing.assert_allclose(clean, np.repeat(np.arange(50) / 200, 2))
    np.testing.assert_array_equal(order, np.arange(100))
    config = ReplayConfig(loss=0.2, reorder=0.2, jitter_s=0.002, seed=3)
    due, order = schedule(50, 2, 100.0, config)
    again = schedule(50, 2, 100.0, config)
    np.testing.assert_array_equal(due, again[0])
    np.testing.assert_array_equal(order, again[1])
    assert 60 < len(order) < 95
    assert (np.diff(due[order]) >= 0).all()
    assert (np.diff(order) < 0).sum() > 5
    late = due - np.repeat(np.arange(50) / 100, 2)
    assert late.min() >= 0
    assert late.max() <= 0.015 + 0.002
    assert len(schedule(50, 2, 100.0, ReplayConfig(loss=1.0))[1]) == 0
