from __future__ import annotations

import json
from pathlib import Path

import pytest

from mgjax.graph.files import save_graph
from mgjax.io.load import load_motion
from tests.cli.conftest import refused, run
from tests.hybrid.reaching.test_walk import walking

REACHED = {"limb", "status", "error_m", "hold_error_m", "from_s", "to_s", "extended_m"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("graph")
    save_graph(out, walking())
    return out


def words(folder: Path, tmp_path: Path, text: str) -> tuple:
    path, file = tmp_path / "path.csv", tmp_path / "reach.json"
    path.write_text("x,z\n0,0\n0,4\n")
    file.write_text(text)
    out = tmp_path / "out"
    return ("walk", "--graph", folder, "--path", path, "--reach", file, "--method", "beam",
            "--out", out)  # fmt: skip


def test_walk_with_reaches(folder: Path, tmp_path: Path) -> None:
    rows = [
        {"limb": "right_hand", "place": [-0.35, 1.2, 2.2], "when": "passing", "hold_s": 0.2},
        {"limb": "head", "bar": {"from": [-1, 3, 3], "to": [1, 3, 3]}},
        {"limb": "left_hand", "place": [0, 4, 3], "when": "end"},
    ]
    ran = run(*words(folder, tmp_path, json.dumps(rows)), "--json")
    assert (ran.status, ran.err) == (0, "")
    hand, bar, high = ran.json["targets"]
    assert set(hand) >= REACHED
    assert (hand["status"], bar["status"], high["status"]) == ("reached", "cleared", "too_high")
    assert hand["error_m"] <= hand["hold_error_m"] < 0.005
    assert high["from_s"] is None
    assert ran.json["fastest_turn_deg_s"] <= 720
    _, motion = load_motion(tmp_path / "out" / "motion.bvh")
    seconds = (motion.num_frames - 1) / motion.frame_rate
    assert seconds == pytest.approx(ran.json["motion_s"], abs=1e-3)
    # Without a stop the motion shows the walk's seams at the walk's own times.
    seams = ran.json["seams"]
    assert seams
    blended = [row for row in ran.json["walk"] if " > " in row["clip"]]
    assert [s["start_s"] for s in seams] == pytest.approx(
        [row["start_s"] for row in blended if row["start_s"] < seconds], abs=0.5 / 30
    )
    assert all(s["start_s"] < s["end_s"] <= seconds for s in seams)
    assert {f.name for f in (tmp_path / "out").iterdir()} == {
        "motion.bvh",
        "result.json",
        "walk.png",
    }


@pytest.mark.parametrize(
    ("row", "word"),
    [
        ({"limb": "tail", "place": [0, 1, 2], "when": 1}, "'tail'"),
        ({"limb": "head", "place": [0, -1, 2], "when": 1}, "under the floor"),
        ({"limb": "right_hand", "place": [0, 1, 2]}, "no time"),
        ({"limb": "right_hand", "place": [0, 1.1, 0], "when": "start"}, "inside the body"),
    ],
)
def test_bad_targets(folder: Path, tmp_path: Path, row: dict, word: str) -> None:
    ran = run(*words(folder, tmp_path, json.dumps([row])))
    refused(ran, word, out=tmp_path / "out")


def test_bad_numbers(folder: Path, tmp_path: Path) -> None:
    text = '[{"limb": "right_hand", "place": [0, NaN, 2], "when": 1}]'
    refused(run(*words(folder, tmp_path, text)), "NaN", "reach.json", out=tmp_path / "out")
