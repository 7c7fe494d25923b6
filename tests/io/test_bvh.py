from __future__ import annotations

import itertools
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mgjax.core.errors import ConfigError, MotionError, OutputError, SkeletonError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion
from mgjax.core.skeleton import MAX_DEPTH, Skeleton
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import read_capture
from mgjax.io.reading.read_as import ReadAs
from tests.conftest import make_motion, make_skeleton
from tests.io import made
from tests.reference import kinematics as reference


def read_file(path: Path, **options):
    """Skeleton, motion and unit of a file."""
    capture = read_capture(path, ReadAs(**options))
    return capture.skeleton, capture.motion, capture.unit


@pytest.fixture
def read(tmp_path):
    """Reads a text as a BVH file."""

    def run(text: str | bytes, **options):
        file = tmp_path / "made.bvh"
        file.write_bytes(text.encode() if isinstance(text, str) else text)
        return read_file(file, **options)

    return run


def assert_same(a, b) -> None:
    assert a[0].names == b[0].names
    np.testing.assert_array_equal(a[0].offsets, b[0].offsets)
    np.testing.assert_array_equal(a[1].root_translation, b[1].root_translation)
    np.testing.assert_array_equal(a[1].local_rotations, b[1].local_rotations)


# --- worked by hand -------------------------------------------------------------------------


def test_the_made_file(read):
    skeleton, motion, unit = read(made.BVH)
    assert skeleton.names == (
        "Hips", "Chest", "Chest_end", "LeftUpLeg", "LeftFoot", "LeftFoot_end"
    )  # fmt: skip
    assert skeleton.parents == (-1, 0, 1, 0, 3, 4)
    assert skeleton.end_joints == (2, 5)
    assert unit.name == "centimetre"  # 175 units tall
    assert motion.frame_rate == 120
    assert motion.num_frames == 3
    np.testing.assert_allclose(skeleton.offsets[5], [0, -0.05, 0.12], atol=1e-7)
    np.testing.assert_allclose(motion.root_translation[2], [0.02, 0.92, 0.04], atol=1e-7)
    # Frame 2: the root is turned by Rz(90°)·Ry(45°)·Rx(30°). The chest lies on +y:
    # Rx: (0, cos 30°, sin 30°) = (0, .8660, .5); Ry: (.5 sin 45°, .8660, .5 cos 45°) =
    # (.3536, .8660, .3536); Rz: (−.8660, .3536, .3536); times 0.6 m.
    places = global_positions(skeleton, motion)
    np.testing.assert_allclose(places[2, 1] - places[2, 0], [-0.5196, 0.2121, 0.2121], atol=1e-4)


# --- channels -------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ["".join(p) for p in itertools.permutations("XYZ")])
def test_every_rotation_order(read, order):
    channels = " ".join(f"{letter}rotation" for letter in order)
    text = made.BVH.replace("Zrotation Yrotation Xrotation", channels)
    _, motion, _ = read(text)
    want = reference.euler(np.deg2rad([10.0, 20, 30]), order)  # chest, frame 2: see made.py
    np.testing.assert_allclose(
        reference.matrix(motion.local_rotations[2, 3]), want, atol=1e-6, err_msg=order
    )


def reference_positions(rows: list[dict], values: np.ndarray, metres: float) -> np.ndarray:
    """[F,J,3] in the order of ``rows``, by matrices; position channels replace the offset."""
    result = np.zeros((len(values), len(rows), 3))
    for f, row_values in enumerate(values):
        column, turns = 0, {}
        for j in made.depth_first(rows):
            place, turn = np.array(rows[j]["offset"], float), np.eye(3)
            for channel in rows[j]["channels"].split():
                value = row_values[column]
                column += 1
                if channel.endswith("position"):
                    place["XYZ".index(channel[0])] = value
                else:
                    turn = turn @ reference.axis_rotation(channel[0], np.deg2rad(value))
            parent = rows[j]["parent"]
            if parent >= 0:
                place = result[f, parent] / metres + turns[parent] @ place
                turn = turns[parent] @ turn
            turns[j] = turn
            result[f, j] = place * metres
    return result


