"""``mgjax convert``: every format in, every format out."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mgjax.core.kinematics import global_positions
from mgjax.core.motion import resample
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion
from mgjax.io.reading.read_as import ReadAs
from mgjax.io.save import WRITERS
from tests.cli.conftest import refused, run
from tests.io import made
from tests.io.amass.test_amass import body as save_body
from tests.io.amass.test_amass import save as save_amass
from tests.io.gltf.made import Glb, armature
from tests.io.skeletons import CASES
from tests.io.three import seen_by_three

READABLE = [".bvh", ".glb", ".npz"]


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One file of each format that is read."""
    folder = tmp_path_factory.mktemp("inputs")
    skeleton, motion = CASES["clip"]()
    save_bvh(folder / "clip.bvh", skeleton, motion)
    (folder / "7.asf").write_text(made.ASF)
    (folder / "7_01.amc").write_text(made.AMC)
    (folder / "mixamo.glb").write_bytes(armature(3).bytes())
    save_amass(folder / "amass.npz", 156)
    assert run("convert", folder / "clip.bvh", "--out", folder / "ours.npz").status == 0
    names = {
        "bvh": "clip.bvh", "amc": "7_01.amc", "glb": "mixamo.glb", "amass": "amass.npz",
        "npz": "ours.npz",
    }  # fmt: skip
    return {kind: folder / name for kind, name in names.items()}


@pytest.mark.parametrize("kind", ["bvh", "amc", "glb", "amass", "npz"])
@pytest.mark.parametrize("suffix", READABLE)
def test_places_survive(inputs: dict[str, Path], tmp_path: Path, kind: str, suffix: str) -> None:
    out = tmp_path / f"out{suffix}"
    ran = run("convert", inputs[kind], "--out", out, "--json")
    assert (ran.status, ran.err) == (0, "")
    skeleton, motion = load_motion(inputs[kind])
    again = load_motion(out)
    assert ran.json == {
        "file": str(inputs[kind]),
        "out": str(out),
        "format": suffix[1:],
        "joints": skeleton.num_joints,
        "frames": motion.num_frames,
        "fps": motion.frame_rate,
        "seconds": round(motion.seconds, 4),
    }
    assert again[1].frame_rate == pytest.approx(motion.frame_rate)
    want, got = global_positions(skeleton, motion), global_positions(*again)
    for j, name in enumerate(skeleton.names):
        if name in again[0].names:
            np.testing.assert_allclose(got[:, again[0].index(name)], want[:, j], atol=1e-5)


@pytest.mark.parametrize("suffix", WRITERS)
def test_every_format_is_written(inputs: dict[str, Path], tmp_path: Path, suffix: str) -> None:
    ran = run("convert", inputs["bvh"], "--out", tmp_path / f"x{suffix.upper()}")
    assert (ran.status, ran.err) == (0, "")
    assert "31 joints" in ran.out or "38 joints" in ran.out
    assert [path.name for path in tmp_path.iterdir()] == [f"x{suffix.upper()}"]


@pytest.mark.parametrize("kind", ["glb", "amass"])
def test_bvh_of_other_formats_as_three_sees_it(
    inputs: dict[str, Path], tmp_path: Path, kind: str
) -> None:
    path = tmp_path / inputs[kind].name  # three.js takes a colon for the end of a name
    path.write_bytes(inputs[kind].read_bytes().replace(b"mixamorig:", b"mixamorig_"))
    skeleton, motion = load_motion(path)
    assert run("convert", path, "--out", tmp_path / "x.bvh").status == 0
    names = [n for j, n in enumerate(skeleton.names) if j not in skeleton.end_joints]
    got = seen_by_three(tmp_path / "x.bvh", names, motion.num_frames, motion.frame_rate) / 100
    want = global_positions(skeleton, motion)[:, [skeleton.index(n) for n in names]]
    np.testing.assert_allclose(got, want, atol=1e-3)


def test_another_rate(inputs: dict[str, Path], tmp_path: Path) -> None:
    ran = run("convert", inputs["bvh"], "--out", tmp_path / "x.npz", "--frame-rate", 12, "--json")
    assert (ran.json["fps"], ran.json["frames"]) == (12, 40)
    _, motion = load_motion(inputs["bvh"])
    _, again = load_motion(tmp_path / "x.npz")
    want = resample(motion, 12)
    np.testing.assert_allclose(again.root_translation, want.root_translation, atol=1e-6)
    np.testing.assert_allclose(again.local_rotations, want.local_rotations, atol=1e-6)


def test_a_glb_is_sampled_at_the_rate(tmp_path: Path) -> None:
    file = Glb()
    node = file.node("only")
    keys = np.reshape([[0, 0, 0], [0, 0, 0], [3, 0, 0], [0, 0, 0], [1, 0, 0], [0, 0, 0]], (6, 3))
    times, values = file.accessor([0.0, 2.0]), file.accessor(keys)
    file.animate((node, "translation", times, values, "CUBICSPLINE"))
    file.skin([node])
    file.scene(node)
    (tmp_path / "x.glb").write_bytes(file.bytes())
    words = ("convert", tmp_path / "x.glb", "--out", tmp_path / "x.npz", "--frame-rate", 1)
    assert run(*words).status == 0
    # Half-way a spline that leaves with 3/s is at 1.25; see tests/io/gltf/test_read.py.
    _, motion = load_motion(tmp_path / "x.npz")
    np.testing.assert_allclose(motion.root_translation[:, 0], [0, 1.25, 1], atol=1e-6)


