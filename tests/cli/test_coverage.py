from __future__ import annotations

import inspect
import json
from pathlib import Path

import numpy as np
import pytest

from mgjax.avoidance.coverage import throws as room
from mgjax.cli.arguments import Coverage
from tests.cli.conftest import Ran, refused, run

SMALL = ("--directions", 4, "--nodes", 6, "--heights", 0.4, 1.4, "--arrivals", 1.2)


def test_coverage(built: tuple[Path, Ran], tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    ran = run("coverage", "--graph", built[0], *SMALL, "--out", out, "--json")
    assert (ran.status, ran.err) == (0, "")
    found = ran.json
    assert json.loads((out / "coverage.json").read_text()) == found
    assert {path.name for path in out.iterdir()} == {
        *("coverage.json", "coverage.npz", "coverage.png")
    }
    assert (out / "coverage.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    assert found["attacks"] == 24
    assert set(found["all"]) >= {"avoided", "hit", "no_candidate", "kinds", "avoided_interval"}
    assert np.shape(found["cells"]["avoided"]) == (4, 2)
    with np.load(out / "coverage.npz") as arrays:
        assert np.isclose((arrays["status"] == 0).mean(), found["all"]["avoided"], atol=1e-4)
        late = arrays["nearest_part"] >= 2.2  # half of T_wide after 1.2 s
        assert late.sum() == found["out_of_reach"][0]["nodes"]
        assert arrays["node_clip_frame"].min() >= 0
        assert len(arrays["node"]) == 24


def test_text(built: tuple[Path, Ran], tmp_path: Path) -> None:
    ran = run("coverage", "--graph", built[0], *SMALL, "--out", tmp_path)
    assert (ran.status, ran.err) == (0, "")
    for word in ("24 balls at 6 nodes", "avoided by kind", "worst served", "to improve the graph"):
        assert word in ran.out
    assert len(ran.out.splitlines()) < 20


def test_defaults_are_those_of_the_function() -> None:
    defaults = inspect.signature(room.measure_coverage).parameters
    for name in ("directions", "heights", "arrivals", "nodes", "seed", "speed"):
        assert getattr(Coverage, name) == defaults[name].default


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--directions", 0), ("got 0 directions", "at least 1")),
        (("--nodes", 0), ("got 0 nodes", "at least 1")),
        (("--heights", 0.5, -1), ("got height -1",)),
        (("--arrivals", "nan"), ("got arrival nan",)),
        (("--speed", 0), ("got speed 0",)),
        (("--seed", -1), ("got seed -1",)),
    ],
)
def test_bad_numbers(
    built: tuple[Path, Ran], tmp_path: Path, arguments: tuple, words: tuple[str, ...]
) -> None:
    out = tmp_path / "deep" / "out"
    refused(run("coverage", "--graph", built[0], *arguments, "--out", out), *words, out=out.parent)


def test_bad_graphs(clips_folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    refused(run("coverage", "--graph", tmp_path / "none", "--out", out), "none", out=out)
    plain = tmp_path / "plain"
    config = clips_folder / "graph.toml"
    assert run("build", "--clips", clips_folder, "--config", config, "--out", plain).status == 0
    refused(run("coverage", "--graph", plain, "--out", out), "without avoidance parts", out=out)


def test_interrupted(
    built: tuple[Path, Ran], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(room, "select_batch", interrupt)
    out = tmp_path / "deep" / "out"
    ran = run("coverage", "--graph", built[0], *SMALL, "--out", out)
    assert (ran.status, ran.out) == (130, "")
    assert "interrupted" in ran.err
    assert not out.parent.exists()
