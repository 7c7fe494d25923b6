"""Packets and frames on their way: in simulated time, and over the loopback interface."""

from __future__ import annotations

import builtins
import socket

import numpy as np
import pytest

from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.clips.types import Clip
from mgjax.core.errors import ConfigError, SkeletonError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import cut
from mgjax.core.skeleton import Skeleton
from mgjax.sensor.config import HOST, PORT, ReplayConfig
from mgjax.sensor.inbox import FrameInbox
from mgjax.sensor.receiver import SensorReceiver
from mgjax.sensor.replay import Recording, play, replay
from tests.sensor.transport import SAFETY_S, Loopback, SimulatedClock, wait_until


@pytest.fixture(scope="module")
def kicks() -> dict[str, Clip]:
    clips, _ = synthetic_kicks(seed=5, frame_rate=60.0, takes=1)
    return {clip.name: clip for clip in clips}


def test_an_inbox_under_a_flood(kicks: dict[str, Clip]) -> None:
    """Noise comes all the time, and nobody takes the frames meanwhile."""
    clip = kicks["kick_pass_left"]
    rng = np.random.default_rng(0)
    sent = Loopback(clip.skeleton, clip.motion, ReplayConfig(speed=4.0))
    while sent.arrive():
        for _ in range(3):
            sent.put(rng.bytes(int(rng.integers(0, 1500))))
    waiting = list(sent.frames(0.5))
    waiting += sent.frames(0.1)  # nothing comes any more
    counts = sent.counts
    assert counts.malformed + counts.foreign > 50
    assert len(waiting) == counts.frames > 50
    assert all(np.isfinite(frame.positions).all() for frame in waiting)


def test_the_oldest_frames_are_dropped(kicks: dict[str, Clip]) -> None:
    clip = kicks["kick_pass_left"]
    sent = Loopback(clip.skeleton, cut(clip.motion, 0, 60), capacity=4)
    while sent.arrive():
        pass
    waiting = list(sent.frames(0.1))
    counts = sent.counts
    assert len(waiting) == 4
    assert counts.overrun == counts.frames - 4 > 0
    assert waiting[-1].time_s == pytest.approx(59 / 60)


def test_a_slow_taker_gets_what_came_in_time(kicks: dict[str, Clip]) -> None:
    """Time that passes while a frame is looked at loses none of those that wait."""
    clip, clock = kicks["kick_pass_left"], SimulatedClock()
    inbox = FrameInbox(clock=clock)
    for _, datagram in Recording(clip.skeleton, cut(clip.motion, 0, 60), ReplayConfig()):
        inbox.put(datagram, "sender")
    taken = 0
    for _ in inbox.frames(0.5):
        taken += 1
        clock.sleep(0.2)
    assert taken == inbox.counts.frames > 10
    assert list(inbox.frames(0.0)) == []


def test_packets_are_sent_when_they_are_due(kicks: dict[str, Clip]) -> None:
    """In order and at their times; a sender that is held up is late by as much, and says so."""
    clip, clock = kicks["kick_pass_left"], SimulatedClock()
    config = ReplayConfig(speed=2.0, loss=0.1, reorder=0.2, jitter_s=0.01, seed=3)
    recording = Recording(clip.skeleton, cut(clip.motion, 0, 60), config)
    sent: list[tuple[float, bytes]] = []

    def send(datagram: bytes) -> None:
        sent.append((clock.now, datagram))
        if len(sent) == 20:
            clock.sleep(0.25)

    clock.until(7.0)
    replayed = play(recording, send, clock=clock, sleep=clock.sleep)
    due = list(recording)
    assert [datagram for _, datagram in sent] == [datagram for _, datagram in due]
    late = np.array([at - 7.0 - time for (at, _), (time, _) in zip(sent, due, strict=True)])
    assert (late > -1e-4).all()
    assert (np.abs(late[:20]) < 1e-3).all()
    assert late[20] == pytest.approx(0.25 - (due[20][0] - due[19][0]), abs=1e-3)
    assert np.abs(late[-1]) < 1e-3  # it has caught up
    assert replayed.late_s == pytest.approx(late.max(), abs=1e-3)
    assert (replayed.packets, replayed.lost) == (len(due), 120 - len(due))
    assert replayed.frames == 60
    assert replayed.seconds == pytest.approx(due[-1][0], abs=1e-2)


