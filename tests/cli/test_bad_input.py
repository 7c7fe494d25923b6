from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mgjax.cli import demo as demo_command
from mgjax.io.store import load_arrays, save_arrays
from tests.cli.conftest import Ran, refused, run

THROW = ("--from", 0.5, 1.4, 5, "--at", 0, 1.4, 0, "--speed", 10, "--arrives", 1.2)


def build(folder: Path, *more: object, labels: bool = False) -> Ran:
    extra = ("--labels", folder / "labels.json") if labels else ()
    return run("build", "--clips", folder, *extra, *more, "--out", folder.parent / "out" / "deep")


def spoil(path: Path, change: Callable[[list[str]], list[str]]) -> None:
    path.write_text("\n".join(change(path.read_text().split("\n"))))


def row_changed(token: str) -> Callable[[list[str]], list[str]]:
    """Puts a token into the third row of numbers."""

    def change(lines: list[str]) -> list[str]:
        row = lines.index("MOTION") + 5
        lines[row] = " ".join([token, *lines[row].split()[1:]])
        return lines

    return change


def stated(count: int) -> Callable[[list[str]], list[str]]:
    return lambda lines: [f"Frames: {count}" if "Frames:" in x else x for x in lines]


CLIPS: dict[str, tuple[Callable[[list[str]], list[str]], tuple[str, ...]]] = {
    "cut within a row": (lambda lines: [*lines[:-3], lines[-3][:50]], ("duck.bvh:",)),
    "empty": (lambda lines: [], ("duck.bvh", "empty")),
    "words": (lambda lines: ["what is this"], ("duck.bvh:1", "what")),
    "word in a row": (row_changed("abc"), ("duck.bvh:", "'abc'")),
    "nan": (row_changed("nan"), ("duck.bvh:", "'nan'", "finite")),
    "infinity": (row_changed("-inf"), ("duck.bvh:", "'-inf'")),
    "no frames": (stated(0), ("duck.bvh:", "'0'")),
    "same joint twice": (
        lambda lines: [x.replace("JOINT rtibia", "JOINT ltibia") for x in lines],
        ("duck.bvh:", "ltibia"),
    ),
    "offset": (
        lambda lines: [re.sub(r"OFFSET .*", "OFFSET 9e9 0 0", x) for x in lines],
        ("duck.bvh",),
    ),
}


@pytest.mark.parametrize("kind", CLIPS)
def test_spoiled_clips(one_clip: Path, kind: str) -> None:
    change, words = CLIPS[kind]
    spoil(one_clip / "duck.bvh", change)
    line = refused(build(one_clip), *words, out=one_clip.parent / "out")
    assert refused(run("info", one_clip / "duck.bvh"), *words) == line
    if kind not in ("empty", "offset"):
        assert re.search(r"duck\.bvh:\d+: got ", line)


@pytest.mark.parametrize("frames", [7, 100_000])
def test_rows_count_and_not_the_stated_frames(one_clip: Path, frames: int) -> None:
    motion = (one_clip / "duck.bvh").read_text().partition("MOTION")[2]
    rows = len(motion.strip().splitlines()) - 2  # without "Frames:" and "Frame Time:"
    spoil(one_clip / "duck.bvh", stated(frames))
    done = build(one_clip)
    assert done.status == 0
    assert f"{rows} rows where {frames} frames are stated; all rows were taken" in done.out
    assert f"{frames} frames are stated" in run("info", one_clip / "duck.bvh").out


def test_binary_clip(one_clip: Path) -> None:
    data = np.random.default_rng(0).integers(0, 256, 5000).astype(np.uint8).tobytes()
    (one_clip / "duck.bvh").write_bytes(data)
    refused(build(one_clip), "duck.bvh", out=one_clip.parent / "out")
    refused(run("info", one_clip / "duck.bvh", "--out", one_clip / "info"), out=one_clip / "info")


def test_clips_that_are_not_there(tmp_path: Path) -> None:
    refused(run("build", "--clips", tmp_path / "none", "--out", tmp_path / "out"), "none")
    (tmp_path / "bare").mkdir()
    refused(build(tmp_path / "bare"), ".bvh", out=tmp_path / "out")
    refused(run("info", tmp_path / "none.bvh"), "none.bvh")
    refused(run("info", tmp_path / "bare"), "bare")
    (tmp_path / "clip.txt").write_text("text")
    refused(run("info", tmp_path / "clip.txt"), "clip.txt", ".bvh")
    (tmp_path / "alone.amc").write_text(":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n")
    refused(run("info", tmp_path / "alone.amc"), "asf")