@given(st.integers(0, 10**6), st.integers(2, 14))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_hierarchy_with_any_channels(tmp_path, seed, joints):
    rng = np.random.default_rng(seed)
    rows = made.random_hierarchy(rng, joints, 1.0)
    values = rng.uniform(-1, 1, (3, sum(len(r["channels"].split()) for r in rows)))
    # Angles up to 180°, places up to 1 m.
    columns = [c for j in made.depth_first(rows) for c in rows[j]["channels"].split()]
    values *= np.where([c.endswith("rotation") for c in columns], 180.0, 1.0)
    file = tmp_path / "random.bvh"
    file.write_text(made.bvh_text(rows, values))
    skeleton, motion, _ = read_file(file, units="m")
    want = reference_positions(rows, values, 1.0)
    got = global_positions(skeleton, motion)
    for j, row in enumerate(rows):
        np.testing.assert_allclose(got[:, skeleton.index(row["name"])], want[:, j], atol=1e-5)
    save_bvh(tmp_path / "again.bvh", skeleton, motion)
    skeleton, motion, _ = read_file(tmp_path / "again.bvh", units="cm")
    got = global_positions(skeleton, motion)
    for j, row in enumerate(rows):
        np.testing.assert_allclose(got[:, skeleton.index(row["name"])], want[:, j], atol=1e-4)


def test_position_channels_replace_the_offset(read):
    text = made.BVH.replace(
        "OFFSET 0.0 60.0 0.0\n    CHANNELS 3 Z", "OFFSET 0.0 60.0 0.0\n    CHANNELS 4 Yposition Z"
    )
    head, rows = text.split("0.0083333\n")
    numbers = [r.split() for r in rows.strip().split("\n")]
    still = [" ".join([*r[:6], "40.0", *r[6:]]) for r in numbers]
    skeleton, motion, _ = read(f"{head}0.0083333\n" + "\n".join(still))
    np.testing.assert_allclose(skeleton.offsets[1], [0, 0.4, 0], atol=1e-7)
    assert motion.joint_offsets is None
    moving = [" ".join([*r[:6], f"{40 + i}.0", *r[6:]]) for i, r in enumerate(numbers)]
    skeleton, motion, _ = read(f"{head}0.0083333\n" + "\n".join(moving))
    np.testing.assert_allclose(motion.joint_offsets[:, 1, 1], [0.4, 0.41, 0.42], atol=1e-6)
    np.testing.assert_allclose(skeleton.offsets[1], [0, 0.6, 0], atol=1e-7)  # the file's own
    places = global_positions(skeleton, motion)
    lengths = np.linalg.norm(places[:, 1] - places[:, 0], axis=-1)
    np.testing.assert_allclose(lengths, [0.4, 0.41, 0.42], atol=1e-6)


def test_the_offset_of_the_root_is_replaced_too(read):
    text = made.BVH.replace("OFFSET 0.0 0.0 0.0\n", "OFFSET 3.0 4.0 5.0\n", 1)
    np.testing.assert_allclose(read(text)[1].root_translation, read(made.BVH)[1].root_translation)
    without = text.replace("CHANNELS 6 Xposition Yposition Zposition Z", "CHANNELS 3 Z")
    head, rows = without.split("0.0083333\n")
    short = [" ".join(r.split()[3:]) for r in rows.strip().split("\n")]
    _, motion, _ = read(f"{head}0.0083333\n" + "\n".join(short))
    np.testing.assert_allclose(motion.root_translation, [[0.03, 0.04, 0.05]] * 3, atol=1e-7)


def test_a_joint_may_move_far_from_its_parent(read):
    # A root that stands still and hips that walk away, as some programs export.
    text = made.BVH.replace("CHANNELS 3 Z", "CHANNELS 6 Xposition Yposition Zposition Z", 1)
    head, rows = text.split("0.0083333\n")
    far = [
        " ".join([*r.split()[:6], f"{1500 + 100 * i}", "60", "0", *r.split()[6:]])
        for i, r in enumerate(rows.strip().split("\n"))
    ]
    skeleton, motion, _ = read(f"{head}0.0083333\n" + "\n".join(far))
    assert motion.joint_offsets[2, 1, 0] == pytest.approx(17)
    np.testing.assert_allclose(skeleton.offsets[1], [0, 0.6, 0], atol=1e-7)


# --- ways to write the same -----------------------------------------------------------------

