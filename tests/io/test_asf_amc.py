from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mgjax.core.kinematics import global_positions
from mgjax.io.acclaim.amc import find_asf
from mgjax.io.acclaim.asf import read_asf
from mgjax.io.load import load_motion, read_capture
from tests.io import made
from tests.reference import asf_amc as reference


@pytest.fixture
def load(tmp_path):
    """Loads an ASF and an AMC text and compares them with the independent reader."""

    def run(asf: str = made.ASF, amc: str = made.AMC):
        (tmp_path / "7.asf").write_text(asf)
        (tmp_path / "7_01.amc").write_text(amc)
        skeleton, motion = load_motion(tmp_path / "7_01.amc")
        got = global_positions(skeleton, motion)
        want = reference.positions(tmp_path / "7.asf", tmp_path / "7_01.amc")
        for joint, name in enumerate(skeleton.names):
            np.testing.assert_allclose(got[:, joint], want[name], atol=1e-5, err_msg=name)
        return skeleton, motion

    return run


def test_the_made_file(load, tmp_path):
    skeleton, motion = load()
    assert skeleton.names == (
        "root", "lfemur", "ltibia", "back", "head", "ltibia_end", "head_end"
    )  # fmt: skip
    assert skeleton.parents == (-1, 0, 1, 0, 3, 2, 4)
    assert skeleton.end_joints == (5, 6)
    assert (motion.num_frames, motion.frame_rate) == (3, 120)
    # One unit is 0.0254/0.45 m = 0.05644 m; the root is 16 units up in frame 1.
    assert motion.root_translation[0, 1] == pytest.approx(16 * 0.0254 / 0.45)
    # The head begins where the back ends: 8 units up.
    np.testing.assert_allclose(skeleton.offsets[4], [0, 8 * 0.0254 / 0.45, 0], atol=1e-6)
    np.testing.assert_array_equal(skeleton.offsets[1], 0)
    unit = read_capture(tmp_path / "7_01.amc").unit
    assert "0.45" in unit.name
    assert unit.metres == pytest.approx(0.0254 / 0.45)


def test_a_quarter_turn_worked_by_hand(load):
    # The tibia has axis 0, a length of 1 inch unit and turns 90° about x: −y goes to −z.
    asf = made.ASF.replace("length 0.45", "length 1").replace(
        "direction 0.34 -0.94 0\n     length 7.3\n     axis 0 0 20",
        "direction 0 -1 0\n     length 10\n     axis 0 0 0",
    )
    frame = "1\nroot 0 0 0 0 0 0\nlfemur 0 0 0\nltibia 90\nback 0 0 0\n"
    skeleton, motion = load(asf, frame)
    places = global_positions(skeleton, motion)[0]
    shin = places[skeleton.index("ltibia_end")] - places[skeleton.index("ltibia")]
    np.testing.assert_allclose(shin, [0, 0, -0.254], atol=1e-6)


@pytest.mark.parametrize("order", ["".join(p) for p in itertools.permutations("XYZ")])
def test_every_axis_order(load, order):
    axes = made.ASF.replace("axis 10 20 30 XYZ", f"axis 10 20 30 {order}")
    load(axes)
    load(
        axes.replace("orientation 0 0 0", "orientation 20 30 40").replace(
            "axis XYZ", f"axis {order}"
        )
    )


@pytest.mark.parametrize(
    "dof", [" ".join(p) for n in (1, 2, 3) for p in itertools.permutations(("rx", "ry", "rz"), n)]
)
def test_every_order_and_number_of_dof(load, dof):
    asf = re.sub(r"(axis 10 20 30 XYZ\s+dof) rx ry rz", rf"\1 {dof}", made.ASF)
    assert asf != made.ASF or dof == "rx ry rz"
    count = len(dof.split())
    amc = re.sub(r"(?m)^back (.*)$", lambda m: "back " + " ".join(m[1].split()[:count]), made.AMC)
    load(asf, amc)


