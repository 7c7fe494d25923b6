"""``mgjax info`` and ``mgjax build`` of what other makers write."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from mgjax.core.body.roles import find_roles
from mgjax.graph.files import load_graph
from mgjax.io.load import load_motion
from tests.cli.conftest import run
from tests.io.reading.made import Y_TO_Z, Maker, walk, write


def made(folder: Path, **files: Maker) -> Path:
    for name, maker in files.items():
        write(folder / f"{name}.bvh", *walk(300), maker)
    return folder


def test_info_of_a_folder_says_what_was_found(tmp_path: Path) -> None:
    made(tmp_path, plain=Maker(), turned=Maker(world=Y_TO_Z, scale=1 / 0.0254, floor=1.0))
    done = run("info", tmp_path)
    assert done.status == 0
    assert "unit: inch, up: z" in done.out
    assert "Z points up in the file; the body was turned upright" in done.out
    rows = json.loads(run("info", tmp_path, "--json").out)["files"]
    assert [row["up"] for row in rows] == ["y", "z"]
    told = json.loads(run("info", tmp_path / "plain.bvh", "--json", "--fps", "5").out)["files"][0]
    assert told["fps"] == 5
    assert "slow_rate" in [oddity["kind"] for oddity in told["oddities"]]


def test_info_shows_the_body(tmp_path: Path) -> None:
    made(tmp_path, plain=Maker())
    done = run("info", tmp_path / "plain.bvh", "--roles", "--out", tmp_path / "out")
    assert "left_knee: ltibia" in done.out
    assert (tmp_path / "out" / "plain_body.png").stat().st_size > 10_000
    (tmp_path / "roles.toml").write_text('head = "lowerneck"\n')
    done = run("info", tmp_path / "plain.bvh", "--roles", tmp_path / "roles.toml")
    assert "head: lowerneck" in done.out


def test_what_was_said_is_in_the_graph(tmp_path: Path) -> None:
    made(tmp_path, one=Maker(floor=1.0), two=Maker(along_x=True, floor=0.9, scale=1.0))
    (tmp_path / "roles.toml").write_text('head = "lowerneck"\n')
    out = tmp_path / "out"
    done = run(
        "build",
        "--clips",
        tmp_path,
        "--out",
        out,
        "--floor",
        "0.9",
        "--roles",
        tmp_path / "roles.toml",
    )
    assert done.status == 0, done.err
    graph = load_graph(out)
    assert graph.report["readings"]["one.bvh"]["said"] == {
        "floor": 0.9,
        "roles": {"head": "lowerneck"},
    }
    assert graph.skeleton.names[find_roles(graph.skeleton)["head"]] == "lowerneck"


def test_an_animal_is_refused_and_built_when_told(tmp_path: Path) -> None:
    dog(tmp_path / "dog.bvh")
    done = run("build", "--clips", tmp_path, "--out", tmp_path / "out")
    assert done.status == 2
    assert "no body on two legs" in done.err
    assert "--no-body" in done.err
    done = run("build", "--clips", tmp_path, "--out", tmp_path / "out", "--no-body")
    assert done.status == 0, done.err
    assert load_graph(tmp_path / "out").report["clips"] == 1
    ball = ["--from", "0", "1", "5", "--at", "0", "1", "0", "--speed", "8", "--arrives", "1"]
    thrown = run("avoid", "--graph", tmp_path / "out", *ball, "--out", tmp_path / "throw")
    assert thrown.status == 2
    assert "found no joint for 'left_hip'" in thrown.err


def dog(path: Path) -> None:
    """Four legs that trot on the spot."""
    lines = ["HIERARCHY", "ROOT Hips", "{", "OFFSET 0 0 0",
             "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"]  # fmt: skip

    def leg(name: str, x: int) -> None:
        for part, (dx, dy) in (("UpLeg", (8 * x, 0)), ("Leg", (0, -30)), ("Foot", (0, -28))):
            lines.extend([f"JOINT {name}{part}", "{", f"OFFSET {dx} {dy} 0"])
            lines.append("CHANNELS 3 Zrotation Xrotation Yrotation")
        lines.extend(["End Site", "{", "OFFSET 0 -5 5", "}", "}", "}", "}"])

    leg("LeftHind", 1)
    leg("RightHind", -1)
    lines += ["JOINT Spine", "{", "OFFSET 0 0 50", "CHANNELS 3 Zrotation Xrotation Yrotation"]
    leg("LeftFront", 1)
    leg("RightFront", -1)
    lines += ["JOINT Head", "{", "OFFSET 0 20 30", "CHANNELS 3 Zrotation Xrotation Yrotation",
              "End Site", "{", "OFFSET 0 0 15", "}", "}", "}", "}"]  # fmt: skip
    t = np.arange(90) / 30
    swing = 20 * np.sin(2 * np.pi * t)
    rows = np.zeros((90, 6 + 3 * 14))
    rows[:, 1] = 63
    for k, sign in ((0, 1), (1, -1)):
        rows[:, 6 + 9 * k + 1] = sign * swing
        rows[:, 6 + 18 + 3 + 9 * k + 1] = -sign * swing
    lines += ["MOTION", "Frames: 90", "Frame Time: 0.0333333"]
    lines += [" ".join(f"{v:.4f}" for v in row) for row in rows]
    path.write_text("\n".join(lines) + "\n")


def test_written_motion_of_a_flat_rest_pose_is_read_back(tmp_path: Path) -> None:
    made(tmp_path, one=Maker(along_x=True))
    skeleton, motion = load_motion(tmp_path / "one.bvh")
    again = run("info", "--json", tmp_path / "one.bvh")
    assert json.loads(again.out)["files"][0]["height_m"] > 1.5
    assert motion.num_frames == 300
    assert skeleton.names[0] == "root"
