from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mgjax.core.errors import FileFormatError, MotionError
from mgjax.io.load import load_motion
from mgjax.io.npz import KEYS
from mgjax.io.npz.read import read_npz
from mgjax.io.npz.write import save_npz
from tests.io.skeletons import CASES, assert_same


@pytest.mark.parametrize("name", CASES)
def test_reads_back_exactly(tmp_path, name):
    case = CASES[name]()
    save_npz(tmp_path / "x.npz", *case)
    assert_same(case, load_motion(tmp_path / "x.npz"))


def test_keys_and_shapes_are_those_of_the_table(tmp_path):
    skeleton, motion = CASES["moving bones"]()
    save_npz(tmp_path / "x.npz", skeleton, motion)
    with np.load(tmp_path / "x.npz", allow_pickle=False) as file:
        arrays = dict(file)
    assert set(arrays) == {*KEYS, "joint_offsets"}
    assert arrays["quaternions"].shape == (9, 15, 4)
    assert arrays["root"].shape == (9, 3)
    assert arrays["offsets"].shape == (15, 3)
    assert arrays["names"].tolist() == list(skeleton.names)
    assert arrays["parents"].tolist() == list(skeleton.parents)
    assert arrays["end_joints"].tolist() == [12, 14]
    assert (float(arrays["fps"]), int(arrays["version"])) == (120, 1)


def test_another_rate_may_be_stated(tmp_path):
    save_npz(tmp_path / "x.npz", *CASES["random"]())
    _, motion = load_motion(tmp_path / "x.npz", frame_rate=50)
    assert (motion.frame_rate, motion.num_frames) == (50, 40)


def test_what_is_not_finite_is_not_written(tmp_path):
    skeleton, motion = CASES["random"]()
    bad = replace(motion, root_translation=np.full_like(motion.root_translation, np.inf))
    with pytest.raises(MotionError, match="not finite"):
        save_npz(tmp_path / "x.npz", skeleton, bad)
    assert not list(tmp_path.iterdir())


CHANGES = {
    "version": (np.array(2), "version 2"),
    "names": (np.array(["a"] * 15), "two joints"),
    "parents": (np.array([-1.0, *[0.5] * 14]), "'0.5' in 'parents'"),
    "offsets": (np.full((15, 3), np.nan, np.float32), "NaN or infinity"),
    "end_joints": (np.array([15]), "'15' in 'end_joints'"),
    "quaternions": (np.zeros((40, 15, 4)), "length 0"),
    "root": (np.zeros((39, 3)), "shape|40"),
    "fps": (np.array(0.0), "frame rate is 0"),
    "joint_offsets": (np.zeros((40, 14, 3)), "shape"),
}


@pytest.mark.parametrize("key", CHANGES)
def test_what_is_wrong_is_said(tmp_path, key):
    save_npz(tmp_path / "x.npz", *CASES["random"]())
    with np.load(tmp_path / "x.npz") as file:
        arrays = dict(file)
    value, words = CHANGES[key]
    np.savez(tmp_path / "x.npz", **(arrays | {key: value}))
    with pytest.raises(FileFormatError, match=words):
        read_npz(tmp_path / "x.npz")


@pytest.mark.parametrize("key", KEYS)
def test_a_missing_key_and_a_pickle_are_refused(tmp_path, key):
    save_npz(tmp_path / "x.npz", *CASES["random"]())
    with np.load(tmp_path / "x.npz") as file:
        arrays = dict(file)
    np.savez(tmp_path / "x.npz", **(arrays | {key: np.array([{}], object)}))
    with pytest.raises(FileFormatError, match="pickle"):
        read_npz(tmp_path / "x.npz")
    del arrays[key]
    np.savez(tmp_path / "x.npz", **arrays)
    with pytest.raises(FileFormatError, match=f"expected.*{key}"):
        load_motion(tmp_path / "x.npz")


def test_other_arrays_are_no_motion(tmp_path):
    np.savez(tmp_path / "x.npz", times=np.arange(3), centres=np.zeros((3, 3)))
    with pytest.raises(FileFormatError, match=r"'centres', 'times', expected version.* AMASS"):
        load_motion(tmp_path / "x.npz")
    for content in (b"", b"PK", b"text"):
        (tmp_path / "x.npz").write_bytes(content)
        with pytest.raises(FileFormatError, match="npz"):
            load_motion(tmp_path / "x.npz")
    with pytest.raises(FileFormatError, match="no such file"):
        load_motion(tmp_path / "y.npz")


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_byte_may_be_another(tmp_path, data):
    save_npz(tmp_path / "x.npz", *CASES["inner end"]())
    content = bytearray((tmp_path / "x.npz").read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    (tmp_path / "x.npz").write_bytes(content[: data.draw(st.sampled_from([None, 900, 60]))])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        text = refusal(tmp_path / "x.npz")
    assert text.isprintable()  # so it is one line


def refusal(path) -> str:
    """What is wrong with a file, or nothing."""
    try:
        load_motion(path)
    except FileFormatError as error:
        return str(error)
    return ""