@pytest.mark.parametrize(
    "order", ["TX TY TZ RZ RY RX", "RX RY RZ TX TY TZ", "TZ TX RY RX", "RX", "TY"]
)
def test_every_root_order(load, order):
    count = len(order.split())
    asf = made.ASF.replace("order TX TY TZ RX RY RZ", f"order {order}")
    amc = re.sub(r"(?m)^root (.*)$", lambda m: "root " + " ".join(m[1].split()[:count]), made.AMC)
    load(asf.replace("position 0 0 0", "position 1 2 3"), amc)


@pytest.mark.parametrize("length", ["1.0", "0.45", "2.54e0"])
def test_units_of_length(load, length):
    skeleton, _ = load(made.ASF.replace("length 0.45", f"length {length}"))
    back = skeleton.offsets[skeleton.index("head"), 1]
    assert back == pytest.approx(8 * 0.0254 / float(length), rel=1e-6)


def test_radians(load):
    skeleton, motion = load()
    asf = made.ASF.replace("angle deg", "angle rad")
    asf = re.sub(
        r"axis (\d+) (\d+) (\d+) XYZ",
        lambda m: "axis " + " ".join(str(np.deg2rad(float(v))) for v in m.groups()) + " XYZ",
        asf,
    )
    amc = made.AMC.replace(":DEGREES", ":RADIANS")

    def turned(match: re.Match) -> str:
        numbers = match[2].split()
        fixed = 3 if match[1] == "root" else 0
        return " ".join(
            [
                match[1],
                *numbers[:fixed],
                *(repr(np.deg2rad(float(v)).item()) for v in numbers[fixed:]),
            ]
        )

    amc = re.sub(r"(?m)^([a-z]+) (.*)$", turned, amc)
    same, again = load(asf, amc)
    np.testing.assert_allclose(again.local_rotations, motion.local_rotations, atol=1e-6)
    np.testing.assert_allclose(same.offsets, skeleton.offsets)


SAME = {
    "crlf": lambda s: s.replace("\n", "\r\n"),
    "tabs": lambda s: re.sub(" +", "\t", s),
    "blank lines": lambda s: s.replace("\n", "\n\n"),
    "comments": lambda s: s.replace("\n", "  # a remark\n"),
    "comment lines": lambda s: s.replace("\n", "\n# begin end 1 2 3\n"),
    "no last line end": lambda s: s.rstrip(),
}


@pytest.mark.parametrize("name", SAME)
def test_ways_to_write_the_same(load, name):
    want_skeleton, want = load()
    for asf, amc in ((made.ASF, SAME[name](made.AMC)), (SAME[name](made.ASF), made.AMC)):
        skeleton, motion = load(asf, amc)
        assert skeleton.names == want_skeleton.names
        np.testing.assert_array_equal(motion.local_rotations, want.local_rotations)
        np.testing.assert_array_equal(motion.root_translation, want.root_translation)


def test_no_limits_and_upper_case_keywords(load):
    bare = re.sub(r"\s+limits[^a-z]*\n", "\n", made.ASF)
    assert "(" not in bare
    load(bare)
    loud = re.sub(
        r"\b(direction|length|axis|dof|begin|end|name)\b", lambda m: m[0].upper(), made.ASF
    )
    assert load(loud)[0].names == load()[0].names


def test_bones_in_another_order_in_each_frame(load):
    _, want = load()
    head, *frames = re.split(r"(?m)^(?=\d+$)", made.AMC)
    rng = np.random.default_rng(0)
    mixed = head
    for frame in frames:
        number, *bones = frame.strip().split("\n")
        mixed += "\n".join([number, *rng.permutation(bones)]) + "\n"
    _, motion = load(amc=mixed)
    np.testing.assert_array_equal(motion.local_rotations, want.local_rotations)


