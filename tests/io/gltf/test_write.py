"""GLB files that we write: read back, by the validator, and as three.js sees them."""

from __future__ import annotations

import json
import struct
import sys

import numpy as np
import pytest

from mgjax.core.errors import ConfigError, MotionError, OutputError
from mgjax.core.kinematics import global_positions
from mgjax.io.gltf.write import save_glb
from mgjax.io.load import load_motion
from tests.conftest import make_motion, make_skeleton
from tests.io.skeletons import CASES, assert_same
from tests.io.three import issues, seen_by_three


@pytest.mark.parametrize("name", CASES)
def test_reads_back_exactly(tmp_path, name):
    case = CASES[name]()
    save_glb(tmp_path / "x.glb", *case)
    assert_same(case, load_motion(tmp_path / "x.glb"))


@pytest.mark.parametrize("name", CASES)
def test_the_validator_finds_nothing(tmp_path, name):
    save_glb(tmp_path / "x.glb", *CASES[name]())
    found = issues(tmp_path / "x.glb")
    assert found["messages"] == []


@pytest.mark.parametrize("name", CASES)
def test_three_sees_the_same_places(tmp_path, name):
    skeleton, motion = CASES[name]()
    save_glb(tmp_path / "x.glb", skeleton, motion)
    want = global_positions(skeleton, motion)
    got = seen_by_three(tmp_path / "x.glb", skeleton.names, motion.num_frames, motion.frame_rate)
    np.testing.assert_allclose(got, want, atol=1e-3)


def test_capture_through_a_glb(capture, tmp_path):
    skeleton, motion = load_motion(sorted((capture / "ball").glob("*/*.amc"))[0])
    save_glb(tmp_path / "x.glb", skeleton, motion)
    assert_same((skeleton, motion), load_motion(tmp_path / "x.glb"), tolerance=1e-6)
    want = global_positions(skeleton, motion)
    got = seen_by_three(tmp_path / "x.glb", skeleton.names, motion.num_frames, motion.frame_rate)
    np.testing.assert_allclose(got, want, atol=1e-3)


def document(path) -> dict:
    data = path.read_bytes()
    return json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])


def test_what_never_turns_has_one_key(tmp_path):
    skeleton, motion = CASES["still"]()
    save_glb(tmp_path / "x.glb", skeleton, motion)
    file = document(tmp_path / "x.glb")
    counts = [
        file["accessors"][sampler["input"]]["count"]
        for sampler in file["animations"][0]["samplers"]
    ]
    assert counts == [50] + [1] * 13  # the root's place tells how long it is


def test_another_rate_of_keys_outweighs_the_stated_one(tmp_path):
    """A program that thins out the keys may keep what is said beside them."""
    skeleton, motion = make_skeleton(), make_motion(make_skeleton(), frames=7, frame_rate=60.0)
    save_glb(tmp_path / "x.glb", skeleton, motion)
    data = (tmp_path / "x.glb").read_bytes()
    assert data.count(b'"frame_rate":60.0') == 1
    (tmp_path / "x.glb").write_bytes(data.replace(b'"frame_rate":60.0', b'"frame_rate":41.7'))
    assert load_motion(tmp_path / "x.glb")[1].frame_rate == 60


def test_without_pygltflib_it_says_how_to_get_it(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "pygltflib", None)
    with pytest.raises(ConfigError, match=r"mgjax\[export\]"):
        save_glb(tmp_path / "x.glb", *CASES["random"]())
    assert not list(tmp_path.iterdir())


def test_bad_motions_and_places_are_refused(tmp_path):
    skeleton, motion = CASES["random"]()
    np.asarray(motion.root_translation)[3, 1] = np.nan
    with pytest.raises(MotionError, match="frame 3"):
        save_glb(tmp_path / "x.glb", skeleton, motion)
    with pytest.raises(OutputError, match="cannot be written"):
        save_glb(tmp_path / "no" / "x.glb", *CASES["random"]())
    assert not list(tmp_path.iterdir())
