from __future__ import annotations

import importlib
import inspect
import json
import pkgutil
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import experiments
from mgjax.core.errors import OutputError
from mgjax.runs.experiment import Results, execute, perform
from mgjax.runs.points import Points
from mgjax.runs.settings import resolve
from tests.runs.toys import Config, Reading, names, simple, toy

ROOT = Path(__file__).resolve().parents[2]


def test_what_is_written(tmp_path, capsys):
    out, runs = tmp_path / "out" / "toy", tmp_path / "out" / "runs.jsonl"
    arguments = ["--set", "seed=3", "--out", str(out), "--runs", str(runs)]
    assert execute(toy, Config, arguments) == 0
    assert capsys.readouterr().out.startswith("a line\n")
    files = ["arrays.npz", "config.toml", "later.png", "metrics.json", "now.png", "points.jsonl"]
    assert names(out) == files
    record = json.loads((out / "metrics.json").read_text())
    assert record["files"] == files
    assert record["experiment"] == "runs/toys"
    assert (record["seed"], record["smoke"]) == (3, False)
    assert record["metrics"]["count"] == 4
    assert record["metrics"]["open"] is None
    assert record["timings"] == {"quick_s": 0.1}
    assert record["points"] == {"measured": 2, "resumed": 0}
    assert {"wall", "compile"} <= set(record["seconds"])
    assert re.fullmatch("[0-9a-f]{40}", record["git_revision"] or "0" * 40)
    assert {"versions", "machine", "git_dirty", "finished"} <= set(record)
    assert resolve(Config, out / "config.toml") == Config(seed=3)
    assert np.load(out / "arrays.npz")["speeds"].tolist() == [1.0, 2.0]
    assert (out / "now.png").read_bytes().startswith(b"\x89PNG")
    assert execute(toy, Config, [*arguments, "--smoke", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["smoke"]
    rows = [json.loads(line) for line in runs.read_text().splitlines()]
    assert [row["config.balls"] for row in rows] == [4, 1]
    assert rows[1]["config.inner.width"] == 0.5
    assert rows[1]["metrics.means.1.mean"] == printed["metrics"]["means"]["1"]["mean"]
    assert not any(isinstance(value, list | dict) for row in rows for value in row.values())


def test_a_run_of_one_argument(tmp_path):
    record, _ = perform(simple, Config(), tmp_path / "out")
    assert names(tmp_path / "out") == ["config.toml", "metrics.json"]
    assert record["metrics"] == {"balls": 4}
    with pytest.raises(TypeError, match="returned dict, expected Results"):
        perform(lambda config: {}, Config(), tmp_path / "other")  # pyright: ignore
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_interrupted_sweeps_go_on(tmp_path, error, capsys):
    out, calls = tmp_path / "out", []

    def run(config: Config, points: Points) -> Results:
        def work(speed: float) -> dict:
            calls.append(speed)
            if calls == [1.0, 2.0]:
                raise error
            return {"mean": speed / 3}

        rows = [points.measure(f"{s}", lambda s=s: work(s)) for s in config.speeds]
        return Results(metrics={"rows": rows})

    arguments = ["--out", str(out)]
    if error is KeyboardInterrupt:
        assert execute(run, Config, arguments) == 130
        assert capsys.readouterr().err.count("\n") == 1
    else:
        with pytest.raises(RuntimeError):
            execute(run, Config, arguments)
    assert names(out) == ["partial.jsonl"]
    assert execute(run, Config, arguments) == 0
    assert calls == [1.0, 2.0, 2.0]
    assert names(out) == ["config.toml", "metrics.json", "points.jsonl"]
    record = json.loads((out / "metrics.json").read_text())
    assert record["points"] == {"measured": 1, "resumed": 1}
    assert record["metrics"]["rows"] == [{"mean": 1 / 3}, {"mean": 2 / 3}]
    assert execute(run, Config, arguments) == 0  # a finished run is measured again
    assert calls == [1.0, 2.0, 2.0, 1.0, 2.0]


def test_other_settings_begin_anew(tmp_path):
    out, calls = tmp_path / "out", []

    def run(config: Config, points: Points) -> Results:
        points.measure("a", lambda: calls.append(config.seed) or {"x": 1})
        if len(calls) == 1:
            raise KeyboardInterrupt
        return Results(metrics={})

    assert execute(run, Config, ["--out", str(out)]) == 130
    assert execute(run, Config, ["--out", str(out), "--set", "seed=1"]) == 0
    assert calls == [0, 1]


def test_what_a_run_depends_on(tmp_path, capsys):
    """A changed file behind the same path, or another program, is another run."""
    folder, out, record = tmp_path / "clips", tmp_path / "out", tmp_path / "kept" / "a.json"
    folder.mkdir()
    (folder / "a.bvh").write_text("one")
    calls = []

    def run(config: Reading, points: Points) -> Results:
        points.measure("a", lambda: calls.append(len(calls)) or {"x": len(calls)})
        if len(calls) == 1:
            raise KeyboardInterrupt
        return Results(metrics={"calls": len(calls)})

    arguments = ["--out", str(out), "--record", str(record), "--set", f"clips={folder}"]
    assert execute(run, Reading, arguments) == 130
    (folder / "a.bvh").write_text("two")
    assert execute(run, Reading, arguments) == 0
    assert calls == [0, 1]  # the point of the other files was not taken over
    assert "partial.jsonl is of another run (inputs differ): begun anew" in capsys.readouterr().err
    kept = json.loads(record.read_text())
    assert kept["config"] == {"clips": "clips", "seed": 0}
    assert set(kept["inputs"]) == {"clips"}
    assert str(tmp_path) not in record.read_text()
    assert execute(run, Reading, arguments) == 0
    assert calls == [0, 1]  # its record is there
    assert "not run again" in capsys.readouterr().out
    assert execute(run, Reading, [*arguments, "--set", "seed=1"]) == 0
    (folder / "b.bvh").write_text("three")
    assert execute(run, Reading, [*arguments, "--set", "seed=1"]) == 0
    assert calls == [0, 1, 2, 3]


def test_results_that_cannot_be_written(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "metrics.json").write_text("old")

    def run(config: Config) -> Results:
        def fail() -> Figure:
            raise ZeroDivisionError

        return Results(metrics={}, arrays={"a": np.ones(2)}, figures={"bad": fail})

    with pytest.raises(ZeroDivisionError):
        perform(run, Config(), out)
    assert names(out) == ["metrics.json"]
    assert (out / "metrics.json").read_text() == "old"
    (tmp_path / "file").write_text("x")
    for bad in ({"out": tmp_path / "file"}, {"out": out, "runs": tmp_path}):
        with pytest.raises(OutputError, match="cannot be written"):
            perform(simple, Config(), **bad)


def test_no_trace_of_the_machine(tmp_path):
    perform(toy, Config(), tmp_path / "out", runs=tmp_path / "runs.jsonl")
    for file in ("out/metrics.json", "out/config.toml", "out/points.jsonl", "runs.jsonl"):
        text = (tmp_path / file).read_text()
        assert str(tmp_path) not in text
        assert str(ROOT) not in text


def test_as_a_script(tmp_path):
    folder = tmp_path / "experiments" / "room"
    folder.mkdir(parents=True)
    for place in (folder, folder.parent):
        (place / "__init__.py").write_text("")
    (folder / "tiny.py").write_text(
        "from dataclasses import dataclass\n"
        "from mgjax.runs.experiment import Results, experiment\n"
        "@dataclass(frozen=True, kw_only=True)\n"
        "class Config:\n    seed: int = 0\n"
        "def run(config):\n    return Results(metrics={'seed': config.seed})\n"
        "if __name__ == '__main__':\n    experiment(run, Config)\n"
    )
    command = [sys.executable, "-m", "experiments.room.tiny"]

    def call(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*command, *words], cwd=tmp_path, capture_output=True, text=True)

    done = call("--set", "seed=5", "--json")
    assert done.returncode == 0
    record = json.loads(done.stdout)
    assert record["experiment"] == "room/tiny"
    assert (record["git_revision"], record["git_dirty"]) == (None, None)
    saved = (tmp_path / "out" / "room" / "tiny" / "metrics.json").read_text()
    assert json.loads(saved) == record
    assert tomllib.loads((tmp_path / "out" / "room" / "tiny" / "config.toml").read_text()) == {
        "seed": 5
    }
    done = call("--set", "sed=5")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)


