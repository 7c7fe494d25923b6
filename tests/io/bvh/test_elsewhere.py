"""BVH files that we write: read back, and as two other Python readers and three.js see them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mgjax.core.kinematics import global_positions
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion
from tests.io.skeletons import CASES
from tests.io.three import seen_by_three

METRES = 0.01
SIMPLE = [name for name in CASES if name != "deep chain"]  # others stop at the blank in a name


def written(folder: Path, name: str):
    skeleton, motion = CASES[name]()
    save_bvh(folder / "x.bvh", skeleton, motion)
    return folder / "x.bvh", skeleton, motion


@pytest.mark.parametrize("name", CASES)
def test_places_come_back(tmp_path, name):
    path, skeleton, motion = written(tmp_path, name)
    again = load_motion(path)
    assert again[1].frame_rate == pytest.approx(motion.frame_rate, rel=1e-6)
    places = global_positions(*again)
    want = global_positions(skeleton, motion)
    # The file lists joints depth first and names ends after the joints that they belong to.
    for joint, joint_name in enumerate(skeleton.names):
        if joint_name in again[0].names:
            got = places[:, again[0].index(joint_name)]
            np.testing.assert_allclose(got, want[:, joint], atol=1e-5, err_msg=joint_name)
    assert again[0].num_joints == skeleton.num_joints


@pytest.mark.parametrize("name", SIMPLE)
def test_bvhio_sees_the_same_places(tmp_path, name):
    bvhio = pytest.importorskip("bvhio")
    path, skeleton, motion = written(tmp_path, name)
    want = global_positions(skeleton, motion)
    root = bvhio.readAsHierarchy(str(path))
    for frame in range(motion.num_frames):
        root.loadPose(frame)
        seen = {joint.Name: METRES * np.array(joint.PositionWorld) for joint, *_ in root.layout()}
        joints = [j for j, n in enumerate(skeleton.names) if n in seen]
        assert len(joints) >= skeleton.num_joints - len(skeleton.end_joints)
        got = [seen[skeleton.names[j]] for j in joints]
        np.testing.assert_allclose(got, want[frame, joints], atol=1e-3)


@pytest.mark.parametrize("name", [n for n in SIMPLE if n not in ("moving bones", "single")])
def test_pybvh_sees_the_same_places(tmp_path, name):
    pybvh = pytest.importorskip("pybvh")  # has no position channels but the root's
    path, _, _ = written(tmp_path, name)
    skeleton, motion = load_motion(path)  # nodes in the order of the file
    got = METRES * np.asarray(pybvh.read_bvh_file(str(path)).node_positions(), np.float64)
    np.testing.assert_allclose(got, global_positions(skeleton, motion), atol=1e-3)


@pytest.mark.parametrize("name", [n for n in SIMPLE if n not in ("moving bones", "single")])
def test_three_sees_the_same_places(tmp_path, name):
    path, skeleton, motion = written(tmp_path, name)  # it adds position channels to OFFSET
    joints = [j for j in range(skeleton.num_joints) if j not in skeleton.end_joints]
    names = [skeleton.names[j] for j in joints]
    got = METRES * seen_by_three(path, names, motion.num_frames, motion.frame_rate)
    want = global_positions(skeleton, motion)[:, joints]
    np.testing.assert_allclose(got, want, atol=1e-3)


def test_capture_as_three_sees_it(capture, tmp_path):
    skeleton, motion = load_motion(sorted((capture / "ball").glob("*/*.amc"))[0])
    save_bvh(tmp_path / "x.bvh", skeleton, motion)
    joints = [j for j in range(skeleton.num_joints) if j not in skeleton.end_joints]
    names = [skeleton.names[j] for j in joints]
    got = seen_by_three(tmp_path / "x.bvh", names, motion.num_frames, motion.frame_rate)
    want = global_positions(skeleton, motion)[:, joints]
    np.testing.assert_allclose(METRES * got, want, atol=1e-3)
