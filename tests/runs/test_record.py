from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core.errors import OutputError
from mgjax.runs.points import Points
from mgjax.runs.record import (
    CompileTimes,
    append_line,
    check_appendable,
    compile_times,
    flat,
    machine,
    plain,
    revision,
    versions,
)


def git(folder: Path, *words: str) -> str:
    names = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
    command = ["git", "-C", str(folder), *names, *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


@pytest.mark.skipif(shutil.which("git") is None, reason="no git")
def test_revision(tmp_path):
    assert revision(tmp_path) == (None, None)
    git(tmp_path, "init")
    assert revision(tmp_path) == (None, None)  # before the first commit
    (tmp_path / "a").write_text("1")
    (tmp_path / ".gitignore").write_text("out/\n")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-m", "one")
    head = git(tmp_path, "rev-parse", "HEAD")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "result").write_text("x")
    assert revision(tmp_path) == (head, False)  # ignored files do not count
    (tmp_path / "new").write_text("2")
    assert revision(tmp_path) == (head, True)
    (tmp_path / "new").unlink()
    (tmp_path / "a").write_text("3")
    assert revision(tmp_path / "out") == (head, True)


def test_revision_without_git(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert revision(Path(__file__).parent) == (None, None)


def test_versions_and_machine():
    found = versions()
    assert found["jax"] == jax.__version__
    assert found["numpy"] == np.__version__
    assert set(found) == {"python", "jax", "jaxlib", "numpy", "scipy", "mgjax"}
    here = machine()
    assert here["cores"] == os.cpu_count()
    assert here["memory_gb"] is None or here["memory_gb"] > 0.1
    text = json.dumps(here)
    assert len(platform.node()) < 3 or platform.node() not in text
    assert str(Path.home()) not in text
    assert os.sep + "proc" not in text


def test_compile_time_is_told_apart():
    @jax.jit
    def inner(x):
        return jnp.sin(x) * 2

    def fresh(x):
        return inner(x) + inner(2 * x)

    work = jax.jit(fresh)
    start = time.perf_counter()
    with compile_times() as first:
        work(np.ones(3, np.float32)).block_until_ready()
    wall = time.perf_counter() - start
    assert first.programs >= 1
    assert first.loaded <= first.programs
    assert 0 < first.seconds <= wall + 0.05  # nested spans are not added up
    assert first.load_s <= first.seconds
    with compile_times() as second:
        work(np.ones(3, np.float32)).block_until_ready()
    assert second == CompileTimes()
    before = first.programs
    jax.jit(lambda x: x + 3)(np.ones(3, np.float32))
    assert first.programs == before  # it stopped listening


def test_spans_are_united():
    times = CompileTimes(spans=[(5.0, 6.0), (0.0, 2.0), (1.0, 1.5), (1.5, 3.0), (5.5, 5.6)])
    assert times.seconds == pytest.approx(4.0)
    assert CompileTimes().seconds == 0


def test_plain():
    given = {"a": np.float32(0.5), "b": (1, np.int64(2)), "c": {"d": np.array([1.0, np.nan])}}
    assert plain(given) == {"a": 0.5, "b": [1, 2], "c": {"d": [1.0, None]}}
    assert plain([float("inf"), True, None, "x"]) == [None, True, None, "x"]
    assert type(plain(np.bool_(True))) is bool
    with pytest.raises(TypeError, match=r"metrics\.a\[1\]: got \w*Path"):
        plain({"a": [1, Path("x")]})
    with pytest.raises(TypeError, match=r"metrics\.a: got key 1"):
        plain({"a": {1: 2}})


def test_flat():
    assert flat({"a": {"b": 1, "c": {"d": "x"}}, "e": [1], "f": None}) == {
        "a.b": 1,
        "a.c.d": "x",
        "f": None,
    }


def test_append_line(tmp_path):
    path = tmp_path / "deep" / "runs.jsonl"
    check_appendable(path)
    for i in range(3):
        append_line(path, {"i": np.int64(i)})
    assert [json.loads(line) for line in path.read_text().splitlines()] == [
        {"i": 0},
        {"i": 1},
        {"i": 2},
    ]
    for bad in (tmp_path, path / "below", "nul\0byte"):
        with pytest.raises(OutputError, match="cannot be written"):
            check_appendable(bad)


def counted(points: Points, key: str, calls: list[str], value: float = 0.1) -> dict:
    def work() -> dict:
        calls.append(key)
        return {"x": value, "list": (1, 2)}

    return points.measure(key, work)


def test_points_go_on(tmp_path):
    path, calls = tmp_path / "partial.jsonl", []
    first = Points(path, {"config": "a = 1"})
    assert not path.exists()  # nothing is finished yet
    one = counted(first, "one", calls, 1 / 3)
    counted(first, "two", calls)
    assert one == {"x": 1 / 3, "list": [1, 2]}
    assert counted(first, "one", calls) == one  # the same key once
    again = Points(path, {"config": "a = 1"})
    assert counted(again, "one", calls, 7.0) == one
    counted(again, "three", calls)
    assert calls == ["one", "two", "three"]
    assert (again.measured, again.resumed) == (1, 1)
    assert [json.loads(line)["key"] for line in again.lines().splitlines()] == [
        "one",
        "two",
        "three",
    ]
    again.discard()
    assert not path.exists()
    again.discard()


@pytest.mark.parametrize("cut", [1, 5, 20])
def test_a_torn_line_is_cut_off(tmp_path, cut):
    path, calls = tmp_path / "partial.jsonl", []
    first = Points(path, 1)
    counted(first, "one", calls)
    counted(first, "two", calls)
    whole = path.read_bytes()
    path.write_bytes(whole[:-cut])
    again = Points(path, 1)
    counted(again, "one", calls)
    counted(again, "two", calls)
    assert calls == ["one", "two", "two"]
    keys = [json.loads(line).get("key") for line in path.read_text().splitlines()]
    assert keys == [None, "one", "two"]


@pytest.mark.parametrize(
    "text", ["", "\n", "no json\n", '{"run": 2}\n', "[]\n", '{"run": 1}\n[1]\n', '{"run": 1}\n{}\n']
)
def test_other_files_are_begun_anew(tmp_path, text):
    path, calls = tmp_path / "partial.jsonl", []
    path.write_text(text)
    points = Points(path, 1)
    counted(points, "one", calls)
    assert calls == ["one"]
    assert len(path.read_text().splitlines()) == 2
    assert json.loads(path.read_text().splitlines()[0]) == {"run": 1}


def test_binary_file_is_begun_anew(tmp_path):
    path, calls = tmp_path / "partial.jsonl", []
    path.write_bytes(b"\xff\xfe\x00\n\x80\n")
    counted(Points(path, 1), "one", calls)
    assert calls == ["one"]


def test_points_without_file():
    points, calls = Points(), []
    counted(points, "one", calls)
    counted(points, "one", calls)
    assert calls == ["one"]


def test_a_point_that_fails_is_not_kept(tmp_path):
    path, calls = tmp_path / "partial.jsonl", []
    points = Points(path, 1)
    counted(points, "one", calls)
    with pytest.raises(ZeroDivisionError):
        points.measure("two", lambda: {"x": 1 / 0})
    with pytest.raises(TypeError, match=r"two\.x: got object"):
        points.measure("two", lambda: {"x": object()})
    assert len(path.read_text().splitlines()) == 2


def squared(x: int) -> dict[str, int]:
    if x == 4:
        raise KeyboardInterrupt
    return {"value": x * x}


def test_points_of_an_executor_are_kept_and_come_in_their_order(tmp_path):
    path = tmp_path / "partial.jsonl"
    with ThreadPoolExecutor(2) as pool:
        first = Points(path, 1, pool)
        assert first.measure_all({"b": 3, "a": 1}, squared) == {
            "b": {"value": 9},
            "a": {"value": 1},
        }
    again = Points(path, 1)
    assert again.measure("a", dict) == {"value": 1}
    with pytest.raises(KeyboardInterrupt):
        again.measure_all({"b": 3, "c": 2, "d": 4}, squared)
    last = Points(path, 1)
    found = last.measure_all({"c": 2, "b": 3, "e": 5}, squared)
    assert list(found.items()) == [("c", {"value": 4}), ("b", {"value": 9}), ("e", {"value": 25})]
    assert (last.measured, last.resumed) == (1, 2)
