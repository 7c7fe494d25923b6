"""``mgjax sensor``: a clip sent as a sensor sends it, and kicks heard."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.io.bvh_write import save_bvh
from tests.cli.conftest import refused, run


@pytest.fixture(scope="module")
def kick(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made attack of the right foot as a BVH file."""
    path = tmp_path_factory.mktemp("kick") / "kick.bvh"
    clips, _ = synthetic_kicks(seed=2, frame_rate=60.0, takes=1)
    clip = next(clip for clip in clips if clip.name == "kick_attack_right")
    save_bvh(path, clip.skeleton, clip.motion)
    return path


def test_replay_is_heard(kick: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mgjax", "sensor", "listen", "--port", "0"]
    listener = subprocess.Popen(
        [*command, "--seconds", "5"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert listener.stderr is not None
    line = listener.stderr.readline()
    found = re.search(r"listening on 127\.0\.0\.1:(\d+)", line)
    assert found, line
    out = tmp_path / "out"
    ran = run(
        *("sensor", "replay", kick, "--port", found[1], "--speed", 2, "--loss", 0.02),
        *("--json", "--out", out),
    )
    assert (ran.status, ran.err) == (0, "")
    assert json.loads((out / "replay.json").read_text()) == ran.json
    assert ran.json["packets"] + ran.json["lost"] == 2 * ran.json["frames"]
    printed, errors = listener.communicate(timeout=60)
    assert listener.returncode == 0, errors
    (event,) = [json.loads(text) for text in printed.splitlines()]
    assert (event["bone"], event["kind"]) == ("right_foot", "attack")
    assert 0 < event["latency_s"] < event["latency_from_fastest_s"]
    assert "1 kicks" in errors


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
    refused(run("sensor", "replay", kick, "--loss", 2), "loss 2")
    refused(run("sensor", "replay", kick, "--port", -1), "port -1")
    refused(run("sensor", "replay", kick, "--host", "nowhere.invalid"), "nowhere.invalid")
    refused(run("sensor", "listen", "--seconds", 0), "--seconds 0")
    refused(run("sensor", "listen", "--seconds", 1, "--host", "192.0.2.1"), "192.0.2.1")
    for words in (("sensor",), ("sensor", "smell"), ("sensor", "listen")):
        assert run(*words).status == 2
