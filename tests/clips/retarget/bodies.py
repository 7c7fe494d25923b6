"""Procedural clips on skeletons with other names, proportions, rest poses and bone axes.

Two bodies after what is in the field: names, proportions and T-pose bones along +Y as Mixamo has
them, and MVN's segments (Xsens) with hanging arms and a spine of four joints. Their legs are those
of the procedural body, scaled, so that what they should look like on it is known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mgjax.clips.types import Clip
from mgjax.core import quaternion
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton, rest_positions

Place = str | tuple[str, str, float]
"""A joint of the procedural body, or a share of the way from one to another."""


@dataclass(frozen=True)
class Row:
    """A joint: its name and parent, where it is, what it turns like, and how large its bone is."""

    name: str
    parent: str
    place: Place
    turn: Place
    size: float


def _rows(table: str, sides: tuple[str, str]) -> list[Row]:
    """Reads ``name parent place turn size``; ``a>b:t`` is a share, ``@`` a side and ``%`` l, r."""
    rows: list[Row] = []
    for line in table.strip().splitlines():
        for side, letter in zip(sides, "lr", strict=True) if "@" in line else [("", "")]:
            cells = line.replace("@", side).replace("%", letter).split()
            rows.append(
                Row(cells[0], cells[1], _place(cells[2]), _place(cells[3]), float(cells[4]))
            )
    return rows


def _place(text: str) -> Place:
    if ">" not in text:
        return text
    first, rest = text.split(">")
    second, share = rest.split(":")
    return first, second, float(share)


# Legs of 1.12 times the size, a short trunk and long arms; no joint but the pelvis below the chest
# turns like one of the procedural body.
_MIXAMO = """
mixamorig:Hips - root root 1
mixamorig:Spine mixamorig:Hips root>thorax:0.3 lowerback>upperback:0.5 1.0
mixamorig:Spine1 mixamorig:Spine root>thorax:0.65 upperback>thorax:0.5 1.0
mixamorig:Spine2 mixamorig:Spine1 thorax thorax 1.0
mixamorig:Neck mixamorig:Spine2 lowerneck lowerneck>upperneck:0.5 1.0
mixamorig:Head mixamorig:Neck head head 1.0
mixamorig:HeadTop_End mixamorig:Head head_end head 1.0
mixamorig:@Shoulder mixamorig:Spine2 %clavicle>%humerus:0.2 %clavicle 1.0
mixamorig:@Arm mixamorig:@Shoulder %humerus %humerus 1.0
mixamorig:@ForeArm mixamorig:@Arm %radius %radius 1.2
mixamorig:@Hand mixamorig:@ForeArm %wrist %wrist 1.2
mixamorig:@HandMiddle1 mixamorig:@Hand %fingers %fingers 1.2
mixamorig:@UpLeg mixamorig:Hips %femur %femur 1.12
mixamorig:@Leg mixamorig:@UpLeg %tibia %tibia 1.12
mixamorig:@Foot mixamorig:@Leg %foot %foot 1.12
mixamorig:@ToeBase mixamorig:@Foot %toes %toes 1.12
mixamorig:@Toe_End mixamorig:@ToeBase %toes_end %toes 1.12
"""
_XSENS = """
Pelvis - root root 1
L5 Pelvis root>thorax:0.2 root>upperback:0.5 1.05
L3 L5 root>thorax:0.45 upperback 1.05
T12 L3 root>thorax:0.7 upperback>thorax:0.5 1.05
T8 T12 thorax thorax 1.05
Neck T8 lowerneck lowerneck 1.05
Head Neck head head 1.05
Head_end Head head_end head 1.05
@Shoulder T8 %clavicle>%humerus:0.15 %clavicle 0.9
@UpperArm @Shoulder %humerus %humerus 0.9
@ForeArm @UpperArm %radius %radius 0.9
@Hand @ForeArm %wrist %wrist 0.9
@Hand_end @Hand %hand %wrist 0.9
@UpperLeg Pelvis %femur %femur 0.85
@LowerLeg @UpperLeg %tibia %tibia 0.85
@Foot @LowerLeg %foot %foot 0.85
@Toe @Foot %toes %toes 0.85
@Toe_end @Toe %toes_end %toes 0.85
"""


def mixamo(clip: Clip) -> Clip:
    """The clip on the body with Mixamo's names, each bone along its joint's own +Y."""
    skeleton, motion = _rebuilt(clip, _rows(_MIXAMO, ("Left", "Right")), 1.12)
    return replace(clip, skeleton=(new := along_y(skeleton))[0], motion=new[1](motion))


def xsens(clip: Clip) -> Clip:
    """The clip on the body with MVN's segments; in its rest pose the arms hang."""
    skeleton, motion = _rebuilt(clip, _rows(_XSENS, ("Left", "Right")), 0.85)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (skeleton.num_joints, 1))
    for joint, name in enumerate(skeleton.names):
        if any(part in name for part in ("UpperArm", "ForeArm", "Hand")):
            angle = np.array(-1.45 if name.startswith("Left") else 1.45)
            turns[joint] = quaternion.from_axis_angle(np.array([0.0, 0.0, 1.0]), angle)
    return replace(
        clip, skeleton=_reposed(skeleton, turns), motion=_converted(skeleton, turns, motion)
    )


