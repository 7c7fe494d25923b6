"""Every reader on real capture, against the manifest and against other readers."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from mgjax.core.body.height import body_height
from mgjax.core.body.roles import require_roles
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import validate_motion
from mgjax.core.skeleton import first_difference, validate_skeleton
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion, read_capture
from tests.reference import asf_amc as reference
from tests.reference import kinematics as plain

CONVERTED = {
    "14": "avoidance/cmu14",
    "127": "avoidance/cmu127",
    "10": "ball/cmu10",
    "16": "locomotion/cmu16",
}


def manifest(capture: Path) -> list[dict[str, str]]:
    with (capture / "MANIFEST.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_every_clip_loads_with_the_stated_frames_and_rate(capture):
    rows = manifest(capture)
    assert len(rows) == 67
    for row in rows:
        skeleton, motion = load_motion(capture / row["file"])
        assert motion.num_frames == int(row["frames"]), row["file"]
        assert motion.frame_rate == float(row["fps"]), row["file"]
        validate_skeleton(skeleton)
        validate_motion(skeleton, motion)
        assert motion.local_rotations.dtype == motion.root_translation.dtype == np.float32
        norms = np.linalg.norm(motion.local_rotations, axis=-1)
        np.testing.assert_allclose(norms, 1, atol=1e-5)
        assert (motion.local_rotations[:, list(skeleton.end_joints)] == [1, 0, 0, 0]).all()
        assert 1.3 < (body_height(skeleton) or 0) < 1.9, row["file"]
        require_roles(skeleton, ("left_hip", "right_knee", "left_ankle", "chest", "left_wrist"))


def test_clips_of_all_subjects_have_one_hierarchy(capture):
    folders = sorted({(capture / row["file"]).parent for row in manifest(capture)})
    skeletons = [load_motion(next(f.glob("*.amc")))[0] for f in folders if list(f.glob("*.amc"))]
    assert len(skeletons) >= 6
    assert {first_difference(skeletons[0], s) for s in skeletons} == {None}


def test_converted_bvh_agrees_with_its_amc(capture):
    files = sorted(capture.glob("*/bvh_converted/*.bvh"))
    assert len(files) == 6
    for file in files:
        folder = CONVERTED[file.stem.split("_")[0]]
        theirs, ours = load_motion(file), load_motion(capture / folder / f"{file.stem}.amc")
        assert theirs[1].num_frames == ours[1].num_frames
        a, b = global_positions(*theirs), global_positions(*ours)
        shared = [name for name in ours[0].names if name in theirs[0].names]
        assert len(shared) >= 30
        for name in shared:
            error = np.abs(a[:, theirs[0].index(name)] - b[:, ours[0].index(name)]).max()
            assert error < 1e-4, (file.name, name, error)


@pytest.mark.parametrize(
    "clip",
    [
        "avoidance/cmu14/14_37",
        "avoidance/cmu127/127_25",
        "avoidance/cmu49/49_02",
        "ball/cmu10/10_05",
        "ball/cmu135/135_04",
        "locomotion/cmu16/16_47",
    ],
)
def test_amc_against_an_independent_reader(capture, clip):
    file = capture / f"{clip}.amc"
    asf = file.with_name(f"{file.stem.split('_')[0]}.asf")
    every = 40
    want = reference.positions(asf, file, every)
    skeleton, motion = load_motion(file)
    got = global_positions(skeleton, motion)[::every]
    for joint, name in enumerate(skeleton.names):
        np.testing.assert_allclose(got[:, joint], want[name], atol=1e-4, err_msg=name)


def test_kinematics_against_matrices(capture):
    skeleton, motion = load_motion(capture / "ball/cmu135_bvh/135_04.bvh")
    some = slice(0, None, 200)
    want = plain.global_positions(
        skeleton.parents,
        skeleton.offsets,
        motion.root_translation[some],
        motion.local_rotations[some],
    )
    np.testing.assert_allclose(global_positions(skeleton, motion)[some], want, atol=1e-5)


@pytest.mark.parametrize(
    "file",
    [
        "ball/cmu135_bvh/135_07.bvh",
        "locomotion/cmu131_bvh/131_01.bvh",
        "locomotion/bvh_converted/16_35.bvh",
    ],
)
def test_bvh_against_pybvh(capture, file):
    pybvh = pytest.importorskip("pybvh")
    capture_file = read_capture(capture / file)
    theirs = pybvh.read_bvh_file(str(capture / file))
    # Both list joints and end sites as the file does.
    want = np.asarray(theirs.node_positions(), np.float64) * capture_file.unit.metres
    got = global_positions(capture_file.skeleton, capture_file.motion)
    assert got.shape == want.shape
    np.testing.assert_allclose(got, want, atol=1e-4)
    assert capture_file.motion.frame_rate == pytest.approx(theirs.fps, rel=1e-4)


@pytest.mark.parametrize(
    "file",
    ["avoidance/cmu127/127_31.amc", "ball/cmu10/10_05.amc", "ball/cmu135_bvh/135_04.bvh"],
)
def test_written_files_read_back(capture, tmp_path, file):
    skeleton, motion = load_motion(capture / file)
    save_bvh(tmp_path / "out.bvh", skeleton, motion)
    again = read_capture(tmp_path / "out.bvh")
    assert again.unit.name == "centimetre"
    assert again.motion.frame_rate == motion.frame_rate
    assert len(again.skeleton.names) == len(skeleton.names)
    want = global_positions(skeleton, motion)
    got = global_positions(again.skeleton, again.motion)
    for joint, name in enumerate(skeleton.names):
        error = np.abs(got[:, again.skeleton.index(name)] - want[:, joint]).max()
        assert error < 1e-4, (name, error)