def test_different_hierarchies(one_clip: Path) -> None:
    text = (one_clip / "duck.bvh").read_text()
    (one_clip / "other.bvh").write_text(text.replace("JOINT rtibia", "JOINT rshin"))
    spoil(one_clip / "other.bvh", row_changed("1.25"))
    refused(build(one_clip), "other.bvh", "rshin", "rtibia", out=one_clip.parent / "out")


LABELS: dict[str, tuple[list | dict, tuple[str, ...]]] = {
    "outside": ([{"start_s": 1.0, "end_s": 99.0, "kind": "duck"}], ("99 s", "outside")),
    "before": ([{"start_s": -1.0, "end_s": 1.0, "kind": "duck"}], ("-1", "outside")),
    "empty": ([{"start_s": 1.0, "end_s": 1.0, "kind": "duck"}], ("no frame",)),
    "overlapping": (
        [
            {"start_s": 1.0, "end_s": 2.0, "kind": "duck"},
            {"start_s": 1.5, "end_s": 2.5, "kind": "duck"},
        ],
        ("overlapping", "1.5"),
    ),
    "no start": ([{"end_s": 2.0, "kind": "duck"}], ("start_s",)),
    "word": ([{"start_s": "a", "end_s": 2.0, "kind": "duck"}], ("start_s", "'a'")),
    "no kind": ([{"start_s": 1.0, "end_s": 2.0}], ("kind",)),
    "no list": ({"start_s": 1.0}, ("list",)),
}


@pytest.mark.parametrize("kind", LABELS)
def test_bad_labels(one_clip: Path, kind: str) -> None:
    intervals, words = LABELS[kind]
    text = json.dumps({"clips": {"duck.bvh": intervals}}, indent=1)
    (one_clip / "labels.json").write_text(text)
    line = refused(build(one_clip, labels=True), *words, out=one_clip.parent / "out")
    assert re.search(r"labels\.json:\d+: got ", line)


def test_labels_that_cannot_be_read(one_clip: Path) -> None:
    out = one_clip.parent / "out"
    labels = one_clip / "labels.json"
    labels.write_text('{"clips": {\n"none.bvh": []}}')
    refused(build(one_clip, labels=True), "labels.json:2", "none.bvh", out=out)
    labels.write_text('{"clips": {\n"duck.bvh": [}')
    refused(build(one_clip, labels=True), "labels.json:2", "JSON", out=out)
    labels.write_text("[]")
    refused(build(one_clip, labels=True), "labels.json", "clips", out=out)
    labels.unlink()
    refused(build(one_clip, labels=True), "labels.json", out=out)


CONFIGS = {
    "neighborhood = 2": ("config.toml:1", "'neighborhood'", "'neighbourhood'"),
    "frame_rate = 30.0\nkeep = 'most'": ("config.toml:2", "keep", "number"),
    "window_s = true": ("config.toml:1", "window_s", "number"),
    "neighbourhood = 1.5": ("config.toml:1", "neighbourhood", "whole number"),
    "mirror = 1": ("config.toml:1", "mirror", "true or false"),
    "weights = ['root']": ("config.toml:1", "weights"),
    "[weights]\nroot = 'x'": ("config.toml", "weights"),
    "keep = = 1": ("config.toml:1", "TOML"),
    "keep = 1\nkeep = 2": ("config.toml", "TOML"),
    "frame_rate = nan": ("frame_rate",),
    "window_s = -1.0": ("window_s", "-1.0"),
    "keep = 2.0": ("keep", "2.0"),
    "threshold_m = 0": ("threshold_m", "0"),
}


@pytest.mark.parametrize("text", CONFIGS)
def test_bad_settings_of_a_graph(one_clip: Path, text: str) -> None:
    (one_clip / "config.toml").write_text(text)
    ran = build(one_clip, "--config", one_clip / "config.toml")
    assert (ran.status, ran.err.count("\n")) == (2, 1), ran.err
    for word in CONFIGS[text]:
        assert word in ran.err
    assert not (one_clip.parent / "out").exists()


def test_threshold_that_leaves_nothing(one_clip: Path) -> None:
    out = one_clip.parent / "out"
    config = one_clip / "config.toml"
    config.write_text("threshold_m = 1e-6\n")
    line = refused(build(one_clip, "--config", config), "threshold", out=out)
    enough = float(re.search(r"at least ([0-9.]+) m", line)[1])  # type: ignore[index]
    config.write_text(f"threshold_m = {enough}\n")
    assert build(one_clip, "--config", config).status == 0
    config.write_text("max_threshold_m = 1e-6\n")
    refused(build(one_clip, "--config", config, labels=True))


