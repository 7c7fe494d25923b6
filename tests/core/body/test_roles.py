"""Roles in trees of other makers: without toes or neck, with twists and fingers, on four legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core.body.height import body_height
from mgjax.core.body.names import read_name
from mgjax.core.body.roles import find_role, find_roles, require_roles
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton

Rows = list[tuple[str, str | None, tuple[float, float, float]]]

TRUNK: Rows = [
    ("Hips", None, (0, 0, 0)),
    ("Spine", "Hips", (0, 0.15, 0)),
    ("Chest", "Spine", (0, 0.2, 0)),
    ("Neck", "Chest", (0, 0.2, 0)),
    ("Head", "Neck", (0, 0.1, 0)),
]


def limbs(*, clavicle: bool = True, toe: bool = True, chest: str = "Chest") -> Rows:
    rows: Rows = []
    for side, x in (("Left", 1), ("Right", -1)):
        rows += [
            (f"{side}UpLeg", "Hips", (0.09 * x, 0, 0)),
            (f"{side}Leg", f"{side}UpLeg", (0, -0.43, 0)),
            (f"{side}Foot", f"{side}Leg", (0, -0.42, 0)),
        ]
        if toe:
            rows.append((f"{side}ToeBase", f"{side}Foot", (0, -0.05, 0.13)))
        if clavicle:
            rows.append((f"{side}Shoulder", chest, (0.03 * x, 0.15, 0)))
        top = f"{side}Shoulder" if clavicle else chest
        rows += [
            (f"{side}Arm", top, (0.14 * x, 0, 0)),
            (f"{side}ForeArm", f"{side}Arm", (0.28 * x, 0, 0)),
            (f"{side}Hand", f"{side}ForeArm", (0.25 * x, 0, 0)),
        ]
    return rows


def skeleton(rows: Rows) -> Skeleton:
    names = [name for name, _, _ in rows]
    return Skeleton(
        names=tuple(names),
        parents=tuple(-1 if p is None else names.index(p) for _, p, _ in rows),
        offsets=np.array([offset for _, _, offset in rows], np.float32),
    )


def named(body: Skeleton) -> dict[str, str]:
    return {role: body.names[joint] for role, joint in find_roles(body).items()}


def test_a_whole_body() -> None:
    roles = named(skeleton(TRUNK + limbs()))
    assert roles["left_shoulder"] == "LeftArm"  # and not the clavicle called shoulder
    assert (roles["spine"], roles["chest"], roles["neck"]) == ("Spine", "Chest", "Neck")
    assert roles["right_toe"] == "RightToeBase"
    assert "left_hand" not in roles  # no fingers


def test_without_toes_clavicles_neck_and_spine() -> None:
    trunk: Rows = [("Hips", None, (0, 0, 0)), ("Head", "Hips", (0, 0.6, 0))]
    roles = named(skeleton(trunk + limbs(clavicle=False, toe=False, chest="Hips")))
    assert roles["left_shoulder"] == "LeftArm"
    assert roles["chest"] == "Hips"
    assert roles["head"] == "Head"
    assert not {"left_toe", "neck", "spine"} & set(roles)


@pytest.mark.parametrize("bones", range(1, 8))
def test_any_number_of_spine_joints(bones: int) -> None:
    trunk: Rows = [("Hips", None, (0, 0, 0))]
    for k in range(bones):
        trunk.append((f"Spine{k}", trunk[-1][0], (0, 0.4 / bones, 0)))
    trunk += [("Neck", trunk[-1][0], (0, 0.2, 0)), ("Head", "Neck", (0, 0.1, 0))]
    roles = named(skeleton(trunk + limbs(chest=f"Spine{bones - 1}")))
    assert roles["chest"] == f"Spine{bones - 1}"
    assert (bones > 1) == ("spine" in roles)


def test_twist_bones_are_skipped() -> None:
    rows = TRUNK + limbs()
    at = next(i for i, row in enumerate(rows) if row[0] == "LeftLeg")
    rows[at] = ("LeftUpLegTwist", "LeftUpLeg", (0, -0.2, 0))
    rows.insert(at + 1, ("LeftLeg", "LeftUpLegTwist", (0, -0.23, 0)))
    rows.append(("RightForeArmTwist", "RightForeArm", (-0.2, 0, 0)))
    roles = named(skeleton(rows))
    assert (roles["left_hip"], roles["left_knee"]) == ("LeftUpLeg", "LeftLeg")
    assert (roles["right_elbow"], roles["right_wrist"]) == ("RightForeArm", "RightHand")


def test_fingers_face_and_prop_are_left_alone() -> None:
    rows = TRUNK + limbs()
    for side, x in (("Left", 1), ("Right", -1)):
        for finger in ("Thumb", "Index", "Middle", "Ring", "Pinky"):
            rows.append((f"{side}InHand{finger}", f"{side}Hand", (0.03 * x, 0, 0)))
            rows.append((f"{side}Hand{finger}1", f"{side}InHand{finger}", (0.06 * x, 0, 0)))
            rows.append((f"{side}Hand{finger}2", f"{side}Hand{finger}1", (0.04 * x, 0, 0)))
        rows.append((f"{side}Eye", "Head", (0.03 * x, 0.05, 0.1)))
    rows.append(("Jaw", "Head", (0, -0.05, 0.05)))
    rows.append(("Sword", "RightHand", (-0.1, 0, 0)))
    rows.append(("SwordTip", "Sword", (-1.2, 0, 0)))
    roles = named(skeleton(rows))
    assert roles["left_wrist"] == "LeftHand"
    assert roles["right_wrist"] == "RightHand"
    assert roles["left_hand"] == "LeftHandMiddle1"  # no metacarpal
    assert roles["head"] == "Head"


def test_four_legs_are_no_body() -> None:
    rows: Rows = [("Hips", None, (0, 0, 0)), ("Spine", "Hips", (0, 0, 0.5))]
    for end, top in (("Hind", "Hips"), ("Front", "Spine")):
        for side, x in (("Left", 1), ("Right", -1)):
            rows += [
                (f"{side}{end}UpLeg", top, (0.1 * x, 0, 0)),
                (f"{side}{end}Leg", f"{side}{end}UpLeg", (0, -0.3, 0)),
                (f"{side}{end}Foot", f"{side}{end}Leg", (0, -0.3, 0)),
            ]
    rows += [("Neck", "Spine", (0, 0.2, 0.2)), ("Head", "Neck", (0, 0.1, 0.2))]
    dog = skeleton(rows)
    assert named(dog) == {"root": "Hips"}
    assert body_height(dog) is None
    with pytest.raises(SkeletonError, match="left_knee"):
        require_roles(dog, ("left_knee",))


def test_what_was_said_counts() -> None:
    body = replace(skeleton(TRUNK + limbs()), roles=(("root", 0), ("head", 3)))
    assert find_role(body, "head") == 3
    assert find_role(body, "left_knee") is None


def test_height_from_bones_alone() -> None:
    body = synthetic_skeleton()
    tall = body_height(body)
    assert tall == pytest.approx(1.63, abs=0.02)
    flat = np.zeros_like(body.offsets)
    flat[:, 0] = np.linalg.norm(body.offsets, axis=1)
    assert body_height(replace(body, offsets=flat)) == pytest.approx(tall, rel=1e-6)
    assert body_height(replace(body, offsets=2 * np.asarray(body.offsets))) == pytest.approx(
        2 * tall
    )
    # By hand: legs 0.85, hips to head 0.65, no end of the head: 1.5 · (1 + 0.063 + 0.09).
    assert body_height(skeleton(TRUNK + limbs())) == pytest.approx(1.5 * 1.153, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "side", "part"),
    [
        ("LeftUpLeg", "left", "hip"),
        ("thigh_l", "left", "hip"),
        ("Bip01 R Calf", "right", "knee"),
        ("rtibia", "right", "knee"),
        ("J_Bip_L_LowerArm", "left", "elbow"),
        ("HandRight", "right", "wrist"),
        ("mixamorig7:LeftToeBase", "left", "toe"),
        ("lThumb", "left", "finger"),
        ("upperarm_twist_01_l", "left", "helper"),
        ("Group|Rig|lowerneck", "", "neck"),
        ("Hips", "", "hips"),
        ("hip", "", "hips"),
    ],
)
def test_names(name: str, side: str, part: str) -> None:
    hint = read_name(name)
    assert hint.side == side
    assert hint.has(part)


@pytest.mark.parametrize("name", ["L5", "lowerback", "RadiusX", "root", "Leg", "forearm"])
def test_no_side_where_there_is_none(name: str) -> None:
    assert read_name(name).side == ""
