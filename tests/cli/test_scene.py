"""``mgjax scene``: what is written is checked against itself, by other code, in float64."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mgjax.ballsport.ball.physics import BallPhysics
from mgjax.ballsport.config import hit_bone
from mgjax.ballsport.hits.detect import hit_joint
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.io.load import load_motion
from tests.cli.conftest import Ran, refused, run
from tests.reference import ball as reference
from tests.reference.kinematics import forward
from tests.sensor.transport import PlayedReceiver

PLAYERS = """
[[players]]
name = "Ana"
x = 0.0
z = -2.2
[[players]]
name = "Ben"
x = 1.9
z = 2.2
[[players]]
name = "Cem"
x = -1.9
z = 2.2
"""
PASSES = """
[[passes]]
by = "Ana"
to = "Ben"
kind = "pass"
[[passes]]
by = "Ben"
to = "Cem"
bounces = 0
[[passes]]
by = "Cem"
to = "Ana"
kind = "toss"
bone = "left_foot"
"""
SCENE = (
    "takes = 2\nframe_rate = 30.0\nend_s = 1.0\n[net]\nz = 0.3\nheight = 0.9\n" + PLAYERS + PASSES
)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Ran]:
    folder = tmp_path_factory.mktemp("scene")
    (folder / "scene.toml").write_text(SCENE)
    ran = run("scene", "--config", folder / "scene.toml", "--out", folder / "out", "--json")
    assert ran.status == 0, ran.err
    return folder / "out", ran


def ball_rows(folder: Path) -> list[dict[str, Any]]:
    with (folder / "ball.csv").open() as file:
        return [
            {k: v if k == "event" else float(v) for k, v in row.items()}
            for row in csv.DictReader(file)
        ]


def test_files(written: tuple[Path, Ran]) -> None:
    folder, ran = written
    names = {p.name for p in folder.iterdir()}
    assert names == {"Ana.bvh", "Ben.bvh", "Cem.bvh", "ball.csv", "timeline.json", "scene.png"}
    assert json.loads((folder / "timeline.json").read_text()) == ran.json
    assert (ran.json["passes_made"], ran.json["passes_missed"]) == (3, 0)
    assert [row["bone"] for row in ran.json["passes"]][2] == "left_foot"
    assert [row["kind"] for row in ran.json["passes"]][::2] == ["pass", "toss"]
    frames = {load_motion(folder / f"{n}.bvh")[1].num_frames for n in ("Ana", "Ben", "Cem")}
    assert frames == {round(ran.json["seconds"] * 30)}


def test_ball_meets_the_feet_of_the_written_motion(written: tuple[Path, Ran]) -> None:
    """Forward kinematics of the BVH files at the hits against the CSV: within 1 cm."""
    folder, ran = written
    rows = ball_rows(folder)
    for row in [*ran.json["passes"], *ran.json["throws"]]:
        time, bone = row["arrives_s"], row["with"]
        at = next(r for r in rows if abs(r["t"] - time) < 1e-5)
        assert at["event"] == f"hit {row['to']}"
        skeleton, motion = load_motion(folder / f"{row['to']}.bvh")
        frame = round(time * 30)
        places, _ = forward(
            skeleton.parents,
            np.asarray(skeleton.offsets, np.float64),
            np.asarray(motion.root_translation, np.float64)[frame],
            np.asarray(motion.local_rotations, np.float64)[frame],
        )
        joint = places[hit_joint(skeleton, bone)]
        apart = np.linalg.norm(joint - [at["x"], at["y"], at["z"]])
        assert abs(apart - 0.11 - hit_bone(bone).radius_m) < 0.002
        assert at["y"] >= 0.11


def test_ball_flies_as_the_reference(written: tuple[Path, Ran]) -> None:
    """Between hits the CSV agrees with float64 flight, and arrives with the wanted bounces."""
    folder, ran = written
    rows = ball_rows(folder)
    for leg in [*ran.json["passes"], *ran.json["throws"]]:
        start, velocity = np.array(leg["place_m"]), np.array(leg["velocity_m_s"])
        inside = [r for r in rows if leg["start_s"] - 1e-6 <= r["t"] < leg["arrives_s"] - 1e-5]
        times = np.array([r["t"] for r in inside]) - leg["start_s"]
        flown = reference.fly(start, velocity, np.maximum(times, 0), BallPhysics())
        assert np.abs(flown - [[r["x"], r["y"], r["z"]] for r in inside]).max() < 1e-3
        end, bounces = reference.arrival(start, velocity, leg["flight_s"], BallPhysics())
        assert np.linalg.norm(end - leg["contact_m"]) < 1e-3
        assert bounces == leg["bounces"]
        assert sum(r["event"] == "bounce" for r in inside) == bounces


def test_ball_goes_over_the_net_and_past_the_others(written: tuple[Path, Ran]) -> None:
    folder, ran = written
    z = np.array([[r["t"], r["y"], r["z"]] for r in ball_rows(folder)])
    crossings = np.flatnonzero(np.diff(np.sign(z[:, 2] - 0.3)))
    last = max(row["arrives_s"] for row in ran.json["passes"])
    for f in crossings[z[crossings, 0] < last]:
        assert max(z[f, 1], z[f + 1, 1]) > 0.9
    for row in ran.json["passes"]:
        assert row["distance_to_others_m"] > 0.2


def test_motion_is_smooth(written: tuple[Path, Ran]) -> None:
    """No joint jumps, nobody spins, and nobody wanders off."""
    _, ran = written
    for player in ran.json["players"]:
        assert player["seam_speed_m_s"] < 2.5
        assert player["turn_rate_deg_s"] < 250
        assert player["drift_m"] < 0.4
    assert all(1 / 1.13 < row["time_warp"] < 1.13 for row in ran.json["passes"])


@pytest.mark.long
def test_kicks_before_a_sensor_decide(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each kick decides the next pass of kind any; found with the thresholds of the file."""
    clips, _ = synthetic_kicks(seed=5, frame_rate=60.0, takes=1)
    clip = next(c for c in clips if c.name == "kick_pass_right")
    receiver = PlayedReceiver.of(clip.skeleton, clip.motion)
    monkeypatch.setattr("mgjax.cli.scene.SensorReceiver", receiver)
    file = tmp_path / "scene.toml"
    live = ("scene", "--config", file, "--live", 60, "--json", "--out")
    file.write_text(SCENE)
    ran = run(*live, tmp_path / "heard")
    assert ran.status == 0, ran.err
    assert "listening on 127.0.0.1:1" in ran.err
    (decided,) = ran.json["decided_live"]
    assert (decided["touch"], decided["bone"]) == (1, "right_foot")
    assert ran.json["passes"][1]["bone"] == "right_foot"
    # Longer sections join other places.
    file.write_text(SCENE.replace("[net]", "[transition]\nseconds = 0.5\n[net]"))
    assert run(*live, tmp_path / "slow").json["worst"] != ran.json["worst"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('to = "Ben"', 'to = "Xia"', ("pass 1", "'Xia'", "Ana, Ben, Cem")),
        ('to = "Ben"', 'to = "Ana"', ("pass 1", "itself")),
        ('by = "Ben"', 'by = "Ana"', ("pass 2", "'Ben'")),
        ("x = -1.9", "x = 1.8", ("Ben and Cem", "apart")),
        ("takes = 2", "takse = 2", ("'takse'", "'takes'")),
        ('kind = "pass"', 'kind = "smash"', ("'smash'", "toss, pass, attack")),
        ("bounces = 0", "bounces = 9", ("pass 2", "9 bounces")),
        ("bounces = 0", 'bounces = "one"', ("passes 2", "a whole number")),
        ('bone = "left_foot"', 'bone = "knee"', ("pass 3", "'knee'")),
        ("[net]", "[physics]\nrestitution = -0.5\n[net]", ("restitution", "-0.5")),
        ("[net]", "[physics]\ndrag = -1.0\n[net]", ("drag", "-1")),
        ("height = 0.9", "height = -1.0", ("height", "-1")),
        ("end_s = 1.0", "throw_in = [0.0, -1.0, 0.0]", ("throw_in", "-1")),
        ('name = "Ben"', 'name = "../Ben"', ("'../Ben'", "letters")),
        ("[net]", "[net", ("no TOML",)),
        ("[net]", "[analysis]\nmerge_s = -1.0\n[net]", ("analysis.merge_s = -1", "0 … 60")),
        ("[net]", "[analysis]\nheigth_m = 1.0\n[net]", ("'analysis.heigth_m'", "height_m")),
        ("[net]", "[kinds]\npass_m_s = 9.0\n[net]", ("kinds.attack_m_s = 7.2",)),
        ("[net]", "[transition]\nseconds = 0.0\n[net]", ("transition.seconds = 0.0",)),
        ("[net]", "[transition]\nw_p = [1, 1, 1]\n[net]", ("transition.w_p", "a list of 5")),
        ("[net]", "[match]\nw_t = -1.0\n[net]", ("match.w_t = -1", "0 … 1e+09")),
        ("end_s = 1.0", 'bones = ["knee"]', ("'knee'", "left_foot, right_foot")),
        ("end_s = 1.0", "max_speed = nan", ("max_speed = nan", "0.001 … 100")),
        ("end_s = 1.0", "seed = -1", ("seed = -1",)),
        ("takes = 2", "takes = 0", ("takes = 0", "1 … 20")),
        ("frame_rate = 30.0", "frame_rate = 10.0", ("frame_rate = 10.0", "20 … 240")),
        ("x = 1.9\n", "", ("players 2", "no x")),
    ],
)
def test_bad_scenes(tmp_path: Path, old: str, new: str, words: tuple[str, ...]) -> None:
    assert old in SCENE
    (tmp_path / "scene.toml").write_text(SCENE.replace(old, new, 1))
    out = tmp_path / "out"
    refused(
        run("scene", "--config", tmp_path / "scene.toml", "--out", out),
        "scene.toml",
        *words,
        out=out,
    )
