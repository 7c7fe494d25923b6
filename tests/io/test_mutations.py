"""Files that are almost right: either a documented error comes out or a valid, finite motion."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mgjax.clips.oddities import find_oddities
from mgjax.core.errors import FileFormatError, MgjaxError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion
from tests.io import made
from tests.work import counted

LINES, SCANS = 10, 30
"""Most lines of code for each byte of a file, and how often all of it is gone through."""

WORDS = """
    0 1 -1 1e308 -1e308 1e999 1e-999 1e38 4e38 1e-320 nan inf -inf NaN 999999999999 1_0 0x10 ² ٣ ½
    -0 +5 .5 5. . - e 1e 1e5 1d5 1,5 6 7 ROOT JOINT End Site OFFSET CHANNELS MOTION HIERARCHY
    Frames: Frames:2 Frame Time: { } {{{{ }}}} Xposition Yrotation Wrotation :root :bonedata :units
    :hierarchy :DEGREES :RADIANS begin end name dof axis XYZ ZZZ direction length order root lfemur
    ltibia back head rx tx l (-1 1) # limits position
"""
ODD = ["\0", "\x1a", "\x0b", "\x85", "\u2028", "\ufeff", "\n", "\r", "\t", " ", ""]
LONG = ["9" * 400, "9" * 5000, "-" * 300, "A" * 3000]
TOKENS = st.sampled_from([*WORDS.split(), *ODD, *LONG])


@st.composite
def mutated(draw, text: str) -> bytes:
    """Up to four changes to lines, tokens, characters or bytes."""
    for _ in range(draw(st.integers(1, 4))):
        kind = draw(st.sampled_from(["line", "token", "token", "token", "character", "cut"]))
        if kind == "cut":
            text = text[: draw(st.integers(0, len(text)))]
            continue
        pattern = {"line": r"[^\n]*\n", "token": r"\S+", "character": r"(?s)."}[kind]
        places = list(re.finditer(pattern, text))
        if not places:
            continue
        place = places[draw(st.integers(0, len(places) - 1))]
        here = place[0]
        action = draw(st.sampled_from(["delete", "insert", "replace", "double", "swap"]))
        if action == "swap":
            other = places[draw(st.integers(0, len(places) - 1))][0]
            new = other
        elif action == "double":
            new = f"{here} {here}" if kind == "token" else here * 2
        elif action == "delete":
            new = ""
        else:
            token = draw(TOKENS if kind != "character" else st.characters(codec="utf-8"))
            new = token if action == "replace" else f"{token} {here}"
        text = text[: place.start()] + new + text[place.end() :]
    data = text.encode("utf-8", "surrogatepass")
    if draw(st.integers(0, 9)) == 0 and data:
        at = draw(st.integers(0, len(data) - 1))
        data = data[:at] + bytes([draw(st.integers(0, 255))]) + data[at + 1 :]
    return data


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("mutated")


def attempt(path: Path) -> tuple[Skeleton, Motion] | FileFormatError:
    """What is loaded or the error of ours, with work that grows like the file's size at most."""
    with counted() as work:
        try:
            result = load_motion(path)
        except FileFormatError as error:
            result = error
    skeleton = path.with_name(f"{path.stem[0]}.asf")
    size = sum(file.stat().st_size for file in (path, skeleton) if file.exists())
    assert work.lines <= LINES * size + 5_000
    assert work.characters <= SCANS * size + 50_000
    if isinstance(result, FileFormatError):
        assert len(str(result).splitlines()) == 1
        assert str(result).isprintable()
        assert len(str(result)) < 600
        assert result.line is None or result.line >= 1
    return result


