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

import pytest

from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion
from mgjax.sensor.frames import SensorFrame
from mgjax.sensor.receiver import SensorReceiver
from tests.cli.conftest import refused, run
from tests.sensor.transport import SAFETY_S, PlayedReceiver, wait_until


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
            assert seconds == 5.0
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


def test_listening_to_nobody(tmp_path: Path) -> None:
    out = tmp_path / "out"
    ran = run("sensor", "listen", "--seconds", 0.1, "--port", 0, "--json", "--out", out)
    assert ran.status == 0
    assert ran.json["kicks"] == []
    assert ran.json["received"]["datagrams"] == 0
    assert json.loads((out / "kicks.json").read_text()) == ran.json


def test_refused(kick: Path, tmp_path: Path) -> None:
    refused(run("sensor", "replay", tmp_path / "none.bvh"), "none.bvh")
    refused(run("sensor", "replay", kick, "--loss", 2), "loss = 2")
    refused(run("sensor", "replay", kick, "--port", -1), "port -1")
    refused(run("sensor", "replay", kick, "--host", "nowhere.invalid"), "nowhere.invalid")
    refused(run("sensor", "listen", "--seconds", 0), "--seconds 0")
    refused(run("sensor", "listen", "--seconds", 1, "--host", "192.0.2.1"), "192.0.2.1")
    for words in (("sensor",), ("sensor", "smell"), ("sensor", "listen")):
        assert run(*words).status == 2
