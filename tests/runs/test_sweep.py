"""Sweeps over settings: combinations, one line a run, going on after a kill."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from mgjax.cli.main import main
from mgjax.core.errors import ConfigError, FileFormatError
from mgjax.core.parallel.executors import SerialExecutor
from mgjax.runs.sweep import LOT, combinations, known_lines, read_setting, sweep
from tests.runs import swept, swept_together

NAME = "tests.runs.swept"
ROOT = Path(__file__).resolve().parents[2]


def rows(file: Path) -> list[dict]:
    return [json.loads(line) for line in file.read_text().splitlines()]


def test_combinations() -> None:
    grid = [read_setting("a=[1, 2]", "--grid"), read_setting('b = ["x", "y"]', "--grid")]
    assert combinations(grid) == [
        {"a": 1, "b": "x"}, {"a": 1, "b": "y"}, {"a": 2, "b": "x"}, {"a": 2, "b": "y"},
    ]  # fmt: skip
    draws = [read_setting("c=[0.5, 1]", "--draw", ends=True), ("d", (1, 3))]
    found = combinations([], draws, samples=20, seed=4)
    assert all(0.5 <= row["c"] <= 1 and row["d"] in (1, 2, 3) for row in found)
    assert {row["d"] for row in found} == {1, 2, 3}
    assert found[:5] == combinations([], draws, samples=5, seed=4)
    assert len(combinations(grid, draws, samples=3)) == 12
    for text in ("a", "a=1", "a=[]", "=[1]", "a=[1"):
        with pytest.raises(ConfigError, match="--grid"):
            read_setting(text, "--grid")
    for text in ("a=[1]", "a=[2, 1]", 'a=["x", "y"]', "a=[true, false]"):
        with pytest.raises(ConfigError, match="low, high"):
            read_setting(text, "--draw", ends=True)


def test_one_line_a_run(tmp_path: Path) -> None:
    file, base = tmp_path / "out" / "a.jsonl", swept.Config()
    settings = combinations([("inner.width", (1, 2.5)), ("balls", (3, 4))])
    for made in (SerialExecutor(), ThreadPoolExecutor(2)):
        with made:
            assert sweep(NAME, base, settings[:2], file, executor=made) in ((2, 0), (0, 2))
    assert sweep(NAME, base, [*settings, *settings], file, executor=SerialExecutor()) == (2, 2)
    found = rows(file)
    assert [(r["config.inner.width"], r["config.balls"]) for r in found] == [
        (1.0, 3), (1.0, 4), (2.5, 3), (2.5, 4),
    ]  # fmt: skip
    assert [row["metrics.area"] for row in found] == [3.0, 4.0, 7.5, 10.0]
    assert len({row["fingerprint"] for row in found}) == 4
    assert {row["experiment"] for row in found} == {"runs/swept"}
    assert not any(isinstance(value, dict | list) for row in found for value in row.values())
    with pytest.raises(ConfigError, match=r"unknown key 'inner\.with', expected .*inner\.width"):
        sweep(NAME, base, [{"inner.with": 1}], file, executor=SerialExecutor())
    (tmp_path / "b").write_text("[1]\n")
    with pytest.raises(FileFormatError, match="got other lines"):
        known_lines(tmp_path / "b")


def test_a_killed_sweep_goes_on(tmp_path: Path) -> None:
    """The process is killed in its third run, and a line is half written."""
    file, mark = tmp_path / "a.jsonl", tmp_path / "killed"
    words = [sys.executable, "-m", "mgjax", "runs", "sweep", NAME, "--out", str(file)]
    words += ["--grid", "balls=[1, 2, 3, 4]", "--set", f"kills={mark}"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert [row["config.balls"] for row in rows(file)] == [1, 2]
    with file.open("ab") as opened:
        opened.write(b'{"fingerprint": "abc')
    assert main(words[3:]) == 0
    assert [row["config.balls"] for row in rows(file)] == [1, 2, 3, 4]
    assert mark.read_text().splitlines() == ["1", "2", "3", "3", "4"]  # the first two once


def test_runs_are_made_together(tmp_path: Path) -> None:
    """Runs that differ in traced settings alone share a call; each is a line, and goes on alone."""
    name, base, file = "tests.runs.swept_together", swept_together.Config(), tmp_path / "a.jsonl"
    few = combinations([("inner.width", (1.5, 2.5)), ("balls", (1, 2)), ("names", (["a"], ["b"]))])
    swept_together.CALLS.clear()
    assert sweep(name, base, few, file, executor=SerialExecutor()) == (8, 0)
    assert sorted(swept_together.CALLS) == [2, 2, 2, 2]
    found = rows(file)
    assert all(r["metrics.area"] == r["config.balls"] * r["config.inner.width"] for r in found)
    assert {row["together"] for row in found} == {2}
    assert len({row["fingerprint"] for row in found}) == 8
    more = combinations([("inner.width", tuple(float(x) for x in range(LOT + 3)))])
    swept_together.CALLS.clear()
    assert sweep(name, base, [*few, *more], file, executor=SerialExecutor()) == (LOT + 3, 8)
    assert swept_together.CALLS == [LOT, 3]
    with ThreadPoolExecutor(2) as made:
        assert sweep(name, base, [*few, *more], tmp_path / "b", executor=made) == (LOT + 11, 0)
    strip = ("seconds", "together")
    both = [
        [{k: v for k, v in r.items() if k not in strip} for r in rows(f)]
        for f in (file, tmp_path / "b")
    ]
    assert sorted(both[0], key=str) == sorted(both[1], key=str)


def test_wrong_calls(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ["--out", str(tmp_path / "a")]
    for words in (
        ["no.such.module"], ["mgjax.core.errors"], [NAME, "--grid", "balls=3"],
        [NAME, "--grid", "bals=[3]"], [NAME, "--draw", "balls=[3]"], [NAME, "--samples", "0"],
    ):  # fmt: skip
        assert main(["runs", "sweep", *words, *out]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert not os.path.exists(tmp_path / "a")