def load_or_refuse(path: Path) -> bool:
    """Whether it loaded; then the motion must be sound, also for what is done with it next."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = attempt(path)
        if isinstance(result, FileFormatError):
            return False
        skeleton, motion = result
        validate_skeleton(skeleton)
        validate_motion(skeleton, motion)
        assert np.isfinite(global_positions(skeleton, motion)).all()
        norms = np.linalg.norm(motion.local_rotations, axis=-1)
        np.testing.assert_allclose(norms, 1, atol=1e-5)
        find_oddities(skeleton, motion)
        again = path.with_name("again.bvh")
        try:
            save_bvh(again, skeleton, motion)
        except MgjaxError:
            return True  # a name that BVH cannot hold
        if motion.frame_rate >= 0.1:  # the reader takes no slower one
            other, _ = load_motion(again, units="cm")
            assert other.num_joints == skeleton.num_joints
    return True


@settings(max_examples=300)
@given(mutated(made.BVH))
def test_bvh(folder, data):
    (folder / "x.bvh").write_bytes(data)
    load_or_refuse(folder / "x.bvh")


@settings(max_examples=200)
@given(mutated(made.ASF))
def test_asf(folder, data):
    (folder / "7.asf").write_bytes(data)
    (folder / "7_01.amc").write_text(made.AMC)
    load_or_refuse(folder / "7_01.amc")


@settings(max_examples=200)
@given(mutated(made.AMC))
def test_amc(folder, data):
    (folder / "8.asf").write_text(made.ASF)
    (folder / "8_01.amc").write_bytes(data)
    load_or_refuse(folder / "8_01.amc")


@settings(max_examples=50)
@given(st.binary(max_size=300), st.sampled_from([".bvh", ".amc"]))
def test_any_bytes(folder, data, suffix):
    (folder / "8.asf").write_text(made.ASF)
    (folder / f"8_02{suffix}").write_bytes(data)
    assert not load_or_refuse(folder / f"8_02{suffix}")


def test_the_unchanged_files_load(folder):
    for name, text in (("x.bvh", made.BVH), ("7.asf", made.ASF), ("7_01.amc", made.AMC)):
        (folder / name).write_text(text)
    assert load_or_refuse(folder / "x.bvh")
    assert load_or_refuse(folder / "7_01.amc")


HEAD = "HIERARCHY\nROOT a\n{\nOFFSET 0 1 0\n"
HUGE = {
    "braces": HEAD + "{" * 200_000,
    "closed braces": HEAD + "}" * 200_000,
    "end sites": HEAD
    + "CHANNELS 1 Xrotation\n"
    + "End Site { OFFSET 0 1 0 }\n" * 3_000
    + "}\nMOTION\nFrames: 1\nFrame Time: 1\n0\n",
    "joints": HEAD
    + "CHANNELS 1 Xrotation\n"
    + "".join(f"JOINT j{i} {{ OFFSET 0 1 0 }}\n" for i in range(3_000))
    + "}\nMOTION\nFrames: 1\nFrame Time: 1\n0\n",
    "a long name": f"HIERARCHY\nROOT {'x ' * 50_000}",
    "a long number": HEAD + "}\nMOTION\nFrames: 1\nFrame Time: " + "1" * 1_000_000,
    "a long value": HEAD
    + "CHANNELS 1 Xrotation\n}\nMOTION\nFrames: 20000\nFrame Time: 1\n"
    + "1" * 1_000_000
    + "\n0" * 19_999,
    "blank lines": HEAD + "\n" * 1_000_000,
    "carriage returns": HEAD.replace("\n", "\r") + "\r" * 1_000_000,
}


@pytest.mark.parametrize("name", HUGE)
def test_large_files_take_work_of_their_size(folder, name):
    (folder / "huge.bvh").write_text(HUGE[name])
    result = attempt(folder / "huge.bvh")
    if name in ("end sites", "joints"):
        assert not isinstance(result, FileFormatError), result
        assert result[0].num_joints == 3_001
    else:
        assert isinstance(result, FileFormatError)


def test_rotations_of_any_size_stay_finite(folder):
    text = made.BVH.replace("5.0 10.0 15.0", "1e308 -1e308 1e-320")
    (folder / "x.bvh").write_text(text)
    assert load_or_refuse(folder / "x.bvh")