def along_y(skeleton: Skeleton):
    """A skeleton with each bone along +Y of its joint, rolled, and what converts motions to it."""
    turns = np.zeros((skeleton.num_joints, 4))
    offsets = np.asarray(skeleton.offsets, np.float64)
    for joint in range(skeleton.num_joints):
        below = [j for j, p in enumerate(skeleton.parents) if p == joint]
        bone = offsets[below[0]] if below else np.array([0.0, 1.0, 0.0])
        up = quaternion.from_two_vectors(bone, np.array([0.0, 1.0, 0.0]))
        turns[joint] = quaternion.multiply(quaternion.from_yaw(np.array(0.4 * joint)), up)
    return _reposed(skeleton, turns), lambda motion: _converted(skeleton, turns, motion)


def _reposed(skeleton: Skeleton, turns: np.ndarray) -> Skeleton:
    """The skeleton whose rest pose has each joint turned in the world."""
    parents = np.maximum(np.array(skeleton.parents), 0)
    offsets = quaternion.rotate(turns[parents], np.asarray(skeleton.offsets, np.float64))
    return replace(skeleton, offsets=np.asarray(offsets, np.float32))


def _converted(skeleton: Skeleton, turns: np.ndarray, motion: Motion) -> Motion:
    """The same joint places for the rest pose of :func:`_reposed`."""
    above = turns[np.maximum(np.array(skeleton.parents), 0)].copy()
    above[0] = [1.0, 0.0, 0.0, 0.0]
    local = np.asarray(motion.local_rotations, np.float64)
    local = quaternion.multiply(quaternion.multiply(above, local), quaternion.conjugate(turns))
    return replace(motion, local_rotations=np.asarray(local, np.float32))


def _rebuilt(clip: Clip, rows: list[Row], legs: float) -> tuple[Skeleton, Motion]:
    """The motion of the procedural body on another one, in a T-pose with the same axes."""
    old = clip.skeleton
    rest = rest_positions(old)
    _, world = forward(
        old,
        np.asarray(clip.motion.root_translation, np.float64),
        np.asarray(clip.motion.local_rotations, np.float64),
    )

    def at(place: Place) -> np.ndarray:
        if isinstance(place, str):
            return rest[old.index(place)]
        a, b, share = place
        return (1 - share) * at(a) + share * at(b)

    def turn(place: Place) -> np.ndarray:
        if isinstance(place, str):
            return np.asarray(world)[:, old.index(place)]
        a, b, share = place
        return np.asarray(quaternion.slerp(turn(a), turn(b), np.array(share)))

    names = [row.name for row in rows]
    parents = tuple(names.index(row.parent) if row.parent != "-" else -1 for row in rows)
    offsets, turned = np.zeros((len(rows), 3)), np.zeros((clip.motion.num_frames, len(rows), 4))
    for joint, (row, parent) in enumerate(zip(rows, parents, strict=True)):
        turned[:, joint] = turn(row.turn)
        if parent >= 0:
            offsets[joint] = row.size * (at(row.place) - at(rows[parent].place))
    ends = tuple(j for j, name in enumerate(names) if name.lower().endswith("_end"))
    local = turned.copy()
    for joint, parent in enumerate(parents):
        if parent >= 0:
            above = quaternion.conjugate(turned[:, parent])
            local[:, joint] = quaternion.multiply(above, turned[:, joint])
    skeleton = Skeleton(
        names=tuple(names),
        parents=parents,
        offsets=offsets.astype(np.float32),
        end_joints=ends,
    )
    root = np.asarray(clip.motion.root_translation, np.float64) * legs
    return skeleton, replace(
        clip.motion,
        root_translation=root.astype(np.float32),
        local_rotations=local.astype(np.float32),
    )


def turned_rest(skeleton: Skeleton, motion: Motion, yaw: float) -> tuple[Skeleton, Motion]:
    """The same motion for a rest pose that faces elsewhere."""
    turns = np.tile(quaternion.from_yaw(np.array(yaw)), (skeleton.num_joints, 1))
    return _reposed(skeleton, turns), _converted(skeleton, turns, motion)