def test_frames_need_not_begin_at_one(load):
    later = re.sub(r"(?m)^(\d+)$", lambda m: str(int(m[1]) + 99), made.AMC)
    assert load(amc=later)[1].num_frames == 3


def test_a_bone_with_the_name_of_an_end(tmp_path):
    (tmp_path / "7.asf").write_text(re.sub(r"\bhead\b", "ltibia_end", made.ASF))
    names = read_asf(tmp_path / "7.asf").skeleton.names
    assert names[4:] == ("ltibia_end", "ltibia_end_", "ltibia_end_end")


@pytest.mark.parametrize("size", ["1e-3", "7", "1e200"])
def test_the_direction_need_not_be_a_unit_vector(tmp_path, size):
    file = tmp_path / "7.asf"
    file.write_text(made.ASF.replace("direction 0 1 0\n", f"direction 0 {size} 0\n"))
    assert read_asf(file).skeleton.offsets[4, 1] == pytest.approx(8 * 0.0254 / 0.45)


def test_the_rate_can_be_given(load, tmp_path):
    load()
    motion = load_motion(tmp_path / "7_01.amc", frame_rate=60)[1]
    assert (motion.frame_rate, motion.num_frames) == (60.0, 3)


def test_which_asf_belongs_to_an_amc(tmp_path):
    amc = tmp_path / "14_02.amc"
    amc.write_text(made.AMC)
    (tmp_path / "other.ASF").write_text(made.ASF)
    assert find_asf(amc).name == "other.ASF"  # the only one
    (tmp_path / "14.asf").write_text(made.ASF)
    assert find_asf(amc).name == "14.asf"  # the one named like the prefix
    (tmp_path / "14_02.asf").write_text(made.ASF)
    assert find_asf(amc).name == "14.asf"
    assert read_asf(find_asf(amc)).skeleton.num_joints == 7


@given(st.integers(0, 10**6))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_random_bodies(tmp_path, seed):
    rng = np.random.default_rng(seed)
    names = [f"b{i}" for i in range(int(rng.integers(1, 9)))]
    bones, tree, frames = [], [], [f"{f + 1}" for f in range(2)]
    frames = [[f, "root " + " ".join(map(str, rng.uniform(-90, 90, 6)))] for f in frames]
    for i, name in enumerate(names):
        parent = "root" if i == 0 else ["root", *names[:i]][int(rng.integers(0, i + 1))]
        tree.append(f"{parent} {name}")
        dof = list(rng.permutation(["rx", "ry", "rz"])[: int(rng.integers(0, 4))])
        order = "".join(rng.permutation(list("XYZ")))
        bones.append(
            f"begin\nname {name}\ndirection {' '.join(map(str, rng.normal(size=3)))}\n"
            f"length {rng.uniform(0, 9)}\n"
            f"axis {' '.join(map(str, rng.uniform(-180, 180, 3)))} {order}\n"
            + (f"dof {' '.join(dof)}\n" if dof else "")
            + "end\n"
        )
        if dof:
            for frame in frames:
                frame.append(f"{name} {' '.join(map(str, rng.uniform(-180, 180, len(dof))))}")
    asf = (
        (
            ":units\nlength 0.45\nangle deg\n:root\norder TX TY TZ RX RY RZ\naxis XYZ\n"
            "position 1 2 3\norientation 0 0 0\n:bonedata\n" + "".join(bones)
        )
        + ":hierarchy\nbegin\n"
        + "\n".join(tree)
        + "\nend\n"
    )
    (tmp_path / "1.asf").write_text(asf)
    (tmp_path / "1_1.amc").write_text("\n".join("\n".join(frame) for frame in frames))
    skeleton, motion = load_motion(tmp_path / "1_1.amc")
    got = global_positions(skeleton, motion)
    want = reference.positions(tmp_path / "1.asf", tmp_path / "1_1.amc")
    for joint, name in enumerate(skeleton.names):
        np.testing.assert_allclose(got[:, joint], want[name], atol=2e-5, err_msg=name)
