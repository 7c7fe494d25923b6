"""Motion files of many makers, and what is right for each."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.cli.main import main
from mgjax.clips.folder import load_clips
from mgjax.core.body.roles import ROLES, find_roles
from mgjax.core.errors import FileFormatError
from mgjax.core.kinematics import global_positions
from mgjax.core.skeleton import first_difference
from mgjax.io.acclaim.amc import find_asf
from mgjax.io.bvh.write import save_bvh
from mgjax.io.load import load_motion, read_capture
from mgjax.io.reading.read_as import ReadAs
from tests.cases.inputs import case_file, cases

HEAD_IN_FRAME_5 = (0.0116, 1.5654, 0.2)

SINGLE = [c for c in cases("small") if re.fullmatch(r"small/\S+\.(bvh|BVH)", c["input"])]
LOADS = [c for c in SINGLE if not str(c["expected"]).startswith("refused")]
REFUSED = [c for c in SINGLE if str(c["expected"]).startswith("refused")]
NAMES = [c for c in LOADS if "'roles'" in str(c["expected"]) or isinstance(c["expected"], dict)]


def places(name: str) -> np.ndarray:
    return np.asarray(global_positions(*load_motion(case_file(name))))


def head(name: str, frame: int = 5) -> np.ndarray:
    skeleton, motion = load_motion(case_file(name))
    joint = find_roles(skeleton)["head"]
    return np.asarray(global_positions(skeleton, motion))[frame, joint]


def tall(name: str) -> float:
    """Median height of the pose, m."""
    return float(np.median(np.ptp(places(name)[..., 1], axis=1)))


@pytest.mark.parametrize("case", NAMES, ids=lambda c: c["input"])
def test_roles(case: dict[str, Any]) -> None:
    expected = case["expected"]
    roles = (ast.literal_eval(expected) if isinstance(expected, str) else expected)["roles"]
    skeleton, _ = load_motion(case_file(case["input"]))
    assert {r: skeleton.names[j] for r, j in find_roles(skeleton).items() if r in roles} == roles


def test_a_prefix_with_a_colon_hides_no_role() -> None:
    skeleton, _ = load_motion(case_file("small/07_names_mixamo_colon.bvh"))
    assert set(ROLES) - set(find_roles(skeleton)) <= {"left_hand", "right_hand"}


@pytest.mark.parametrize(
    "case", [c for c in LOADS if "24_turns" not in c["input"]], ids=lambda c: c["input"]
)
def test_all_show_one_motion(case: dict[str, Any]) -> None:
    want = np.array(HEAD_IN_FRAME_5)
    if "08_flat_rest" in case["input"]:
        want[2] = 0.174
    # A floor that is found by the feet is as exact as the lowest of 12 frames.
    loose = 0.02 if "12_root" in case["input"] else 1e-3
    np.testing.assert_allclose(head(case["input"]), want, atol=loose)


@pytest.mark.parametrize("case", REFUSED, ids=lambda c: c["input"])
def test_refused(case: dict[str, Any]) -> None:
    with pytest.raises(FileFormatError) as error:
        load_motion(case_file(case["input"]))
    if line := re.search(r"line (\d+)", case["expected"]):
        assert error.value.line == int(line[1])
    else:
        assert re.search(r":\d+: .*line \d+", str(error.value))  # both lines


@pytest.mark.parametrize("case", [c for c in SINGLE if "17_rate" in c["input"]])
def test_rates(case: dict[str, Any]) -> None:
    value, _, tolerance = str(case["expected"]).partition("±")
    _, motion = load_motion(case_file(case["input"]))
    assert motion.frame_rate == pytest.approx(float(value), abs=float(tolerance or 0.001))


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("small/08_flat_rest_cm.bvh", "centimetre"),
        ("small/08_bones_along_x_m.bvh", "metre"),
        ("small/09_unit_inch.bvh", "inch"),
        ("small/09_unit_dm.bvh", "decimetre"),
        ("small/10_z_up_cm.bvh", "centimetre"),
        ("real/rokoko_dance.bvh", "centimetre"),
        ("real/mass_walk.bvh", "centimetre"),
        ("real/pybvh_test2.bvh", "centimetre"),
        ("real/pybvh_test3.bvh", "inch"),
        ("real/visutils_example.bvh", "centimetre"),
        ("real/btdm_walking.bvh", "inch"),
        ("real/video2bvh_mm.bvh", "millimetre"),
    ],
)
def test_units(name: str, unit: str) -> None:
    reading = read_capture(case_file(name)).reading
    assert reading.unit.name == unit
    assert reading.unit_sure > 0.9


@pytest.mark.parametrize("name", ["small/08_flat_rest_cm.bvh", "small/08_bones_along_x_m.bvh"])
def test_spheres_of_a_rest_pose_that_lies(name: str) -> None:
    skeleton, _ = load_motion(case_file(name))
    spheres = preset_spheres(skeleton)
    assert 0.13 <= spheres.radii[spheres.names.index("root-chest 0.50")] <= 0.15
    assert tall(name) == pytest.approx(1.71, abs=0.01)


def test_a_flat_rest_pose_is_the_usual_motion() -> None:
    usual = places("small/08_flat_rest_same_motion_usual_axes.bvh")
    np.testing.assert_allclose(places("small/08_flat_rest_cm.bvh"), usual, atol=1e-3)


@pytest.mark.parametrize("case", LOADS, ids=lambda c: c["input"])
def test_what_is_written_is_read_back(case: dict[str, Any], tmp_path: Path) -> None:
    skeleton, motion = load_motion(case_file(case["input"]))
    save_bvh(tmp_path / "out.bvh", skeleton, motion)
    again = load_motion(tmp_path / "out.bvh")
    want = np.asarray(global_positions(skeleton, motion))
    np.testing.assert_allclose(np.asarray(global_positions(*again)), want, atol=1e-4)
    # An editor took the blanks at the end of the first line away: the same is found.
    text = (tmp_path / "out.bvh").read_text()
    (tmp_path / "bare.bvh").write_text("\n".join(line.rstrip() for line in text.splitlines()))
    bare = load_motion(tmp_path / "bare.bvh")
    np.testing.assert_allclose(np.asarray(global_positions(*bare)), want, atol=1e-4)


def test_written_angles_go_on(tmp_path: Path) -> None:
    save_bvh(tmp_path / "out.bvh", *load_motion(case_file("small/24_turns_twice.bvh")))
    text = (tmp_path / "out.bvh").read_text().split("Frame Time:")[1]
    rows = np.array([line.split() for line in text.splitlines()[1:]], dtype=float)
    assert np.abs(np.diff(rows, axis=0)).max() < 90
    assert np.ptp(rows[:, 3:], axis=0).max() > 700  # two whole turns


def test_up_axis_and_floor_are_said(capsys: pytest.CaptureFixture[str]) -> None:
    z_up, low = (case_file(f"small/{n}.bvh") for n in ("10_z_up_cm", "12_root_relative"))
    assert (
        main(["info", "--json", str(z_up), str(low), str(case_file("real/visutils_example.bvh"))])
        == 0
    )
    rows = json.loads(capsys.readouterr().out)["files"]
    kinds = [[o["kind"] for o in row["oddities"]] for row in rows]
    assert "up_axis" in kinds[0]
    assert "floor" in kinds[1]
    assert "floor" in kinds[2]
    assert rows[1]["floor_m"] == pytest.approx(-0.95, abs=0.02)
    assert rows[2]["floor_m"] == pytest.approx(-0.78, abs=0.02)


def test_a_floor_root_is_folded() -> None:
    capture = read_capture(case_file("small/11_floor_root.bvh"))
    usual = load_motion(case_file("small/07_names_mixamo_colon.bvh"))
    assert capture.skeleton.names[0] == "Hips"
    assert capture.floor_root is not None
    np.testing.assert_allclose(
        np.asarray(global_positions(capture.skeleton, capture.motion)),
        np.asarray(global_positions(*usual)),
        atol=1e-4,
    )


def test_one_row_more_is_taken_and_said() -> None:
    capture = read_capture(case_file("small/01_one_row_more.bvh"))
    assert capture.motion.num_frames == 13
    assert [note.kind for note in capture.reading.notes] == ["rows"]


def test_good_files_are_described_beside_a_bad_one(capsys: pytest.CaptureFixture[str]) -> None:
    names = ("03_exponents", "02_missing_blank", "05_crlf_bom")
    assert main(["info", *(str(case_file(f"small/{name}.bvh")) for name in names)]) == 2
    out, err = capsys.readouterr()
    assert out.count("a body of 1.76 m") == 2
    assert "02_missing_blank.bvh:137" in err


def test_namespaces_make_no_difference(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("22_mixamorig1_walk.bvh", "22_mixamorig7_walk.bvh"):
        (tmp_path / name).write_bytes(case_file(f"small/{name}").read_bytes())
    clips, _ = load_clips(tmp_path)
    assert len(clips) >= 1
    both = [load_motion(tmp_path / f"22_mixamorig{n}_walk.bvh")[0] for n in (1, 7)]
    assert first_difference(*both) is None


REAL = {
    "rokoko_dance": 1.60,
    "pybvh_test3": 1.62,
    "pybvh_test2": 1.73,
    "btdm_walking": 1.54,
    "video2bvh_mm": 1.43,
}


@pytest.mark.parametrize("name", REAL)
def test_heights_of_real_files(name: str) -> None:
    assert tall(f"real/{name}.bvh") == pytest.approx(REAL[name], abs=0.01)


def test_other_real_files() -> None:
    walk = read_capture(case_file("real/mass_walk.bvh"))
    assert walk.reading.height_m == pytest.approx(1.72, rel=0.04)
    assert {"left_knee", "right_wrist", "head"} <= set(find_roles(walk.skeleton))
    two = read_capture(case_file("real/usdbvh_test.bvh"))
    assert [n for n in two.skeleton.names if not n.endswith("_end")] == ["Root", "Foo"]
    assert [
        read_capture(case_file(f"real/{n}.bvh")).reading.up for n in ("pybvh_test3", "video2bvh_mm")
    ] == ["z", "z"]


def amc(folder: str) -> Path:
    return next(
        p for p in sorted(case_file(f"amc/{folder}").iterdir()) if p.suffix.lower() == ".amc"
    )


@pytest.mark.parametrize(
    "folder", ["from_zero", "from_37", "no_header", "capitals", "crlf", "root_order"]
)
def test_amc_as_the_plain_one(folder: str) -> None:
    want = np.asarray(global_positions(*load_motion(amc("plain"))))
    np.testing.assert_allclose(
        np.asarray(global_positions(*load_motion(amc(folder)))), want, atol=1e-5
    )


def test_each_amc_finds_its_own_skeleton() -> None:
    folder = case_file("amc/hdm_names")
    for which in ("aa", "bb"):
        (file,) = folder.glob(f"HDM_{which}_*.amc")
        assert find_asf(file).name == f"HDM_{which}.asf"
        load_motion(file)


def test_a_size_that_no_body_has_is_said() -> None:
    reading = read_capture(amc("length_in_cm")).reading
    assert [note.kind for note in reading.notes] == ["size"]
    told = read_capture(amc("length_in_cm"), ReadAs(units="cm")).reading
    assert told.notes == ()
    assert 1.5 < (told.height_m or 0) < 1.8