def test_unwritable_folders(built: tuple[Path, Ran], one_clip: Path, tmp_path: Path) -> None:
    # Permissions do not bind everybody; nobody can write below a file.
    (tmp_path / "file").write_text("mine")
    for out in (tmp_path / "file", tmp_path / "file" / "deep" / "out", Path("/dev/null/x")):
        for ran in (
            run("build", "--clips", one_clip, "--out", out),
            run("avoid", "--graph", built[0], *THROW, "--out", out),
            run("info", one_clip / "duck.bvh", "--out", out),
            run("demo", "--out", out),
        ):
            refused(ran, str(out), "cannot be written")
    assert (tmp_path / "file").read_text() == "mine"
    # A folder in the place of a file: nothing else is put there either.
    taken = tmp_path / "taken"
    (taken / "scene.png").mkdir(parents=True)
    ran = run("avoid", "--graph", built[0], *THROW, "--out", taken)
    refused(ran, "scene.png", "cannot be written")
    assert [path.name for path in taken.iterdir()] == ["scene.png"]


def test_avoid_refuses_an_index_that_it_cannot_use(built: tuple[Path, Ran], tmp_path: Path) -> None:
    out, graph = tmp_path / "out", tmp_path / "graph"
    shutil.copytree(built[0], graph)
    avoid = ("avoid", "--graph", graph, *THROW, "--out", out)
    file = graph / "grid_index.safetensors"
    arrays, metadata = load_arrays(file, "grid index")
    save_arrays(file, arrays, metadata | {"format_version": 2})
    refused(run(*avoid), file.name, "format 2", "format 3; build anew", out=out)
    file.write_bytes(file.read_bytes()[:-9])
    refused(run(*avoid), file.name, "damaged", out=out)


def test_missing_and_damaged_graphs(built: tuple[Path, Ran], tmp_path: Path) -> None:
    out, graph = tmp_path / "out", tmp_path / "graph"
    avoid = ("avoid", "--graph", graph, *THROW, "--out", out)
    refused(run(*avoid), "graph.safetensors", "no such file", out=out)
    graph.mkdir()
    refused(run(*avoid), "graph.safetensors", "no such file", out=out)
    file = graph / "graph.safetensors"
    data = (built[0] / "graph.safetensors").read_bytes()
    for spoiled in (
        b"",
        b"no graph",
        data[: len(data) // 2],
        data[:-1],
        b"\xff" * 8 + data[8:],
        data.replace(b'"format_version":"1"', b'"format_version":"9"'),
        data.replace(b'"edge_clip"', b'"edge_clap"'),
        data.replace(b'"window"', b'"wandow"'),
        data.replace(b'"I64"', b'"X64"'),
        np.random.default_rng(0).integers(0, 256, 4000).astype(np.uint8).tobytes(),
    ):
        assert spoiled != data
        file.write_bytes(spoiled)
        refused(run(*avoid), "graph.safetensors", out=out)


HEAD = ("--at", 0, 1.2, 0, "--speed", 10)
THROWS: dict[str, tuple[tuple, tuple[str, ...]]] = {
    "nan": (("--from", "nan", 1, 5, *HEAD, "--arrives", 1.2), ("start", "nan")),
    "inf": (("--from", 0, "inf", 5, *HEAD, "--arrives", 1.2), ("start", "inf")),
    "minus inf": (("--from", 0, "-inf", 5, *HEAD, "--arrives", 1.2), ("start", "-inf")),
    "nan target": (("--from", 0, 1, 5, *HEAD[:2], "nan", *HEAD[3:], "--arrives", 1.2), ("target",)),
    "far": (("--from", 0, 1, 5e9, *HEAD, "--arrives", 1.2), ("start",)),
    "negative speed": (
        ("--from", 0, 1, 5, "--at", 0, 1, 0, "--speed", -3, "--arrives", 1.2),
        ("speed -3",),
    ),
    "no speed": (
        ("--from", 0, 1, 5, "--at", 0, 1, 0, "--speed", 0, "--arrives", 1.2),
        ("speed 0",),
    ),
    "nan speed": (
        ("--from", 0, 1, 5, "--at", 0, 1, 0, "--speed", "nan", "--arrives", 1.2),
        ("speed nan",),
    ),
    "too slow": (
        ("--from", 0, 1, 9, "--at", 0, 1, 0, "--speed", 2, "--arrives", 3, "--gravity"),
        ("cannot reach", "at least"),
    ),
    "in the past": (("--from", 0, 1, 5, *HEAD, "--arrives", -1), ("arrival -1",)),
    "now": (("--from", 0, 1, 5, *HEAD, "--arrives", 0), ("arrival 0",)),
    "too late": (("--from", 0, 1, 5, *HEAD, "--arrives", 900), ("900", "60 s")),
    "radius": (("--from", 0, 1, 5, *HEAD, "--arrives", 1.2, "--radius", 0), ("radius 0",)),
    "floor": (("--from", 0, -1, 5, *HEAD, "--arrives", 1.2), ("floor",)),
    "nowhere": (("--from", 0, 1.2, 0, *HEAD, "--arrives", 1.2), ("place it starts from",)),
    "inside": (("--from", 0, 1.0, 0, *HEAD, "--arrives", 1.2), ("inside the body",)),
    "node": (("--from", 0, 1, 5, *HEAD, "--arrives", 1.2, "--node", 10**6), ("1000000",)),
    "negative node": (("--from", 0, 1, 5, *HEAD, "--arrives", 1.2, "--node", -1), ("node -1",)),
    "seed": (("--from", 0, 1, 5, *HEAD, "--arrives", 1.2, "--seed", -1), ("seed -1",)),
}


@pytest.mark.parametrize("kind", THROWS)
def test_bad_throws(built: tuple[Path, Ran], tmp_path: Path, kind: str) -> None:
    words, parts = THROWS[kind]
    ran = run("avoid", "--graph", built[0], *words, "--out", tmp_path / "out", "--json")
    refused(ran, *parts, out=tmp_path / "out")


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("checkz = 1", ("config.toml:1", "'checkz'", "'checks'")),
        ("[energy]\nD_bodie = 1.0", ("config.toml:2", "'energy.D_bodie'", "'D_body'")),
        ("[energy]\nform = 'both'", ("config.toml:2", "form", "'overlap'")),
        ("[energy]\nD_body = 0.0", ("energy.D_body", "0.0")),
        ("[energy]\nD_body = 'x'", ("config.toml:2", "energy.D_body", "a number")),
        ("energy = 3", ("config.toml:1", "energy", "a table")),
        ("[speed]\nV_slow = -1.0", ("speed.V_slow", "-1.0")),
        ("capacity = 0", ("capacity", "0")),
        ("checks = -3", ("checks", "-3")),
        ("T_window = inf", ("T_window", "inf")),
        ("settle_s = nan", ("settle_s", "nan")),
    ],
)
def test_bad_settings_of_a_throw(
    built: tuple[Path, Ran], tmp_path: Path, text: str, parts: tuple[str, ...]
) -> None:
    (tmp_path / "config.toml").write_text(text)
    ran = run(
        *("avoid", "--graph", built[0], *THROW, "--config", tmp_path / "config.toml"),
        *("--out", tmp_path / "out"),
    )
    refused(ran, *parts, out=tmp_path / "out")