SAME = {
    "crlf": lambda s: s.replace("\n", "\r\n"),
    "cr": lambda s: s.replace("\n", "\r"),
    "tabs": lambda s: s.replace(" ", "\t"),
    "no indent": lambda s: re.sub(r"(?m)^ +", "", s),
    "lower case": lambda s: re.sub(
        r"HIERARCHY|ROOT|JOINT|OFFSET|CHANNELS|MOTION"
        r"|End Site|Frames|Frame Time|\wrotation|\wposition",
        lambda m: m[0].lower(),
        s,
    ),
    "upper case": lambda s: re.sub(
        r"End Site|Frames|Frame Time|\wrotation|\wposition", lambda m: m[0].upper(), s
    ),
    "blank lines": lambda s: s.replace("\n", "\n\n \t\n"),
    "braces on the line": lambda s: re.sub(r"\n\s*\{\s*\n", " {\n", s),
    "all braces together": lambda s: re.sub(r"\}\s+\}", "}}", s),
    "trailing blanks": lambda s: s.replace("\n", "  \n") + "\n\n  ",
    "no last line end": lambda s: s.rstrip(),
    "byte order mark": lambda s: "\ufeff" + s,
    "wrapped rows": lambda s: re.sub(r"(?m)^((?:-?[\d.]+ ){5})", r"\1\n", s),
    "one number a line": lambda s: (
        s[: s.index("0083333\n")] + "0083333\n" + "\n".join(s[s.index("0083333\n") + 8 :].split())
    ),
    "all rows in one": lambda s: (
        s[: s.index("0083333\n")] + "0083333\n" + " ".join(s[s.index("0083333\n") + 8 :].split())
    ),
    "exponents": lambda s: s.replace(" 60.0 ", " 6.0e+01 ").replace(" 30.0", " 0.3E2"),
    "signs and bare points": lambda s: s.replace(" 60.0 ", " +60. ").replace("0.0 90.0", ".0 90"),
    "spaces in the header": lambda s: s.replace("Frames: 3", "Frames :3").replace(
        "Time: ", "Time:"
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_ways_to_write_the_same(read, name):
    text = SAME[name](made.BVH)
    assert text != made.BVH
    assert_same(read(text), read(made.BVH))


def test_latin_1_names(read):
    skeleton = read(made.BVH.replace("Chest", "Rücken").encode("latin-1"))[0]
    assert skeleton.names[1] == "Rücken"
    assert read(made.BVH.replace("Chest", "Rücken"))[0].names[1] == "Rücken"
    assert read(made.BVH.replace("Chest", "upper back"))[0].names[1] == "upper back"


def test_several_end_sites_and_names_they_would_take(read):
    end = "End Site\n{\nOFFSET 0 {} 0\n}\n"
    ends = "".join(end.replace("{}", str(n)) for n in (10, 20, 30))
    text = made.BVH.replace("    End Site\n    {\n      OFFSET 0.0 30.0 0.0\n    }\n", ends, 1)
    skeleton = read(text)[0]
    assert skeleton.names[1:5] == ("Chest", "Chest_end", "Chest_end2", "Chest_end3")
    np.testing.assert_allclose(skeleton.offsets[2:5, 1], [0.1, 0.2, 0.3], atol=1e-7)
    # A joint further down has the name that the end site would get.
    skeleton = read(made.BVH.replace("LeftUpLeg", "Chest_end"))[0]
    assert skeleton.names[1:4] == ("Chest", "Chest_end2", "Chest_end")


def test_joints_without_channels_or_end_site(read):
    text = made.BVH.replace("CHANNELS 3 Zrotation Yrotation Xrotation", "CHANNELS 0", 1)
    head, rows = text.split("0.0083333\n")
    short = "\n".join(" ".join(r.split()[:6] + r.split()[9:]) for r in rows.strip().split("\n"))
    skeleton, motion, _ = read(f"{head}0.0083333\n{short}")
    np.testing.assert_array_equal(motion.local_rotations[:, 1], [[1, 0, 0, 0]] * 3)
    no_word = f"{head}0.0083333\n{short}".replace("    CHANNELS 0\n", "")
    assert_same(read(no_word), (skeleton, motion))
    bare = re.sub(r"End Site\s+\{[^}]*\}", "", made.BVH)
    assert read(bare)[0].end_joints == ()


def test_deep_and_wide(read, tmp_path):
    def chain(depth: int) -> str:
        rows = [
            {"name": f"j{j}", "parent": j - 1, "offset": [0, 0.01, 0], "channels": "Xrotation"}
            for j in range(depth)
        ]
        return made.bvh_text(rows, np.ones((2, depth)))

    skeleton, motion, _ = read(chain(MAX_DEPTH - 1))
    assert skeleton.num_joints == MAX_DEPTH
    save_bvh(tmp_path / "deep.bvh", skeleton, motion)
    again = read_file(tmp_path / "deep.bvh", units="cm")
    np.testing.assert_allclose(
        global_positions(*again[:2]), global_positions(skeleton, motion), atol=1e-4
    )
    rows = [{"name": "j0", "parent": -1, "offset": [0, 0, 0], "channels": "Xrotation"}]
    for j in range(1, 2000):
        rows.append({"name": f"j{j}", "parent": 0, "offset": [0, 1, 0], "channels": "Yrotation"})
    assert read(made.bvh_text(rows, np.ones((2, 2000))))[0].num_joints == 3999


# --- rate and unit --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        (".0083333", 120),
        ("0.008333", 120),
        ("8.3333e-3", 120),
        ("0.033333", 30),
        ("0.0333", 30),
        ("0.033", 30),
        ("0.03", 30),  # of the whole rates that print as 0.03 a common one
        ("0.0417", 24),  # 1/24 = 0.041667 prints as 0.0417
        ("4.17e-2", 24),
        ("0.0416667", 24),
        ("0.04", 25),
        ("0.02", 50),
        ("0.017", 60),
        ("0.0167", 60),
        ("0.01", 100),
        ("1", 1),
        ("0.03000000", 1 / 0.03),
        ("0.0334", 1 / 0.0334),  # 1/30 would print as 0.0333
        ("0.033367", 1 / 0.033367),  # 29.97
        ("0.0123457", 81),  # 1/81 = 0.01234568
    ],
)
def test_frame_time_becomes_the_rate_that_it_was_rounded_from(read, text, rate):
    assert read(made.BVH.replace("0.0083333", text))[1].frame_rate == pytest.approx(rate, rel=1e-9)


