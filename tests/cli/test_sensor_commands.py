"""``mgjax sensor``: a clip sent as a sensor sends it, and kicks heard."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mgjax.cli.sensor import wander
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, resample
from mgjax.core.skeleton import Skeleton
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion
from mgjax.sensor.body import LEARNING_FRAMES
from mgjax.sensor.bone_table import JOINT_NAMES
from mgjax.sensor.bones import find_bones
from mgjax.sensor.frames import SensorFrame
from mgjax.sensor.receiver import SensorReceiver
from mgjax.sensor.replay import Recording, Replayed, play
from tests.cli.conftest import refused, run
from tests.sensor.transport import SAFETY_S, PlayedReceiver, SimulatedClock, wait_until


@pytest.fixture(scope="module")
def kick(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made attack of the right foot as a BVH file."""
    path = tmp_path_factory.mktemp("kick") / "kick.bvh"
    clips, _ = synthetic_kicks(seed=2, frame_rate=60.0, takes=1)
    clip = next(clip for clip in clips if clip.name == "kick_attack_right")
    save_bvh(path, clip.skeleton, clip.motion)
    return path


def test_replay_is_heard(kick: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One process sends, this one listens for as long as the other sends."""
    out = tmp_path / "out"
    command = [sys.executable, "-m", "mgjax", "sensor", "replay", str(kick), "--json"]
    command += ["--speed", "2", "--loss", "0.02", "--out", str(out)]
    sent: dict[str, Any] = {}

    class Hearing(SensorReceiver):
        """Ends when all that was sent has come, and not when a time is over."""

        def frames(self, seconds: float) -> Iterator[SensorFrame]:
            if sent:  # what is left of the time
                return
            assert seconds == 3.0
            replayed = subprocess.run(
                [*command, "--port", str(self.port)],
                capture_output=True,
                text=True,
                timeout=SAFETY_S,
                check=False,
            )
            assert (replayed.returncode, replayed.stderr) == (0, "")
            sent.update(json.loads(replayed.stdout), port=self.port)
            wait_until(lambda: self.counts.datagrams >= sent["packets"])
            yield from super().frames(0.1)

    monkeypatch.setattr("mgjax.cli.sensor.SensorReceiver", Hearing)
    heard = run("sensor", "listen", "--port", 0, "--seconds", 5)
    assert heard.status == 0, heard.err
    found = re.search(r"listening on 127\.0\.0\.1:(\d+)", heard.err)
    assert found, heard.err
    assert int(found[1]) == sent["port"]
    assert json.loads((out / "replay.json").read_text()) == sent
    assert sent["packets"] + sent["lost"] == 2 * sent["frames"]
    (event,) = [json.loads(text) for text in heard.out.splitlines()]
    assert (event["bone"], event["kind"]) == ("right_foot", "attack")
    assert 0 < event["latency_s"] < event["latency_from_fastest_s"]
    assert "1 kicks" in heard.err


def test_settings_of_listening(kick: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a settings file says is what kicks are found and compared with."""
    monkeypatch.setattr("mgjax.cli.sensor.SensorReceiver", PlayedReceiver.of(*load_motion(kick)))
    listen = ("sensor", "listen", "--seconds", 60, "--json")
    (usual,) = run(*listen).json["kicks"]
    file = tmp_path / "listen.toml"
    file.write_text("takes = 1\n[match]\nw_v = 0.0\nw_m = 0.0\nw_t = 1.0\n")
    (weighed,) = run(*listen, "--config", file).json["kicks"]
    assert (weighed["bone"], weighed["fastest_s"]) == (usual["bone"], usual["fastest_s"])
    assert 0 < weighed["distance"] < usual["distance"]  # of times alone
    file.write_text('bones = ["left_foot"]\n')
    assert run(*listen, "--config", file).json["kicks"] == []
    for text, words in (
        ("[analysis]\nreach_s = -1.0\n", "analysis.reach_s = -1.0, expected 0 … 60"),
        ("[analysis]\nheight = 1.0\n", "'analysis.height', expected one such as 'height_m'"),
        ("[kinds]\npass_m_s = 9.0\n", "kinds.attack_m_s = 7.2, expected at least pass_m_s"),
        ("[match]\nw_t = inf\n", "match.w_t = inf"),
        ("[match]\nw_v = 0.0\nw_m = 0.0\nw_t = 0.0\n", "expected one above 0"),
        ('bones = ["knee"]\n', "bones with 'knee'"),
        ("bones = []\n", "bones = []"),
        ("takes = 0\n", "takes = 0, expected 1 … 20"),
        ("frame_rate = 1.0\n", "frame_rate = 1.0, expected 20 … 240"),
        ("seed = -1\n", "seed = -1"),
    ):
        file.write_text(text)
        refused(run(*listen, "--config", file), words)


def test_replay_in_words(kick: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as deaf:
        deaf.bind(("127.0.0.1", 0))
        port = deaf.getsockname()[1]
        ran = run("sensor", "replay", kick, "--port", port, "--speed", 40, "--rate", 30)
    assert (ran.status, ran.err) == (0, "")
    assert "frames sent to 127.0.0.1" in ran.out


@pytest.mark.parametrize("what", ["graph", "file"])
def test_what_is_sent_is_received(
    what: str, built: tuple[Path, Any], kick: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over loopback to our own receiver, by a clock that does not wait: joints stand where a walk
    or a clip put them, to a tenth of a millimetre."""
    wanted: list[tuple[Skeleton, Motion]] = []

    def at_once(skeleton: Skeleton, motion: Motion, **options: Any) -> Replayed:
        """Each packet is sent when the one before has come."""
        wanted.append((skeleton, resample(motion, 20.0)))
        recording, clock = Recording(skeleton, motion, options["config"]), SimulatedClock()
        place = options["host"], options["port"]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:

            def put(datagram: bytes) -> None:
                before = receiver.counts.datagrams
                out.sendto(datagram, place)
                wait_until(lambda: receiver.counts.datagrams > before)

            return play(recording, put, clock=clock, sleep=clock.sleep)

    monkeypatch.setattr("mgjax.cli.sensor.play", at_once)
    which = ("--graph", built[0]) if what == "graph" else (kick,)
    with SensorReceiver(port=0) as receiver:
        words = ("--port", receiver.port, "--seconds", 2, "--fps", 20, "--json")
        sent = run("sensor", "send", *which, *words)
        assert sent.status == 0, sent.err
        frames = list(receiver.frames(0.05))
        counts = receiver.counts
    ((skeleton, motion),) = wanted
    assert sent.json["frames"] == motion.num_frames
    if what == "graph":
        assert sent.json["frames"] == 41
    assert counts.datagrams == sent.json["packets"]
    assert counts.malformed == counts.unknown == counts.stale == counts.foreign == 0
    assert counts.clock_fault == ""
    places = np.asarray(global_positions(skeleton, motion))
    bones = find_bones(skeleton)
    joints = {JOINT_NAMES[bone]: joint for bone, joint in bones.items()}
    assert len(frames) == counts.frames == motion.num_frames - LEARNING_FRAMES + 1
    for frame in frames:
        expected = places[round(frame.time_s * 20), [joints[name] for name in frame.body.names]]
        np.testing.assert_allclose(frame.positions, expected, atol=1e-4)


def test_sending_twice_sends_the_same_walk(built: tuple[Path, Any]) -> None:
    _, first = wander(built[0], 3.0, 5)
    _, second = wander(built[0], 3.0, 5)
    _, other = wander(built[0], 3.0, 6)
    np.testing.assert_array_equal(first.root_translation, second.root_translation)
    assert first.num_frames >= 3.0 * first.frame_rate
    assert not np.array_equal(first.local_rotations[0], other.local_rotations[0])


def test_listening_to_nobody(tmp_path: Path) -> None:
    out = tmp_path / "out"
    ran = run("sensor", "listen", "--seconds", 0.1, "--port", 0, "--json", "--out", out)
    assert ran.status == 0
    assert ran.json["kicks"] == []
    assert ran.json["received"]["datagrams"] == 0
    assert json.loads((out / "kicks.json").read_text()) == ran.json
    assert "no packet came on 127.0.0.1:" in ran.json["why_nothing"]


def test_why_nothing_is_heard_is_said(kick: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a few seconds, and at the end, in simulated time."""

    class Deaf(PlayedReceiver):
        def arrive(self) -> bool:
            if self._next is not None:
                self.put(b"noise")
                self._next = next(self._packets, None)
            return self._next is not None

    monkeypatch.setattr("mgjax.cli.sensor.SensorReceiver", Deaf.of(*load_motion(kick)))
    ran = run("sensor", "listen", "--seconds", 4)
    assert ran.status == 0
    first, second = re.findall(r"(?:after 3 s: )?\d+ packets came on [^\n]*", ran.err)
    assert first.startswith("after 3 s")
    assert "broken: expected OSC messages or bundles with /VMC/Ext/Bone/Pos" in second


def test_refused(kick: Path, tmp_path: Path) -> None:
    refused(run("sensor", "replay", tmp_path / "none.bvh"), "none.bvh")
    refused(run("sensor", "replay", kick, "--loss", 2), "loss = 2")
    refused(run("sensor", "replay", kick, "--port", -1), "port -1")
    refused(run("sensor", "replay", kick, "--host", "nowhere.invalid"), "nowhere.invalid")
    refused(run("sensor", "send"), "got neither of a file and --graph")
    refused(run("sensor", "send", kick, "--graph", tmp_path), "got both of a file and --graph")
    refused(run("sensor", "send", "--graph", tmp_path / "none"), "none")
    refused(run("sensor", "send", kick, "--seconds", -1), "--seconds -1, expected 0 … 3600")
    refused(run("sensor", "send", kick, "--fps", 0), "rate = 0")
    refused(run("sensor", "listen", "--seconds", 0), "--seconds 0")
    refused(run("sensor", "listen", "--seconds", 1, "--host", "192.0.2.1"), "192.0.2.1")
    for words in (("sensor",), ("sensor", "smell"), ("sensor", "listen")):
        assert run(*words).status == 2