def test_bad_attack_files(built: tuple[Path, Ran], tmp_path: Path) -> None:
    out, file = tmp_path / "out", tmp_path / "attack.json"
    avoid = ("avoid", "--graph", built[0], "--out", out)
    file.write_text('{"radii": [0.1], "times": [0, 1], "centres": [[[0, 1, 4]], [[0, 1, 0]]]}')
    for more, parts in (
        (THROW, ("--attack beside --from, --at, --speed, --arrives",)),
        (("--gravity",), ("--attack beside --gravity",)),
        (("--radius", 0.2), ("--attack beside --radius",)),
    ):
        refused(run(*avoid, "--attack", file, *more), *parts, out=out)
    refused(run(*avoid, *THROW[:8]), "no --speed, --arrives", "or --attack", out=out)
    refused(run(*avoid, "--attack", tmp_path / "none.json"), "none.json", "attack file", out=out)
    file.write_text('{"balls": [\n{"from": [0, 1, 5]}]}')
    refused(run(*avoid, "--attack", file), "attack.json:2", "no 'at'", out=out)


def test_words_the_parser_refuses(built: tuple[Path, Ran], tmp_path: Path) -> None:
    out = tmp_path / "out"
    for words in (
        ("fly",),
        (),
        ("avoid", "--graph", built[0], "--out", out),
        ("avoid", "--graph", built[0], *THROW, "--spin", 3, "--out", out),
        ("avoid", "--graph", built[0], "--from", 0, 1, *THROW[4:], "--out", out),
        ("build", "--out", out),
        ("bench", "everything"),
    ):
        ran = run(*words)
        assert ran.status == 2
        assert "Traceback" not in ran.err
    assert not out.exists()


def test_demo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out"
    refused(run("demo", "--balls", 0, "--out", out), "0 balls", out=out)
    refused(run("demo", "--balls", 1000, "--out", out), "1000 balls", out=out)
    refused(run("demo", "--seed", -2, "--out", out), "seed -2", out=out)

    def interrupted(**_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(demo_command, "synthetic_clips", interrupted)
    assert run("demo", "--out", out).status == 130
    assert not out.exists()