def test_what_is_sent_over_loopback_arrives(kicks: dict[str, Clip]) -> None:
    """Through real sockets: every datagram, and with the last of them the last frame."""
    clip = kicks["kick_pass_left"]
    motion = cut(clip.motion, 0, 60)
    with SensorReceiver(port=0) as receiver:
        sent = replay(clip.skeleton, motion, port=receiver.port, config=ReplayConfig(speed=4.0))
        wait_until(lambda: receiver.counts.datagrams >= sent.packets)
        waiting = []
        for frame in receiver.frames(SAFETY_S):
            waiting.append(frame)
            if frame.time_s > 58.5 / 60:
                break
        counts = receiver.counts
    assert (sent.frames, sent.packets, sent.lost) == (60, 120, 0)
    assert counts.datagrams == 120
    assert counts.malformed == counts.unknown == counts.stale == counts.foreign == 0
    assert len(waiting) == counts.frames > 30
    places = np.asarray(global_positions(clip.skeleton, motion))
    joints = [clip.skeleton.index(name) for name in waiting[-1].body.names]
    np.testing.assert_allclose(waiting[-1].positions, places[59, joints], atol=1e-4)
    arrivals = [frame.arrival_s for frame in waiting]
    assert arrivals == sorted(arrivals)


def test_noise_over_loopback(kicks: dict[str, Clip]) -> None:
    """What is no packet is counted and dropped by the thread that listens."""
    clip = kicks["kick_pass_left"]
    rng = np.random.default_rng(0)
    with (
        SensorReceiver(port=0) as receiver,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        for number in range(50):
            other.sendto(rng.bytes(int(rng.integers(1, 1500))), (HOST, receiver.port))
            wait_until(lambda number=number: receiver.counts.datagrams > number)
        assert receiver.counts.malformed == 50
        (_, datagram), *_ = Recording(clip.skeleton, clip.motion, ReplayConfig())
        other.sendto(datagram, (HOST, receiver.port))
        wait_until(lambda: receiver.counts.datagrams == 51)
        assert receiver.counts.malformed == 50
        assert receiver.counts.streams == 1


def test_silence() -> None:
    with SensorReceiver(port=0) as receiver:
        assert list(receiver.frames(0.02)) == []
        assert receiver.counts.datagrams == 0
        with pytest.raises(ConfigError, match=f"{receiver.port} to listen on .* expected a free"):
            SensorReceiver(port=receiver.port)


def test_refused(kicks: dict[str, Clip], body: Skeleton, random_motion, monkeypatch) -> None:
    clip = kicks["kick_pass_left"]
    assert (HOST, PORT) == ("127.0.0.1", 39539)
    for config, words in (
        (ReplayConfig(rate=0.0), "rate = 0"),
        (ReplayConfig(speed=-1.0), "speed = -1"),
        (ReplayConfig(speed=float("nan")), "speed = nan"),
        (ReplayConfig(loss=1.5), "loss = 1.5, expected 0 … 1"),
        (ReplayConfig(reorder=float("nan")), "reorder = nan"),
        (ReplayConfig(jitter_s=-0.1), "jitter_s = -0.1, expected 0 … 10"),
        (ReplayConfig(seed=-1), "seed = -1"),
    ):
        with pytest.raises(ConfigError, match=f"^got {words}"):
            replay(clip.skeleton, clip.motion, config=config)
    with pytest.raises(ConfigError, match="port 70000"):
        replay(clip.skeleton, clip.motion, port=70000)
    with pytest.raises(ConfigError, match="no-such-host"):
        replay(clip.skeleton, clip.motion, host="no-such-host.invalid")
    for host in ("256.1.1.1", "a" * 300):
        with pytest.raises(ConfigError, match="got"):
            SensorReceiver(host=host)
    legless = Skeleton(names=("root", "top"), parents=(-1, 0), offsets=np.ones((2, 3), np.float32))
    with pytest.raises(SkeletonError, match="left_hip"):
        replay(legless, random_motion(legless), port=9)

    real = builtins.__import__

    def absent(name: str, *rest, **more):
        if name.startswith("pythonosc"):
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", absent)
    with pytest.raises(ConfigError, match=r"pip install 'mgjax\[sensor\]'"):
        replay(clip.skeleton, clip.motion, port=9)
