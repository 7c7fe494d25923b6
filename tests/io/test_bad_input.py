"""What is wrong with a file is said in one line: file, line, what stands there, what should."""

from __future__ import annotations

import re

import pytest

from mgjax.core.errors import ConfigError, FileFormatError, MgjaxError
from mgjax.io.load import load_motion
from tests.io import made

LONG = "A" * 100_000


def refused(path, line: int | None, got: str, expected: str = "", **options) -> FileFormatError:
    """Loads a file that must be refused, and checks the message."""
    with pytest.raises(FileFormatError) as caught:
        load_motion(path, **options)
    error = caught.value
    text = str(error)
    assert isinstance(error, MgjaxError)
    assert isinstance(error, ValueError)
    assert text.splitlines() == [text], "one line"
    assert len(text) < 500
    assert text.isprintable()
    assert error.line == line, text
    shown = str(error.path).replace("\0", "\\x00").replace("\n", "\\n")
    place = f"{shown}:{line}: " if line is not None else f"{shown}: "
    assert text == f"{place}got {error.got}, expected {error.expected}"
    assert got in error.got, text
    assert expected in error.expected, text
    return error


@pytest.fixture
def bvh(tmp_path):
    def run(data: str | bytes, line: int | None, got: str, expected: str = "", **options) -> None:
        path = tmp_path / "bad.bvh"
        path.write_bytes(data.encode() if isinstance(data, str) else data)
        assert refused(path, line, got, expected, **options).path == path

    return run


@pytest.fixture
def amc(tmp_path):
    """Writes an ASF and an AMC text; the error must be about the one that differs."""

    def run(line: int | None, got: str, expected: str = "", *, asf=None, amc=None) -> None:
        (tmp_path / "7.asf").write_bytes((asf or made.ASF).encode())
        (tmp_path / "7_01.amc").write_bytes((amc or made.AMC).encode())
        error = refused(tmp_path / "7_01.amc", line, got, expected)
        assert error.path.name == ("7.asf" if asf else "7_01.amc")

    return run


def changed(text: str, old: str, new: str, count: int = 1) -> str:
    assert old in text, old
    return text.replace(old, new, count)


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


# --- not even a file of numbers -------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".bvh", ".amc"])
def test_no_file_a_folder_empty_and_binary(tmp_path, suffix):
    (tmp_path / "7.asf").write_text(made.ASF)
    path = tmp_path / f"7_01{suffix}"
    refused(path, None, "no such file", "a readable")
    path.mkdir()
    refused(path, None, "is a directory", "a readable")
    path.rmdir()
    for data, got in (
        (b"", "an empty file"),
        (b" \r\n\t\n", "an empty file"),
        (b"\0\1\2\3", "binary data"),
        (made.BVH.encode("utf-16"), "binary data"),
    ):
        path.write_bytes(data)
        refused(path, None, got)
    path.write_bytes(bytes(range(128, 256)) * 20)
    refused(path, 1, "'", "HIERARCHY" if suffix == ".bvh" else "frame 1")
    refused(f"nul\0byte{suffix}", None, "null byte", "a readable")
    refused(f"new\nline{suffix}", None, "no such file", "a readable")
    refused(f"{'x' * 300}{suffix}", None, "file name too long", "a readable")


def test_other_types(tmp_path):
    refused(tmp_path / "scene.fbx", None, "a file of type '.fbx'", ".bvh, .amc")
    refused(tmp_path / "scene", None, "a file of type ''", ".bvh, .amc")


@pytest.mark.parametrize("rate", [0, -1, float("nan"), float("inf"), 1e9])
def test_rates_out_of_range(tmp_path, rate):
    with pytest.raises(ConfigError, match="frame rate"):
        load_motion(tmp_path / "x.bvh", frame_rate=rate)


# --- BVH ------------------------------------------------------------------------------------

HEAD, _, ROWS = made.BVH.partition("0.0083333\n")
HEAD += "0.0083333\n"
LINES = made.BVH.count("\n")
MOTION = line_of(made.BVH, "MOTION")
FRAMES, TIME = MOTION + 1, MOTION + 2
FIRST = HEAD.count("\n") + 1  # line of the first row

