from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mgjax.graph.files import save_graph
from mgjax.io.load import load_motion
from tests.cli.conftest import refused, run
from tests.hybrid.paths.made import walking

KEYS = {
    *("status", "error_m2", "mean_distance_m", "largest_distance_m", "seconds", "search_s"),
    *(
        "nodes_expanded",
        "nodes_pruned",
        "foot_slide_m_per_frame",
        "failed_at",
        "interrupted",
        "walk",
    ),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("graph")
    save_graph(out, walking())
    return out


def test_walk(folder: Path, tmp_path: Path) -> None:
    path, out = tmp_path / "path.csv", tmp_path / "out"
    path.write_text("x,z\n0,0\n0,2\n0.5,3\n")
    ran = run("walk", "--graph", folder, "--path", path, "--out", out, "--json", "--spline")
    assert (ran.status, ran.err) == (0, "")
    assert set(ran.json) >= KEYS
    assert ran.json["status"] == "followed"
    assert ran.json["mean_distance_m"] < 0.15
    assert {f.name for f in out.iterdir()} == {"motion.bvh", "result.json", "walk.png"}
    assert json.loads((out / "result.json").read_text()) == ran.json
    _, motion = load_motion(out / "motion.bvh")
    seconds = (motion.num_frames - 1) / motion.frame_rate
    assert seconds == pytest.approx(ran.json["seconds"], abs=1e-3)
    root = np.asarray(motion.root_translation)
    assert np.linalg.norm(root[-1, ::2] - [0.5, 3]) < 0.4
    assert ran.json["walk"][-1]["end_s"] == ran.json["seconds"]
    blended = [row for row in ran.json["walk"] if " > " in row["clip"]]
    keys = ("start_s", "end_s")
    assert ran.json["seams"] == [{key: row[key] for key in keys} for row in blended]


def test_lost(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "path.json"
    path.write_text(json.dumps({"points": [[0, 0], [0, 3]], "obstacles": [[0, 2.4, 1.2]]}))
    words = ("--graph", folder, "--path", path, "--method", "beam", "--out", tmp_path / "out")
    ran = run("walk", *words, "--json")
    assert ran.status == 0
    assert ran.json["status"] == "lost"
    assert len(ran.json["failed_at"]) == 2
    assert "it leads to (0.00" in run("walk", *words).out


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("0,0\n", "1 point"),
        ("0,0\n0,0\n", "1 point"),
        ("0,0\n0,nan\n", "nan"),
        ("0,0\n0,1\n0,90\n0,91\n", "jump"),
    ],
)
def test_bad_paths(folder: Path, tmp_path: Path, text: str, word: str) -> None:
    path, out = tmp_path / "path.csv", tmp_path / "out"
    path.write_text(text)
    ran = run("walk", "--graph", folder, "--path", path, "--out", out)
    refused(ran, word, "path.csv", out=out)


def test_bad_arguments(folder: Path, tmp_path: Path) -> None:
    path, out = tmp_path / "path.csv", tmp_path / "out"
    refused(run("walk", "--graph", folder, "--path", path, "--out", out), "path.csv", out=out)
    path.write_text("0,0\n0,2\n")
    words = ("walk", "--graph", folder, "--path", path, "--out", out)
    refused(run(*words, "--seconds", 0), "--seconds", out=out)


def test_config_files(folder: Path, tmp_path: Path) -> None:
    path, file, out = tmp_path / "path.csv", tmp_path / "walk.toml", tmp_path / "out"
    path.write_text("0,0\n0,2\n")
    words = ("walk", "--graph", folder, "--path", path, "--config", file, "--out", out, "--json")
    results = []
    for text in ('method = "beam"\n', '[path]\nmethod = "beam"\n\n[reach]\nblend_s = 0.4\n'):
        file.write_text(text)
        ran = run(*words)
        assert (ran.status, ran.json["horizons"]) == (0, 0)
        results.append(ran.json["walk"])
    assert results[0] == results[1]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("horizon_s = 0.1\n", "horizon_s"),
        ("[path]\nkeep_s = 9.0\n", "keep_s"),
        ("[path]\nfaster = 1\n", "faster"),
        ("[reach]\nblend = 1\n", "blend_s"),
        ("near_m = 1.0\n[reach]\nblend_s = 1.0\n", "near_m"),
    ],
)
def test_bad_config_files(folder: Path, tmp_path: Path, text: str, word: str) -> None:
    path, file, out = tmp_path / "path.csv", tmp_path / "walk.toml", tmp_path / "out"
    path.write_text("0,0\n0,2\n")
    file.write_text(text)
    words = ("walk", "--graph", folder, "--path", path, "--config", file, "--out", out)
    refused(run(*words), word, out=out)
