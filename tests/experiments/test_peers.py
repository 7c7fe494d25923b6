"""Peers and mgjax in turns: made-up peers in the present interpreter, and no network."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from experiments.benchmarks import peers
from experiments.benchmarks.beside import environments, turns
from experiments.benchmarks.beside.calls import Calls, turn, warmed
from experiments.benchmarks.beside.environments import one_line
from experiments.benchmarks.beside.ours import balls, bodies, chains, graphs
from experiments.benchmarks.beside.table import PEERS
from experiments.benchmarks.beside.theirs import pyfabrik_chain, scipy_components
from experiments.benchmarks.beside.types import Job, Peer, Work
from mgjax.core.errors import ConfigError
from mgjax.runs.experiment import execute

CONFIG = peers.Config(turns=3, items=2, least_s=0.0, limit_s=60.0)
WORK = Work(words="parts", make=partial(graphs.components, nodes=1000))
TOY = Peer(name="toy", present="scipy", theirs=scipy_components, works={"parts": WORK})


def call(words: list[str], stderr: str = "") -> subprocess.CompletedProcess[str]:
    """As if a command had been run: only pip fails."""
    failed = "pip" in words and bool(stderr)
    return subprocess.CompletedProcess(words, int(failed), "", stderr if failed else "")


def test_halves_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    order: list[str] = []
    asked = turns.Half.ask

    def ask(half: turns.Half, **what: object) -> dict:
        order.append("theirs " + "".join(what))
        return asked(half, **what)

    def here(calls: Calls, least_s: float) -> list[float]:
        order.append("ours")
        return turn(calls, least_s)

    monkeypatch.setattr(turns.Half, "ask", ask)
    monkeypatch.setattr(turns, "turn", here)
    found = peers.compared([TOY], CONFIG)
    assert order == ["theirs work", *["theirs least_s", "ours"] * 3]
    (row,), (timed,) = found.metrics["rows"], found.timings["rows"]
    assert (row["peer"], row["work"], row["words"]) == ("toy", "parts", "parts")
    assert row["theirs"]["met"] == row["ours"]["met"] == 1.0
    assert set(row["versions"]) == {"python", "scipy"}
    assert row["version"] == row["versions"]["scipy"]
    assert (found.metrics["works"], found.metrics["measured"]) == (1, 1)
    for side in ("theirs", "ours"):
        assert set(timed[side]) == {"median_s", "quartiles_s", "turns_s", "first_call_s"}
        assert len(timed[side]["turns_s"]) == 3
        low, high = timed[side]["quartiles_s"]
        assert 0 < low <= timed[side]["median_s"] <= high
    shares = np.divide(timed["theirs"]["turns_s"], timed["ours"]["turns_s"])
    assert timed["ratios"] == shares.tolist()
    assert timed["ratio"] == np.median(shares)
    assert len(found.lines) == 1
    assert found.lines[0].startswith("toy ")


def test_one_that_fails_is_listed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(environments.FOLDER, str(tmp_path))
    missing = "ERROR: Cannot install it\nERROR: more"
    monkeypatch.setattr(environments, "call", partial(call, stderr=missing))
    broken = Work(words="links", make=partial(chains.points, links=4))
    other = Work(words="parts", make=lambda seed, items: replace(WORK.make(seed, items), data={}))
    found = peers.compared(
        [
            Peer(
                name="unheard of", packages=("it==1",), theirs=pyfabrik_chain, works={"all": broken}
            ),
            replace(TOY, works={"parts": other}),
            replace(TOY, name="silent", theirs=pytest),
            Peer(name="not here", present="scipy", theirs=pyfabrik_chain, works={"links": broken}),
            TOY,
        ],
        CONFIG,
    )
    reasons = {row["peer"]: row["reason"] for row in found.metrics["failed"]}
    assert list(reasons) == ["unheard of", "toy", "silent", "not here"]
    assert reasons["unheard of"] == "Cannot install it"
    assert reasons["toy"].startswith("TypeError: set_up() missing 5")
    assert reasons["silent"].startswith("AttributeError: ")
    assert reasons["not here"] == "ModuleNotFoundError: No module named 'pyfabrik'"
    assert [row["peer"] for row in found.timings["rows"]] == ["toy"]
    assert "unheard of, all: not measured: Cannot install it" in found.lines


def test_one_that_ends_or_is_late() -> None:
    job = WORK.make(0, 1)
    with turns.half(TOY, Path(sys.executable), 60.0) as other:
        other.process.kill()
        other.process.wait()
        with pytest.raises(environments.Unavailable, match="exit status"):
            other.ask(work=job.data)
    with (
        turns.half(TOY, Path(sys.executable), 1e-3) as other,
        pytest.raises(environments.Unavailable, match=r"no answer within 0\.001 s"),
    ):
        other.ask(work=job.data)


def test_without_an_index(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(environments.FOLDER, str(tmp_path / "made"))
    nothing = "ERROR: Could not find a version that satisfies mink (from versions: none)"
    monkeypatch.setattr(environments, "call", partial(call, stderr=nothing))
    words = ["--set", "only=['mink']", "--out", str(tmp_path / "out")]
    assert execute(peers.run, peers.Config, words) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith("benchmarks/peers: got no package index that answers, expected one")
    assert not (tmp_path / "out").exists()


def test_an_environment_is_made_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    peer = Peer(
        name="a + b", packages=("a==1", "b<2"), alone=("c==3",), theirs=pyfabrik_chain, works={}
    )
    assert peer.distributions == ("c", "a", "b")
    done: list[list[str]] = []

    def called(words: list[str]) -> subprocess.CompletedProcess[str]:
        done.append(words)
        (tmp_path / "a-b").mkdir(exist_ok=True)
        return call(words)

    monkeypatch.setattr(environments, "call", called)
    python = environments.interpreter(peer, tmp_path)
    assert python.is_relative_to(tmp_path / "a-b")
    assert [words[-2:] for words in done[1:]] == [["a==1", "b<2"], ["--no-deps", "c==3"]]
    assert environments.interpreter(peer, tmp_path) == python
    assert len(done) == 3
    environments.interpreter(replace(peer, packages=("a==2",)), tmp_path)
    assert len(done) == 6
    assert environments.interpreter(TOY, tmp_path) == Path(sys.executable)


def test_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(environments.FOLDER, "before")
    words = ["--environments", "there", "--only", "mink", "mujoco + scipy", "--smoke"]
    assert peers.as_settings(words) == ["--set", "only=['mink', 'mujoco + scipy']", "--smoke"]
    assert environments.folder().name == "there"
    with pytest.raises(ConfigError, match="only = 'minx', expected of upc-pymotion, fairmotion"):
        peers.chosen(PEERS, ("minx",))
    assert [peer.name for peer in peers.chosen(PEERS, ("ikpy", "mink"))] == ["mink", "ikpy"]


def test_reasons_name_no_place() -> None:
    text = "cannot open '/home/me/x/y.txt',\n  nor /a/b; see https://c.d/e/f"
    assert one_line(text) == "cannot open '…/y.txt', nor …/b; see https://c.d/e/f"


@pytest.mark.parametrize(
    "make",
    [
        partial(bodies.kinematics, frames=8),
        partial(chains.points, links=4),
        partial(chains.angles, links=4),
        partial(chains.hand, bones=4),
        partial(chains.hand, bones=8, together=True),
        partial(balls.passes, bounces=1),
        WORK.make,
    ],
)
def test_what_mgjax_does_is_right(make: partial[Job]) -> None:
    job = make(0, 2)
    assert max(warmed(job.ours)["misses"]) <= job.tolerance
    json.dumps(job.data, allow_nan=False)


def test_every_peer_is_pinned() -> None:
    assert len({peer.name for peer in PEERS}) == len(PEERS)
    for peer in PEERS:
        assert peer.works
        assert peer.present or "==" in peer.installed[0]