BVH_CASES = {
    # name: (old, new, line, got, expected)
    "nothing before MOTION": (
        "HIERARCHY\n",
        "MOTION\n",
        1,
        "the end of the hierarchy",
        "HIERARCHY",
    ),
    "no header": ("HIERARCHY\n", "", 1, "'ROOT'", "HIERARCHY"),
    "two roots": (
        "MOTION",
        "ROOT Other\n{\nOFFSET 0 0 0\n}\nMOTION",
        MOTION,
        "'ROOT'",
        "single ROOT",
    ),
    "no name": ("JOINT Chest", "JOINT", 6, "no name", "JOINT and a name"),
    "duplicate name": (
        "LeftFoot",
        "Chest",
        19,
        "a second joint called 'Chest' (the first is in line 6)",
        "unique",
    ),
    "unknown word": ("OFFSET 0.0 60.0", "PLACE 0.0 60.0", 8, "'PLACE'", "OFFSET, CHANNELS"),
    "offset of words": ("0.0 60.0 0.0", "0.0 tall 0.0", 8, "'tall'", "a number for OFFSET"),
    "offset too short": ("0.0 60.0 0.0", "0.0 60.0", 9, "'CHANNELS'", "a number for OFFSET"),
    "no offset": ("    OFFSET 0.0 60.0 0.0\n", "", 13, "no OFFSET for 'Chest'", "OFFSET"),
    "offset nan": ("0.0 60.0 0.0", "0.0 nan 0.0", 8, "'nan'", "a finite number"),
    "offset infinite": ("0.0 60.0 0.0", "0.0 -inf 0.0", 8, "'-inf'", "a finite number"),
    "offset overflows": ("0.0 60.0 0.0", "0.0 1e999 0.0", 8, "'1e999'", "a finite number"),
    "offset over 10 m": ("0.0 60.0 0.0", "0.0 1001.0 0.0", 8, "'Chest'", "at most 10 m"),
    "offset enormous": ("0.0 60.0 0.0", "0.0 1e308 0.0", 8, "'Chest'", "at most 10 m"),
    "underscored": ("0.0 60.0 0.0", "0.0 6_0.0 0.0", 8, "'6_0.0'", "a number"),
    "other digits": ("0.0 60.0 0.0", "0.0 ٦٠ 0.0", 8, r"'\u0666\u0660'", "a number"),
    "channels no number": ("CHANNELS 6", "CHANNELS many", 5, "'many'", "0 … 6 channels"),
    "channels superscript": ("CHANNELS 6", "CHANNELS ²", 5, "'\\xb2'", "0 … 6 channels"),
    "channels 7": ("CHANNELS 6", "CHANNELS 7", 5, "'7'", "0 … 6 channels"),
    "channels 10^5000": ("CHANNELS 6", "CHANNELS " + "9" * 5000, 5, "'9999", "0 … 6 channels"),
    "channels missing": ("CHANNELS 3", "CHANNELS 4", 10, "'End'", "Xposition"),
    "channel unknown": ("Zrotation", "Wrotation", 5, "'Wrotation'", "Xposition … Zrotation"),
    "channel twice": ("Yposition", "Xposition", 5, "the same position channel twice", "once"),
    "end site with channels": (
        "OFFSET 0.0 30.0 0.0",
        "OFFSET 0.0 30.0 0.0\nCHANNELS 1 Xrotation",
        13,
        "channels of an End Site",
        "",
    ),
    "end site with a joint": (
        "OFFSET 0.0 30.0 0.0",
        "OFFSET 0.0 30.0 0.0\nJOINT x {",
        13,
        "JOINT in an End Site",
        "",
    ),
    "brace missing": (
        "    }\n  }\n  JOINT",
        "    }\n  JOINT",
        MOTION - 2,
        "the end of the hierarchy",
        "}",
    ),
    "brace too many": ("MOTION", "}\nMOTION", MOTION, "'}'", "MOTION after a single ROOT"),
    "no MOTION": ("MOTION", "", FRAMES, "'Frames:'", "MOTION after a single ROOT"),
    "frames no number": ("Frames: 3", "Frames: many", FRAMES, "'many'", "a number of frames"),
    "frames zero": ("Frames: 3", "Frames: 0", FRAMES, "'0'", "1 or more"),
    "frames negative": ("Frames: 3", "Frames: -3", FRAMES, "'-3'", "1 or more"),
    "frames superscript": ("Frames: 3", "Frames: ³", FRAMES, "'\\xb3'", "1 or more"),
    "frames missing": ("Frames: 3\n", "", FRAMES, "'Frame Time: 0.0083333'", "Frames:"),
    "frames 10^5000": ("Frames: 3", "Frames: " + "9" * 5000, FRAMES, "'9999", "a number of frames"),
    "time missing": ("Frame Time: 0.0083333\n", "", TIME, "'0.0 90.0 0.0 0.0", "Frame Time:"),
    "time no number": (
        "Frame Time: 0.0083333",
        "Frame Time: fast",
        TIME,
        "'fast'",
        "the frame time",
    ),
    "time zero": ("Frame Time: 0.0083333", "Frame Time: 0", TIME, "'0'", "0.0001 … 10 seconds"),
    "time negative": ("Frame Time: 0.0083333", "Frame Time: -1", TIME, "'-1'", "0.0001 … 10"),
    "time underflows": ("Frame Time: 0.0083333", "Frame Time: 1e-999", TIME, "'1e-999'", "0.0001"),
    "time infinite": ("Frame Time: 0.0083333", "Frame Time: inf", TIME, "'inf'", "a finite number"),
    "time long": ("Frame Time: 0.0083333", "Frame Time: " + LONG, TIME, "'AAAA", "a number"),
    "value a word": ("1.0 91.0", "1.0 up", FIRST + 1, "'up'", "a number for a channel"),
    "value nan": ("1.0 91.0", "1.0 NaN", FIRST + 1, "'NaN'", "a finite number"),
    "value infinite": ("1.0 91.0", "1.0 Infinity", FIRST + 1, "'Infinity'", "a finite number"),
    "value underscored": ("1.0 91.0", "1.0 9_1", FIRST + 1, "'9_1'", "a number for a channel"),
    "value long": ("1.0 91.0", "1.0 " + LONG, FIRST + 1, "'AAAA", "a number for a channel"),
    "value missing": ("1.0 91.0", "1.0", FIRST + 1, "14 values", "15 in each row"),
    "value too many": ("1.0 91.0", "1.0 91.0 5.0", FIRST + 1, "16 values", "15 in each row"),
    "place enormous": ("1.0 91.0", "1.0 1e308", None, "a position of 1e+308 in frame 1", "1e+06 m"),
    "place far": ("1.0 91.0", "1.0 2e8", None, "a position of 2e+08 in frame 1", "at most 1e+06 m"),
}


