"""Records as files: found, named, compared."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mgjax.cli.main import main
from mgjax.core.errors import FileFormatError
from mgjax.runs.experiment import execute, identity_of
from mgjax.runs.identity import inputs_of, settings_of, sources_of
from mgjax.runs.kept import (
    differences,
    find_records,
    keep_record,
    load_record,
    named,
    ratio,
)
from tests.runs import swept
from tests.runs.toys import Config, Reading, simple, toy


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two runs: a folder of results, and a record on its own; and other JSON."""
    assert execute(toy, Config, ["--out", str(tmp_path / "one")]) == 0
    words = ["--set", "seed=1", "--out", str(tmp_path / "two"), "--record"]
    assert execute(toy, Config, [*words, str(tmp_path / "kept" / "two.json")]) == 0
    (tmp_path / "kept" / "other.json").write_text('{"experiment": "none"}')
    return tmp_path


def test_found_and_named(folder: Path) -> None:
    found = dict(find_records([folder]))
    assert sorted(found) == [folder / "kept" / "two.json", folder / "one", folder / "two"]
    assert load_record(folder / "one") == named(str(folder / "one"), [])
    assert named("two", [folder / "kept"])["seed"] == 1
    assert named("toys", [folder / "kept"])["seed"] == 1
    assert "files" not in named("two", [folder / "kept"])
    with pytest.raises(FileFormatError, match="toys: got 3 records"):
        named("toys", [folder])
    with pytest.raises(FileFormatError, match=r"other\.json: got other JSON, expected the record"):
        load_record(folder / "kept" / "other.json")


def test_what_is_kept_is_short(folder: Path, tmp_path: Path) -> None:
    """Plain lists on a line, nine digits, no long lists; the rest is as it was."""
    record = load_record(folder / "one")
    metrics = {
        "rows": [
            {"p5_p50": [1 / 3, -2e-7 / 3], "name": "a,\n b [c]"},
            {"none": [], "some": [None]},
        ],
        "long": list(range(41)),
        "count": 1234567890123,
    }
    keep_record(tmp_path / "short.json", record | {"metrics": metrics, "timings": {}})
    text = (tmp_path / "short.json").read_text()
    assert '   "p5_p50": [0.333333333, -6.66666667e-08],\n' in text
    expected = {
        "rows": [
            {"p5_p50": [0.333333333, -6.66666667e-08], "name": "a,\n b [c]"},
            {"none": [], "some": [None]},
        ],
        "count": 1234567890123,
    }
    assert load_record(tmp_path / "short.json")["metrics"] == expected


def test_differences(folder: Path) -> None:
    one, two = load_record(folder / "one"), load_record(folder / "two")
    found = differences(one, two)
    assert set(found) == {"config", "metrics"}
    assert found["config"] == {"config.seed": (0, 1)}
    assert set(found["metrics"]) == {"metrics.means.1.mean", "metrics.means.2.mean"}
    assert differences(one, one) == {}
    longer = one | {"config": one["config"] | {"speeds": [1.0, 2.0, 3.0]}}
    assert differences(one, longer) == {"config": {"config.speeds.2": (None, 3.0)}}
    assert ratio((2, 3.0)) == 1.5
    assert [ratio(pair) for pair in ((0, 1), ("a", 1), (None, 1), (True, 1), (1, -1))] == [None] * 5


def test_what_is_hashed(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("1")
    config = Reading(clips=str(tmp_path))
    assert settings_of(config) == {"clips": tmp_path.name, "seed": 0}
    first = inputs_of(config)
    (tmp_path / "build.json").write_text("a report with times")
    assert inputs_of(config) == first
    (tmp_path / "b").write_text("")
    assert inputs_of(config) != first
    assert inputs_of(Reading()) == {}
    assert sources_of(simple) == sources_of(toy)
    assert sources_of(simple) != sources_of(swept.run)
    assert len({identity_of(simple, Config(seed=s))["fingerprint"] for s in (0, 1, 1)}) == 2


def test_commands(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    below = ["--below", str(folder)]
    assert main(["runs", "list", *below]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 3
    assert all(line.startswith("runs/toys ") for line in lines)
    assert main(["runs", "show", str(folder / "one")]) == 0
    assert "config.inner.width = 1.5" in capsys.readouterr().out.splitlines()
    assert main(["runs", "compare", str(folder / "one"), str(folder / "two")]) == 0
    text = capsys.readouterr().out
    assert "config: 1 differ\n  seed: 0 | 1\nmetrics: 2 differ\n" in text
    assert main(["runs", "compare", str(folder / "one"), str(folder / "one")]) == 0
    assert capsys.readouterr().out == "no difference\n"
    assert main(["runs", "list", *below, "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["runs"]) == 3
    for words in (["show", "toy"], ["list", "--below", str(folder / "none")]):
        assert main(["runs", *words]) == 2
        assert capsys.readouterr().err.count("\n") == 1