def discovered() -> list[str]:
    """All modules below ``experiments`` that are experiments in this form."""
    found = [
        item.name
        for item in pkgutil.walk_packages(experiments.__path__, "experiments.")
        if not item.ispkg
    ]
    modules = {name: importlib.import_module(name) for name in found}
    return [name for name, m in modules.items() if hasattr(m, "Config") and hasattr(m, "run")]


@lru_cache
def smoke_run(name: str, folder: Path) -> dict[str, Any]:
    module = importlib.import_module(name)
    assert execute(module.run, module.Config, ["--smoke", "--out", str(folder)]) == 0
    return json.loads((folder / "metrics.json").read_text())


@pytest.fixture(scope="session")
def run_at_smoke_size(tmp_path_factory) -> Callable[[str], dict[str, Any]]:
    """The record of an experiment, run once in a session."""
    base = tmp_path_factory.mktemp("smoke")
    return lambda name: smoke_run(name, base / name)


SLOW = (
    "experiments.avoidance.calibrate",
    "experiments.avoidance.connectivity",
    "experiments.avoidance.culling",
    "experiments.avoidance.minimal_movement",
    "experiments.avoidance.parry",
    "experiments.avoidance.reaction_time",
    "experiments.avoidance.refining",
    "experiments.avoidance.success",
    "experiments.avoidance.sweep",
    "experiments.avoidance.table1",
    "experiments.ballsport.aim",
    "experiments.ballsport.scene",
    "experiments.benchmarks.distances",
    "experiments.benchmarks.energy",
    "experiments.benchmarks.fabrik",
    "experiments.benchmarks.grid_index",
    "experiments.benchmarks.planner",
    "experiments.benchmarks.random_attacks",
    "experiments.hybrid.build",
    "experiments.hybrid.reach",
    "experiments.quality.blends",
    "experiments.quality.seams",
)
"""Each takes a quarter of a minute and more, mostly for programs that no test shares; what they
call is tested."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.long if n in SLOW else ()) for n in discovered()],
)
def test_every_experiment(name, run_at_smoke_size):
    module = importlib.import_module(name)
    assert module.Config.__dataclass_params__.frozen
    text = inspect.getsource(module)
    assert text.rstrip().endswith("    experiment(run, Config)")
    assert 'if __name__ == "__main__":\n' in text
    record = run_at_smoke_size(name)
    _, room, script = name.split(".")
    assert record["experiment"] == f"{room}/{script}"
    assert record["smoke"]
    assert record["metrics"]


@pytest.mark.parametrize(
    "file",
    [
        file
        for name in discovered()
        if (
            file := ROOT / "configs" / (name.split(".", 1)[1].replace(".", "/") + ".toml")
        ).is_file()
    ],
    ids=lambda file: file.stem,
)
def test_their_configs(file):
    module = importlib.import_module(f"experiments.{file.parent.name}.{file.stem}")
    resolve(module.Config, file)
    resolve(module.Config, file, smoke=True)


def test_same_config_same_metrics(run_at_smoke_size, tmp_path):
    from experiments.avoidance.warp import Config, run

    first = run_at_smoke_size("experiments.avoidance.warp")
    second, _ = perform(run, resolve(Config, smoke=True), tmp_path)
    assert second["metrics"] == first["metrics"]
    assert second["points"]["resumed"] == 0