@pytest.mark.parametrize("name", BVH_CASES)
def test_bvh(bvh, name):
    old, new, line, got, expected = BVH_CASES[name]
    bvh(changed(made.BVH, old, new), line, got, expected)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.25, 0.5, 0.62, 0.65, 0.67, 0.7, 0.8, 0.95])
def test_truncated_bvh(tmp_path, share):
    path = tmp_path / "bad.bvh"
    text = made.BVH[: int(len(made.BVH) * share)]
    path.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        load_motion(path)
    assert caught.value.line is not None
    assert caught.value.line <= text.count("\n") + 1


def test_bvh_with_nothing_to_move(bvh):
    text = re.sub(r" *CHANNELS.*\n", "", HEAD)
    many = text.replace("Frames: 3", "Frames: 999999999999")
    bvh(many, line_of(text, "MOTION"), "without channels", "CHANNELS")
    bvh(text, line_of(text, "MOTION"), "without channels", "CHANNELS")


def test_bvh_that_is_too_deep_or_too_large(bvh):
    bvh("HIERARCHY\nROOT a\n" + "{" * 100_000, 3, "'{'", "JOINT, End Site")
    deep = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\n"
    deep += "".join(f"JOINT j{i}\n{{\nOFFSET 0 0 0\n" for i in range(100_000))
    bvh(deep, 5 + 255 * 3, "joints nested 256 deep", "a skeleton")
    # One channel, many frames, many joints: 5,000 × 60,000 poses would need gigabytes.
    wide = "HIERARCHY\nROOT a\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n"
    wide += "".join(f"JOINT j{i} {{ OFFSET 0 1 0 }}\n" for i in range(5000))
    wide += "}\nMOTION\nFrames: 60000\nFrame Time: 0.01\n" + "0\n" * 60_000
    bvh(wide, None, "60000 frames of 5001 joints", "at most")


def test_bvh_with_an_offset_too_long_in_the_given_unit(bvh):
    bvh(
        made.BVH, 26 - 1 - 10, "75 m", "the unit was taken to be the metre", units="m"
    ) if False else None
    bvh(made.BVH, line_of(made.BVH, "OFFSET 0.0 60.0"), "60 m for 'Chest'", "metre", units="m")