def test_the_rate_can_be_given(read):
    motion = read(made.BVH, frame_rate=25)[1]
    assert (motion.frame_rate, motion.num_frames) == (25.0, 3)


@pytest.mark.parametrize(("name", "metres"), [("m", 1), ("cm", 0.01), ("cmu", 0.0254 / 0.45)])
def test_the_unit_is_found_by_the_height(read, name, metres):
    def scaled(match: re.Match) -> str:
        return "OFFSET " + " ".join(str(float(v) * 0.01 / metres) for v in match[1].split())

    text = re.sub(r"OFFSET ([^\n]*)", scaled, made.BVH)
    skeleton, _, unit = read(text)
    assert unit.metres == pytest.approx(metres)
    np.testing.assert_allclose(skeleton.offsets, read(made.BVH)[0].offsets, atol=1e-6)
    small = read(made.BVH, units=name)[0] if name != "m" else None
    if small is not None:
        assert small.offsets[1, 1] == pytest.approx(60 * metres)


def test_a_wrong_unit_is_refused(read):
    with pytest.raises(ConfigError, match="'inch', expected one of m, cm, mm, dm, in, ft, cmu"):
        read(made.BVH, units="inch")


# --- writing --------------------------------------------------------------------------------


@given(st.integers(0, 10**6), st.sampled_from([24.0, 29.97, 30.0, 59.94, 60.0, 120.0, 1 / 0.0417]))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_is_written_reads_back(tmp_path, seed, rate):
    body = make_skeleton()
    motion = make_motion(body, 4, seed=seed, frame_rate=rate)
    save_bvh(tmp_path / "out.bvh", body, motion)
    skeleton, again, unit = read_file(tmp_path / "out.bvh")
    assert unit.name == "centimetre"
    assert again.frame_rate == pytest.approx(rate, rel=1e-6)
    assert again.joint_offsets is None
    want, got = global_positions(body, motion), global_positions(skeleton, again)
    for joint, name in enumerate(body.names):
        np.testing.assert_allclose(got[:, skeleton.index(name)], want[:, joint], atol=1e-4)


