from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mgjax.avoidance.index import graph_folder
from mgjax.graph.files import load_graph
from mgjax.io.load import load_motion
from tests.cli.conftest import Ran, run
from tests.reference import avoidance as reference

BUILD_KEYS = {
    *("frames", "clips", "transitions", "nodes", "edges", "threshold_m", "labels_total"),
    *("labels_kept", "labels_enterable", "genuine_kept", "genuine_enterable", "seconds"),
    *("foot_slide_before", "foot_slide_after"),
}
AVOID_KEYS = {
    *("status", "candidates", "dropped", "walk", "seams", "time_scale", "energy", "clearance_m"),
}
COMMANDS = [
    "info",
    "convert",
    "fetch",
    "quality",
    "build",
    "avoid",
    "coverage",
    "walk",
    "scene",
    "sensor",
    "demo",
    "bench",
    "runs",
]
DROPPED = {"culled", "not_adjustable", "time_scale", "hit", "overflow"}
AVOID_FILES = {"motion.bvh", "result.json", "scene.png", "volumes.npz"}
PNG = b"\x89PNG\r\n\x1a\n"
THROW = ("--from", 0.5, 1.4, 5, "--at", 0, 1.4, 0, "--speed", 10, "--arrives", 1.2)


def files(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_help_needs_no_jax() -> None:
    script = (
        "import sys\n"
        "from mgjax.cli import main\n"
        f"NAMES = {COMMANDS}\n"
        "for words in ([], *([name] for name in NAMES)):\n"
        "    try:\n        main([*words, '--help'])\n"
        "    except SystemExit as stop:\n        assert not stop.code, words\n"
        "    else:\n        raise AssertionError(words)\n"
        "heavy = {'jax', 'numpy', 'scipy', 'matplotlib', 'safetensors'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for word in ("build", "avoid", "--arrives", "--exclude", "--mirror", "--gravity"):
        assert word in done.stdout


def test_as_a_process(built: tuple[Path, Ran], tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-m", "mgjax", "avoid", "--graph", built[0], *THROW, "--node", 0]
    done = subprocess.run(
        [str(word) for word in [*command, "--out", out, "--json"]],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert set(json.loads(done.stdout)) >= AVOID_KEYS
    assert files(out) == AVOID_FILES
    bad = subprocess.run(
        [str(word) for word in [*command, "--node", "x", "--out", out]],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert bad.returncode == 2
    assert "Traceback" not in bad.stderr


def test_info(clips_folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    paths = [clips_folder / "duck.bvh", clips_folder / "steps.bvh"]
    ran = run("info", *paths, "--json", "--out", out)
    assert (ran.status, ran.err) == (0, "")
    rows = ran.json["files"]
    assert json.loads((out / "info.json").read_text()) == ran.json
    assert [row["file"] for row in rows] == [str(path) for path in paths]
    for row, path in zip(rows, paths, strict=True):
        skeleton, motion = load_motion(path)
        assert (row["frames"], row["fps"]) == (motion.num_frames, motion.frame_rate)
        assert (row["joints"], tuple(row["names"])) == (skeleton.num_joints, skeleton.names)
        assert row["seconds"] == pytest.approx(motion.num_frames / motion.frame_rate, abs=1e-3)
        assert {"unit", "metres_per_unit", "oddities"} <= set(row)
    text = run("info", *paths)
    assert text.status == 0
    assert text.out.count("duck.bvh") == 1
    assert "fps" in text.out


def test_build(built: tuple[Path, Ran], clips_folder: Path) -> None:
    folder, ran = built
    assert ran.err == ""
    result = ran.json
    assert set(result) >= BUILD_KEYS
    assert files(folder) == {"graph.safetensors", "grid_index.safetensors", "build.json"}
    assert json.loads((folder / "build.json").read_text()) == result
    graph = load_graph(folder)
    assert (result["nodes"], result["edges"]) == (graph.num_nodes, graph.num_edges)
    assert result["clips"] == 4
    labels = json.loads((clips_folder / "labels.json").read_text())["clips"]
    assert result["labels_total"] == sum(len(items) for items in labels.values())
    assert result["labels_kept"] == len(graph.label_edge) > 0
    assert result["labels_enterable"] <= result["labels_kept"]
    assert result["threshold_m"] == 0.05
    assert all(seconds >= 0 for seconds in result["seconds"].values())


def test_build_in_words_with_mirror_and_exclude(clips_folder: Path, tmp_path: Path) -> None:
    ran = run(
        *("build", "--clips", clips_folder, "--exclude", "sway*", "--exclude", "crouch*"),
        *("--config", clips_folder / "graph.toml", "--mirror", "--out", tmp_path / "out"),
    )
    assert ran.status == 0, ran.err
    assert "4 clips" in ran.out
    names = load_graph(tmp_path / "out").clip_names
    assert set(names) == {"duck.bvh", "steps.bvh", "duck.bvh~mirrored", "steps.bvh~mirrored"}


def check_files(out: Path, result: dict, radius: float) -> None:
    """The four files of a throw fit one another."""
    assert files(out) == AVOID_FILES
    assert json.loads((out / "result.json").read_text()) == result
    assert (out / "scene.png").read_bytes()[:8] == PNG
    volumes = np.load(out / "volumes.npz")
    assert set(volumes) == {
        *("times", "attack_centres", "attack_radii", "body_centres", "body_radii"),
    }
    times = volumes["times"]
    np.testing.assert_allclose(times, np.arange(len(times)) / 240, atol=1e-9)
    assert volumes["attack_centres"].shape == (len(times), 1, 3)
    np.testing.assert_allclose(volumes["attack_radii"], [radius])
    assert volumes["body_centres"].shape == (len(times), len(volumes["body_radii"]), 3)
    assert all(np.isfinite(volumes[name]).all() for name in volumes)
    # Half a second in the air; before that the ball waits far behind the place it comes from.
    ball = volumes["attack_centres"][:, 0]
    assert (ball[times < 0.6, 2] > 900).all()
    assert (np.linalg.norm(ball[(times > 0.75) & (times < 1.4)], axis=1) < 6).all()
    _, motion = load_motion(out / "motion.bvh")
    assert motion.num_frames == (len(times) + 1) // 2
    least = reference.quick_clearance(
        volumes["attack_centres"],
        volumes["attack_radii"],
        volumes["body_centres"],
        volumes["body_radii"],
    )
    if result["clearance_m"] is not None:
        # Where the ball meets the body's surroundings only; else its ends count a little more.
        assert abs(least - result["clearance_m"]) < 0.03
        assert (result["status"] == "avoided") == (result["clearance_m"] >= 0.001)
        assert result["status"] != "avoided" or least > 0


def test_avoid_the_attack_of_a_file(built: tuple[Path, Ran], tmp_path: Path) -> None:
    first = {"from": [0.5, 1.4, 5], "at": [0, 1.4, 0], "speed": 10, "arrives": 1.2}
    second = {"from": [4, 1.0, 0], "at": [0, 1.0, 0.3], "speed": 10, "arrives": 1.6}
    file, out = tmp_path / "balls.json", tmp_path / "out"
    file.write_text(json.dumps({"balls": [first, second]}))
    ran = run("avoid", "--graph", built[0], "--attack", file, "--out", out, "--json")
    assert (ran.status, ran.err) == (0, "")
    assert files(out) == AVOID_FILES
    volumes = np.load(out / "volumes.npz")
    np.testing.assert_allclose(volumes["attack_radii"], [0.12, 0.12])
    times, balls = volumes["times"], volumes["attack_centres"]
    for ball, (start, stop) in enumerate(((0.7, 1.5), (1.2, 1.9))):
        near = np.linalg.norm(balls[:, ball], axis=1) < 8
        inside, outside = (times > start) & (times < stop), (times < start - 0.01)
        assert near[inside].all()
        assert not near[outside].any()
        assert (np.linalg.norm(balls[outside, ball], axis=1) > 900).all()
    # The same ball from a file and from arguments.
    file.write_text(json.dumps({"balls": [first]}))
    one = run("avoid", "--graph", built[0], "--attack", file, "--out", out, "--json").json
    assert one == run("avoid", "--graph", built[0], *THROW, "--out", out, "--json").json


@pytest.mark.parametrize("more", [(), ("--gravity", "--radius", 0.2)])
def test_avoid(built: tuple[Path, Ran], tmp_path: Path, more: tuple) -> None:
    graph = load_graph(built[0])
    seen = set()
    for seed in range(5):
        out = tmp_path / f"out{seed}"
        ran = run(
            "avoid", "--graph", built[0], *THROW, *more, "--seed", seed, "--out", out, "--json"
        )
        assert (ran.status, ran.err) == (0, "")
        result = ran.json
        assert set(result) >= AVOID_KEYS
        assert set(result["dropped"]) == DROPPED
        seen.add(result["status"])
        check_files(out, result, 0.2 if more else 0.12)
        end = 0.0
        for row in result["walk"]:
            assert {"edge", "clip", "start_s", "end_s"} <= set(row)
            assert row["start_s"] == pytest.approx(end)
            frames = graph.edge_frames[row["edge"]]
            assert row["end_s"] - end == pytest.approx(frames / 30 * row["scale"], rel=1e-5)
            end = row["end_s"]
        if result["status"] == "no_candidate":
            assert result["clearance_m"] is result["energy"] is result["time_scale"] is None
        else:
            energy = {"total", "avoidance", "body", "movement", "timescale"}
            energy |= {"penetration", "d", "d0", "displacement"}
            assert set(result["energy"]) == energy
            assert isinstance(result["time_scale"], float)
    assert seen - {"no_candidate"}


def test_avoid_is_repeatable_and_draws_by_the_seed(built: tuple[Path, Ran], tmp_path: Path) -> None:
    command = ("avoid", "--graph", built[0], *THROW, "--json", "--out")
    a = run(*command, tmp_path / "a", "--seed", 3).json
    b = run(*command, tmp_path / "b", "--seed", 3).json
    c = run(*command, tmp_path / "c", "--seed", 4).json
    named = run(*command, tmp_path / "d", "--seed", 3, "--node", a["node"]).json
    assert a == b == named
    assert a["node"] != c["node"]
    for name in ("motion.bvh", "result.json"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_avoid_in_words_over_an_older_result(built: tuple[Path, Ran], tmp_path: Path) -> None:
    (tmp_path / "motion.bvh").write_text("old")
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "speed.toml").write_text("checks = 3\n[speed]\nV_fast = 0.1\n")
    ran = run(
        *("avoid", "--graph", built[0], *THROW, "--config", tmp_path / "speed.toml"),
        *("--out", tmp_path),
    )
    assert ran.status == 0, ran.err
    assert str(tmp_path) in ran.out
    assert files(tmp_path) == AVOID_FILES | {"mine.txt", "speed.toml"}
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert (tmp_path / "motion.bvh").read_text() != "old"


def test_demo(tmp_path: Path) -> None:
    out = tmp_path / "out"
    ran = run("demo", "--out", out, "--balls", 5, "--json")
    assert (ran.status, ran.err) == (0, "")
    assert files(out) == {"index.html", "motion.bvh", "result.json", "scene.png"}
    assert (out / "scene.png").read_bytes()[:8] == PNG
    result = ran.json
    assert json.loads((out / "result.json").read_text()) == result
    assert len(result["balls"]) == 5
    assert result["avoided"] == 5
    # One motion: each ball is known when the walk before it is over.
    now = 0.0
    for ball in result["balls"]:
        assert set(ball) >= AVOID_KEYS
        assert ball["now_s"] == pytest.approx(now)
        now += ball["walk"][-1]["end_s"]
    _, motion = load_motion(out / "motion.bvh")
    assert (motion.num_frames - 1) / motion.frame_rate == pytest.approx(now, abs=0.01)


def test_real_capture(capture: Path, tmp_path: Path) -> None:
    folder = capture / "avoidance"
    out = tmp_path / "graph"
    ran = run(
        *("build", "--clips", folder, "--exclude", "bvh_converted/*"),
        *("--labels", folder / "labels.json", "--out", out, "--json"),
    )
    assert (ran.status, ran.err) == (0, "")
    result = ran.json
    assert (result["clips"], result["labels_total"], result["genuine_total"]) == (29, 88, 18)
    assert result["labels_kept"] >= 80
    assert result["threshold_m"] <= 0.16
    assert result["foot_slide_after"] < result["foot_slide_before"]
    statuses = set()
    for node in (126, 929, 1480, 2313):
        ran = run(
            *("avoid", "--graph", out, *THROW, "--node", node, "--json"),
            *("--out", tmp_path / f"throw{node}"),
        )
        assert (ran.status, ran.err) == (0, "")
        check_files(tmp_path / f"throw{node}", ran.json, 0.12)
        statuses.add(ran.json["status"])
    assert "avoided" in statuses


@pytest.mark.parametrize("existed", [False, True])
def test_interrupted_build_leaves_nothing(
    one_clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, existed: bool
) -> None:
    out = tmp_path / "deep" / "out"
    if existed:
        out.mkdir(parents=True)
        (out / "mine.txt").write_text("mine")
    real = graph_folder.save_graph

    def interrupted(folder: Path, graph: object) -> None:
        real(folder, graph)  # type: ignore[arg-type]
        raise KeyboardInterrupt

    monkeypatch.setattr(graph_folder, "save_graph", interrupted)
    (one_clip / "graph.toml").write_text("threshold_m = 0.1\n")
    ran = run("build", "--clips", one_clip, "--config", one_clip / "graph.toml", "--out", out)
    assert ran.status == 130
    assert (ran.out, ran.err.count("\n")) == ("", 1)
    if existed:
        assert files(out) == {"mine.txt"}
    else:
        assert not (tmp_path / "deep").exists()