def test_bvh_with_a_moved_joint_that_stays_too_far_away(bvh):
    text = made.BVH.replace("CHANNELS 3 Z", "CHANNELS 4 Xposition Z", 1)
    head, rows = text.split("0.0083333\n")
    rows = [" ".join([*r.split()[:6], "2000", *r.split()[6:]]) for r in rows.strip().split("\n")]
    bvh(f"{head}0.0083333\n" + "\n".join(rows), 8, "20 m for 'Chest'", "at most 10 m")


def test_bvh_names_that_would_break_a_message(bvh):
    for name in ("\x1b[31mred", LONG, "two\u2028lines", "tab\x0bbed"):
        text = made.BVH.replace("JOINT Chest", f"JOINT {name}").replace("LeftFoot", name)
        bvh(text, 19, "a second joint called", "unique")
        bvh(made.BVH.replace("OFFSET 0.0 60.0", f"{name} 0 60"), 8, "", "JOINT, End Site")


# --- ASF and AMC ----------------------------------------------------------------------------


def test_no_or_several_asf(tmp_path):
    path = tmp_path / "7_01.amc"
    path.write_text(made.AMC)
    refused(path, None, "none beside it", "7.asf or a single .asf file")
    (tmp_path / "a.asf").write_text(made.ASF)
    (tmp_path / "b.asf").write_text(made.ASF)
    refused(path, None, "a.asf, b.asf beside it", "7.asf or a single .asf file")


AMC_CASES = {
    "no frame": (made.AMC[made.AMC.index("1\n") :], "", None, "no frame", "at least one"),
    "unknown bone": ("ltibia 40", "rtibia 40", 7, "'rtibia'", "a bone of 7.asf"),
    "bone before the first frame": (":DEGREES\n1\n", ":DEGREES\n", 4, "'root'", "frame 1"),
    "too few values": ("lfemur 10 20 30", "lfemur 10 20", 6, "2 values", "3 for 'lfemur'"),
    "too many values": ("ltibia 40", "ltibia 40 1", 7, "2 values", "1 for 'ltibia'"),
    "bone missing": ("ltibia 40\n", "", 8, "a frame without 'ltibia'", "all bones"),
    "bone missing at the end": ("back -40 50 60\n", "", 17, "a frame without 'back'", "all bones"),
    "bone twice": ("ltibia 40\n", "ltibia 40\nltibia 40\n", 8, "'ltibia' a second time", "once"),
    "frame number skipped": ("\n2\n", "\n5\n", 9, "frame 5", "frame 2"),
    "frame number repeated": ("\n2\n", "\n1\n", 9, "frame 1", "frame 2"),
    "frame number superscript": ("\n2\n", "\n²\n", 9, r"'\xb2'", "a frame number"),
    "frame number 10^5000": ("\n2\n", f"\n{'9' * 5000}\n", 9, "'9999", "a frame number"),
    "value a word": ("ltibia 40", "ltibia bent", 7, "'bent'", "a channel of 'ltibia'"),
    "value nan": ("ltibia 40", "ltibia nan", 7, "'nan'", "a finite number"),
    "value overflows": ("ltibia 40", "ltibia 1e999", 7, "'1e999'", "a finite number"),
    "value underscored": ("ltibia 40", "ltibia 4_0", 7, "'4_0'", "a number"),
    "value other digits": ("ltibia 40", "ltibia ٤٠", 7, r"'\u0664\u0660'", "a number"),
    "place enormous": ("root 2 17", "root 2 1e308", None, "root ty 1e+308 in frame 1", "1e+06 m"),
    "section in between": ("\n2\n", "\n:DEGREES\n2\n", 9, "':DEGREES'", "a frame number"),
}


@pytest.mark.parametrize("name", AMC_CASES)
def test_amc(amc, name):
    old, new, line, got, expected = AMC_CASES[name]
    amc(line, got, expected, amc=changed(made.AMC, old, new))