@pytest.mark.parametrize("gap", [0, 1e-7, 1e-5, 1e-4, 4e-4, 1e-3])
@pytest.mark.parametrize("sign", [1, -1])
def test_writing_near_gimbal_lock(tmp_path, gap, sign):
    body = make_skeleton()
    motion = make_motion(body, 20)
    rng = np.random.default_rng(3)
    rotations = motion.local_rotations.copy()
    for f, j in itertools.product(range(20), range(body.num_joints)):
        if j not in body.end_joints:
            a, b = rng.uniform(-np.pi, np.pi, 2)
            half = [(a / 2, 3), (sign * (np.pi / 2 - gap) / 2, 2), (b / 2, 1)]
            q = np.array([1.0, 0, 0, 0])
            for angle, axis in half:
                part = np.zeros(4)
                part[0], part[axis] = np.cos(angle), np.sin(angle)
                q = hamilton(q, part)
            rotations[f, j] = q
    motion = replace(motion, local_rotations=rotations)
    save_bvh(tmp_path / "out.bvh", body, motion)
    skeleton, again, _ = read_file(tmp_path / "out.bvh")
    want, got = global_positions(body, motion), global_positions(skeleton, again)
    for joint, name in enumerate(body.names):
        np.testing.assert_allclose(got[:, skeleton.index(name)], want[:, joint], atol=1e-4)


def hamilton(a, b) -> np.ndarray:
    """Product by the rule (s, u)(t, v) = (st − u·v, sv + tu + u × v)."""
    return np.array(
        [a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))]
    )


def test_moving_offsets_are_written(tmp_path, body, random_motion):
    offsets = np.tile(body.offsets, (4, 1, 1))
    offsets[:, 4, 1] += np.arange(4) * 0.01
    offsets[:, body.end_joints[0]] = [0.5, 0.1, 0]  # not what the skeleton says, but fixed
    motion = replace(random_motion(body, 4), joint_offsets=offsets)
    save_bvh(tmp_path / "out.bvh", body, motion)
    skeleton, again, _ = read_file(tmp_path / "out.bvh")
    want, got = global_positions(body, motion), global_positions(skeleton, again)
    for joint, name in enumerate(body.names):
        np.testing.assert_allclose(got[:, skeleton.index(name)], want[:, joint], atol=1e-4)
    offsets[:, body.end_joints[0], 0] += np.arange(4)
    with pytest.raises(MotionError, match="end joint moves"):
        save_bvh(tmp_path / "no.bvh", body, replace(motion, joint_offsets=offsets))
    assert not (tmp_path / "no.bvh").exists()


def test_the_root_offset_is_no_bone(tmp_path, body, random_motion):
    offsets = body.offsets.copy()
    offsets[0] = 0.1, 0.2, 0.3
    moved = replace(body, offsets=offsets)
    motion = random_motion(body, 2)
    save_bvh(tmp_path / "out.bvh", moved, motion)
    skeleton, again, _ = read_file(tmp_path / "out.bvh")
    np.testing.assert_array_equal(skeleton.offsets[0], 0)
    np.testing.assert_allclose(again.root_translation, motion.root_translation, atol=1e-6)


def test_what_cannot_be_written(tmp_path, body, random_motion):
    motion = random_motion(body, 2)
    out = tmp_path / "out.bvh"
    broken = motion.local_rotations.copy()
    broken[1, 1] = np.nan
    with pytest.raises(MotionError, match="not finite in frame 1"):
        save_bvh(out, body, replace(motion, local_rotations=broken))
    for name in ("a{b", "two\nlines", "", "a  b"):
        with pytest.raises(SkeletonError, match="joint name"):
            save_bvh(out, replace(body, names=(name, *body.names[1:])), motion)
    depth = 2000
    chain = Skeleton(
        names=tuple(f"j{j}" for j in range(depth)),
        parents=(-1, *range(depth - 1)),
        offsets=np.full((depth, 3), 0.001, np.float32),
    )
    still = Motion(
        root_translation=np.zeros((1, 3), np.float32),
        local_rotations=np.tile(np.array([1, 0, 0, 0], np.float32), (1, depth, 1)),
        frame_rate=30.0,
    )
    with pytest.raises(SkeletonError, match="256 deep"):
        save_bvh(out, chain, still)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", ["", ".", "missing/out.bvh", "nul\0byte.bvh", "x" * 300 + ".bvh"])
def test_places_that_cannot_be_written(tmp_path, monkeypatch, body, random_motion, path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OutputError, match="cannot be written") as error:
        save_bvh(path, body, random_motion(body, 2))
    assert "\n" not in str(error.value)
    assert list(Path().iterdir()) == []


def test_a_failed_write_leaves_what_was_there(tmp_path, body, random_motion):
    out = tmp_path / "out.bvh"
    out.mkdir()
    (out / "kept").write_text("kept")
    with pytest.raises(OutputError):
        save_bvh(out, body, random_motion(body, 2))
    assert [p.name for p in tmp_path.iterdir()] == ["out.bvh"]
    assert (out / "kept").read_text() == "kept"
