"""One motion written in many ways is read as one motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mgjax.core.body.roles import find_roles
from mgjax.core.errors import FileFormatError
from mgjax.core.kinematics import global_positions
from mgjax.io.load import read_capture
from mgjax.io.reading.capture import Capture
from mgjax.io.reading.read_as import ReadAs
from mgjax.io.reading.units import UNITS
from tests.io.reading.made import Y_TO_Z, Maker, walk, write

SKELETON, MOTION = walk()
WANT = np.asarray(global_positions(SKELETON, MOTION))
ROLES = find_roles(SKELETON)

XSENS = {
    "lfemur": "LeftUpperLeg",
    "ltibia": "LeftLowerLeg",
    "lfoot": "LeftFoot",
    "ltoes": "LeftToe",
}
NONSENSE = {name: f"bone{j:02d}" for j, name in enumerate(SKELETON.names)}


def read(path: Path, maker: Maker, read_as: ReadAs | None = None) -> Capture:
    write(path / "made.bvh", SKELETON, MOTION, maker)
    return read_capture(path / "made.bvh", read_as)


def check(capture: Capture, maker: Maker, atol: float = 1e-4) -> None:
    """The joints are where they are, by name, and the same joints have the same roles."""
    got = np.asarray(global_positions(capture.skeleton, capture.motion))
    named = {maker.names.get(n, n): WANT[:, j] for j, n in enumerate(SKELETON.names)}
    for j, name in enumerate(capture.skeleton.names):
        if j not in capture.skeleton.end_joints:
            np.testing.assert_allclose(got[:, j], named[name], atol=atol, err_msg=name)
    roles = {r: capture.skeleton.names[j] for r, j in find_roles(capture.skeleton).items()}
    want = {r: maker.names.get(SKELETON.names[j], SKELETON.names[j]) for r, j in ROLES.items()}
    for side in ("left", "right"):  # fingers are known by their names alone
        roles.pop(f"{side}_hand", None)
        want.pop(f"{side}_hand", None)
    assert roles == want


@pytest.mark.parametrize("unit", UNITS)
def test_units(tmp_path: Path, unit: str) -> None:
    maker = Maker(scale=1 / UNITS[unit].metres)
    capture = read(tmp_path, maker)
    assert capture.unit is UNITS[unit]
    check(capture, maker, atol=2e-4)
    assert capture.reading.notes == ()


@pytest.mark.parametrize("along_x", [False, True])
@pytest.mark.parametrize("turn_rest", [True, False])
def test_z_up(tmp_path: Path, turn_rest: bool, along_x: bool) -> None:
    maker = Maker(world=Y_TO_Z, turn_rest=turn_rest, along_x=along_x)
    capture = read(tmp_path, maker)
    assert capture.reading.up == "z"
    assert [note.kind for note in capture.reading.notes] == ["up_axis"]
    check(capture, maker)


def test_bones_along_x(tmp_path: Path) -> None:
    maker = Maker(along_x=True, scale=1.0)
    check(read(tmp_path, maker), maker)


@pytest.mark.parametrize("floor", [-0.95, 1.1])
def test_floor(tmp_path: Path, floor: float) -> None:
    maker = Maker(floor=floor)
    capture = read(tmp_path, maker)
    assert [note.kind for note in capture.reading.notes] == ["floor"]
    check(capture, maker, atol=0.03)  # the feet say where it is, and they are not points
    kept = read(tmp_path, maker, ReadAs(floor="keep"))
    np.testing.assert_allclose(
        kept.motion.root_translation[:, 1] - MOTION.root_translation[:, 1], floor, atol=1e-4
    )
    check(read(tmp_path, maker, ReadAs(floor=floor)), maker)


def test_floor_root(tmp_path: Path) -> None:
    maker = Maker(floor_root=True)
    capture = read(tmp_path, maker)
    check(capture, maker)
    assert capture.floor_root is not None
    assert capture.floor_root.name == "Reference"
    np.testing.assert_allclose(capture.floor_root.translation, WANT[:, 0] * [1, 0, 1], atol=1e-4)


def test_names_of_another_maker(tmp_path: Path) -> None:
    maker = Maker(
        names=XSENS | {k.replace("l", "r", 1): v.replace("Left", "Right") for k, v in XSENS.items()}
    )
    check(read(tmp_path, maker), maker)


@pytest.mark.parametrize("world", [np.eye(3), np.diag([-1.0, 1.0, -1.0])])
def test_nonsense_names(tmp_path: Path, world: np.ndarray) -> None:
    # Where no name says left, the feet do: they point ahead.
    maker = Maker(names=NONSENSE, world=world)
    capture = read(tmp_path, maker)
    roles = {r: capture.skeleton.names[j] for r, j in find_roles(capture.skeleton).items()}
    for part in ("hip", "knee", "ankle", "toe", "shoulder"):
        for side in ("left", "right"):
            assert roles[f"{side}_{part}"] == NONSENSE[SKELETON.names[ROLES[f"{side}_{part}"]]]


def test_said_front_is_turned_to_z(tmp_path: Path) -> None:
    maker = Maker(world=np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]))  # z to x
    first = read(tmp_path, maker)
    looks = first.reading.front
    turned = read(tmp_path, maker, ReadAs(front=looks))
    assert turned.reading.front == "z"
    plain = read(tmp_path, Maker())
    if plain.reading.front == "z":
        assert looks == "x"
        check(turned, maker)


def test_a_body_between_two_units_is_refused_and_both_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"decimetre.*CMU|CMU.*decimetre"):
        read(tmp_path, Maker(scale=1.25 / 1.7 / UNITS["cmu"].metres))
    told = read(tmp_path, Maker(scale=1.25 / 1.7 / UNITS["cmu"].metres), ReadAs(units="cmu"))
    assert told.reading.height_m == pytest.approx(1.25 / 1.7 * 1.63, rel=0.03)