ASF_CASES = {
    # name: (old, new, part of the changed text that stands in the line meant, got, expected)
    "not an asf": (made.ASF, "hello\n", "hello", "'hello'", "a section"),
    "only comments": (made.ASF, "# hello\n", None, "nothing but comments", "an ASF"),
    "no root": (":root", ":toor", "\n    back head\n  end", "no section :root", "a whole ASF file"),
    "length no number": ("length 0.45", "length long", "length long", "'long'", "unit of length"),
    "length zero": ("length 0.45", "length 0", "length 0\n", "'0'", "0.0001"),
    "length tiny": ("length 0.45", "length 1e-300", "length 1e-300", "'1e-300'", "0.0001"),
    "length without value": ("length 0.45", "length", "length\n", "'length'", "a value after"),
    "angle": ("angle deg", "angle grad", "angle grad", "'grad'", "deg or rad"),
    "root order": ("order TX", "order LX", "order LX", "'lx'", "tx ty tz rx ry rz"),
    "root order twice": ("order TX TY", "order TX TX", "order TX TX", "'tx'", "at most once"),
    "root axis": ("axis XYZ", "axis XXZ", "axis XXZ", "'XXZ'", "an axis order"),
    "root far": ("position 0 0 0", "position 0 1e300 0", "position 0 1", "a root far away", ""),
    "root position short": ("position 0 0 0", "position 0 0", "position 0 0\n", "2 values", "3"),
    "no begin": ("  begin\n     id 1", "     id 1", "id 1", "'id'", "begin"),
    "no end": (
        "length 3\n     axis 0 0 0 XYZ\n  end",
        "length 3",
        "length 3\n",
        "a bone without end",
        "end",
    ),
    "no name": ("     name head\n", "", None, "", ""),
    "second name": (
        "name back",
        "name lfemur",
        "name lfemur\n     direction 0 1 0",
        "a second bone called 'lfemur'",
        "unique",
    ),
    "bone called root": ("name back", "name root", "name root", "a second bone called 'root'", ""),
    "direction short": ("direction 0 1 0\n", "direction 0 1\n", "direction 0 1\n", "2 values", "3"),
    "direction nan": ("direction 0 1 0\n", "direction 0 nan 0\n", "direction 0 nan", "'nan'", ""),
    "bone over 10 m": (
        "length 8",
        "length 178",
        "begin\n     id 3",
        "a bone of 10 m",
        "at most 10 m",
    ),
    "bone enormous": ("length 8", "length 1e308", "begin\n     id 3", "a bone of", "at most 10 m"),
    "axis without order": ("axis 10 20 30 XYZ", "axis 10 20 30", "axis 10 20 30\n", "'axis 10", ""),
    "axis order": ("axis 10 20 30 XYZ", "axis 10 20 30 XY", "axis 10 20 30 XY", "'XY'", "XYZ"),
    "dof": ("dof rx\n", "dof qx\n", "dof qx", "'qx'", "rx ry rz"),
    "dof that moves": ("dof rx\n", "dof tx\n", "dof tx", "moves away from its parent", "rx ry rz"),
    "child unknown": (
        "root lfemur",
        "root rfemur",
        "root rfemur",
        "'rfemur'",
        "a bone of :bonedata",
    ),
    "parent unknown": ("back head", "spine head", "spine head", "'spine'", "placed before"),
    "two parents": (
        "back head",
        "back head lfemur",
        "back head lfemur",
        "'lfemur' a second time",
        "one parent",
    ),
    "own parent": ("lfemur ltibia", "lfemur lfemur", "lfemur lfemur", "'lfemur' a second time", ""),
    "no parent": (
        "lfemur ltibia\n",
        "\n",
        "begin\n     id 2",
        "'ltibia' without a parent",
        ":hierarchy",
    ),
}


@pytest.mark.parametrize("name", ASF_CASES)
def test_asf(amc, name):
    old, new, part, got, expected = ASF_CASES[name]
    text = changed(made.ASF, old, new)
    if name == "no root":  # the section is missing: the end of the file
        line = text.count("\n")
    elif name == "no name":
        line, got, expected = line_of(text, "axis 0 0 0 XYZ") + 1, "a bone without a name", "name"
    else:
        line = None if part is None else line_of(text, part)
    amc(line, got, expected, asf=text)


def test_asf_that_is_too_deep(amc):
    bones = "".join(
        f"begin\nname b{i}\ndirection 0 1 0\nlength 0.1\naxis 0 0 0 XYZ\nend\n" for i in range(5000)
    )
    tree = "root b0\n" + "".join(f"b{i} b{i + 1}\n" for i in range(4999))
    head = made.ASF[: made.ASF.index(":bonedata")]
    text = f"{head}:bonedata\n{bones}:hierarchy\n{tree}"
    amc(line_of(text, "name b254\n") - 1, "bones nested 256 deep", "a skeleton", asf=text)