def test_a_body_model(inputs: dict[str, Path], tmp_path: Path) -> None:
    save_body(tmp_path / "body.npz")
    words = ("convert", inputs["amass"], "--out", tmp_path / "x.npz")
    assert run(*words, "--body-model", tmp_path / "body.npz").status == 0
    want, _ = load_motion(inputs["amass"], read_as=ReadAs(body_model=tmp_path / "body.npz"))
    got, _ = load_motion(tmp_path / "x.npz")
    np.testing.assert_array_equal(got.offsets, want.offsets)


def test_a_folder(inputs: dict[str, Path], tmp_path: Path) -> None:
    folder, out = tmp_path / "in", tmp_path / "out"
    (folder / "deep").mkdir(parents=True)
    for kind, name in (("bvh", "a.bvh"), ("glb", "deep/b.GLB"), ("npz", "deep/c.npz")):
        (folder / name).write_bytes(inputs[kind].read_bytes())
    np.savez(folder / "volumes.npz", times=np.arange(3))
    ran = run("convert", folder, "--out", out, "--to", ".glb", "--json")
    assert (ran.status, ran.err) == (0, "")
    written = sorted(p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file())
    assert written == ["a.glb", "deep/b.glb", "deep/c.glb"]
    assert [Path(file["out"]) for file in ran.json["files"]] == [out / name for name in written]
    a, b = load_motion(folder / "a.bvh"), load_motion(out / "a.glb")
    np.testing.assert_array_equal(a[1].local_rotations, b[1].local_rotations)
    assert run("convert", folder, "--out", out, "--to", "glb").status == 0  # again, over them


def test_of_a_folder_all_or_nothing(inputs: dict[str, Path], tmp_path: Path) -> None:
    folder, out = tmp_path / "in", tmp_path / "out"
    (folder / "deep").mkdir(parents=True)
    (folder / "a.bvh").write_bytes(inputs["bvh"].read_bytes())
    words = ("convert", folder, "--out", out)
    refused(run(*words), "without --to", out=out)
    refused(run(*words, "--to", ".fbx"), "'.fbx'", out=out)
    refused(run("convert", folder / "a.bvh", "--out", out, "--to", ".glb"), "no folder", out=out)
    (folder / "deep" / "z.bvh").write_text("HIERARCHY")
    refused(run(*words, "--to", ".glb"), "z.bvh:1", out=out)
    (folder / "a.glb").write_bytes(inputs["glb"].read_bytes())
    refused(run(*words, "--to", ".npz"), "a.bvh and a.glb", "a.npz", out=out)


def test_what_is_known_of_files(inputs: dict[str, Path], tmp_path: Path) -> None:
    """By options, and by a clips.toml beside the file, as for other commands."""
    ran = run("convert", inputs["amc"], "--fps", 60, "--out", tmp_path / "x.npz", "--json")
    assert (ran.json["fps"], ran.json["frames"]) == (60, 3)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.npz").write_bytes(inputs["amass"].read_bytes())
    save_body(tmp_path / "in" / "models" / "body.npz")
    (tmp_path / "in" / "clips.toml").write_text('["a.npz"]\nbody_model = "models/body.npz"\n')
    words = ("--out", tmp_path / "out", "--to", ".npz")
    assert run("convert", tmp_path / "in", *words).status == 0
    want = ReadAs(body_model=tmp_path / "in" / "models" / "body.npz")
    np.testing.assert_array_equal(
        load_motion(tmp_path / "out" / "a.npz")[0].offsets,
        load_motion(inputs["amass"], read_as=want)[0].offsets,
    )
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["a.npz"]


def test_bad_input_is_one_line(inputs: dict[str, Path], tmp_path: Path) -> None:
    bvh, out = inputs["bvh"], tmp_path / "out.glb"
    refused(run("convert", bvh, "--out", tmp_path / "x.fbx"), "x.fbx", "'.fbx'", ".glb")
    refused(run("convert", bvh, "--out", tmp_path / "folder"), "''")
    refused(run("convert", tmp_path / "no.bvh", "--out", out), "no.bvh", "no such file", out=out)
    refused(run("convert", bvh.parent / "7.asf", "--out", out), "'.asf'", ".npz", out=out)
    refused(run("convert", bvh, "--out", tmp_path / "no" / "x.glb"), "cannot be written")
    refused(run("convert", bvh, "--out", out, "--body-model", bvh), "AMASS", out=out)
    refused(run("convert", bvh, "--out", out, "--frame-rate", 0), "--frame-rate 0", out=out)
    refused(
        run("convert", inputs["amc"], "--out", tmp_path / "x.vrma"),
        *("leftUpperArm", "leftHand"),
        out=tmp_path / "x.vrma",
    )
    assert not list(tmp_path.iterdir())


def test_as_a_process(inputs: dict[str, Path], tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mgjax", "convert", inputs["bvh"], "--out", tmp_path / "x.glb"]
    done = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "30 fps" in done.stdout
