"""The bones of Unity's humanoid that are used, as one table."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class HumanBone:
    """A bone of the humanoid.

    Attributes:
        name: in Unity.
        parent: name of the bone that it hangs on; "" for the hips.
        joint: that has its place in the embedded skeleton.
        role: of a joint with another name; "" where there is none.
        t_pose: where the bone points in the T-pose, and so how its joint is turned there: to its
            own side, down, ahead by its heading alone, as its parent, or as the body.
        points_to: name of the bone at whose place it points; "" where that does not matter.
        side: +1 left, −1 right, 0 in the middle.
        needed: whether a body without it has no legs.
    """

    name: str
    parent: str
    joint: str
    role: str = ""
    t_pose: Literal["side", "down", "ahead", "parent", "body"] = "body"
    points_to: str = ""
    side: Literal[-1, 0, 1] = 0
    needed: bool = False


_MIDDLE = (
    HumanBone(name="Hips", parent="", joint="root", role="root", needed=True),
    HumanBone(name="Spine", parent="Hips", joint="lowerback", role="spine"),
    HumanBone(name="Chest", parent="Spine", joint="upperback"),
    HumanBone(name="UpperChest", parent="Chest", joint="thorax", role="chest"),
    HumanBone(name="Neck", parent="UpperChest", joint="lowerneck", role="neck"),
    HumanBone(name="Head", parent="Neck", joint="head", role="head"),
)
_LEFT = (
    HumanBone(name="LeftShoulder", parent="UpperChest", joint="lclavicle"),
    HumanBone(
        name="LeftUpperArm",
        parent="LeftShoulder",
        joint="lhumerus",
        role="left_shoulder",
        t_pose="side",
        points_to="LeftLowerArm",
    ),
    HumanBone(
        name="LeftLowerArm",
        parent="LeftUpperArm",
        joint="lradius",
        role="left_elbow",
        t_pose="side",
        points_to="LeftHand",
    ),
    HumanBone(
        name="LeftHand", parent="LeftLowerArm", joint="lhand", role="left_wrist", t_pose="parent"
    ),
    HumanBone(
        name="LeftUpperLeg",
        parent="Hips",
        joint="lfemur",
        role="left_hip",
        t_pose="down",
        points_to="LeftLowerLeg",
        needed=True,
    ),
    HumanBone(
        name="LeftLowerLeg",
        parent="LeftUpperLeg",
        joint="ltibia",
        role="left_knee",
        t_pose="down",
        points_to="LeftFoot",
        needed=True,
    ),
    HumanBone(
        name="LeftFoot",
        parent="LeftLowerLeg",
        joint="lfoot",
        role="left_ankle",
        t_pose="ahead",
        points_to="LeftToes",
        needed=True,
    ),
    HumanBone(name="LeftToes", parent="LeftFoot", joint="ltoes", role="left_toe", t_pose="parent"),
)


def _right(bone: HumanBone) -> HumanBone:
    """The bone of the right side for one of the left."""
    return replace(
        bone,
        name=bone.name.replace("Left", "Right"),
        parent=bone.parent.replace("Left", "Right"),
        joint="r" + bone.joint.removeprefix("l"),
        role=bone.role.replace("left", "right"),
        points_to=bone.points_to.replace("Left", "Right"),
        side=-1,
    )


HUMAN_BONES = (
    *_MIDDLE,
    *(replace(bone, side=1) for bone in _LEFT),
    *(_right(bone) for bone in _LEFT),
)
"""The bones that are used; a parent comes before its children. Eyes, jaw and fingers are not."""
BONES = tuple(bone.name for bone in HUMAN_BONES)
PARENTS = tuple(BONES.index(bone.parent) if bone.parent else -1 for bone in HUMAN_BONES)
JOINT_NAMES = tuple(bone.joint for bone in HUMAN_BONES)
"""What the joints of a received body are called: as in the embedded skeleton."""
_BY_NAME = {name.lower(): bone for bone, name in enumerate(BONES)}
_FINGERS = {
    "Thumb": ("Metacarpal", "Proximal", "Intermediate", "Distal"),
    **dict.fromkeys(("Index", "Middle", "Ring", "Little"), ("Proximal", "Intermediate", "Distal")),
}
"""The thumb's bones are Proximal, Intermediate and Distal in Unity and VRM 0, and Metacarpal,
Proximal and Distal in VRM 1."""
_UNUSED = {
    *("jaw", "lefteye", "righteye"),
    *(
        f"{side}{finger}{part}".lower()
        for side in ("Left", "Right")
        for finger, parts in _FINGERS.items()
        for part in parts
    ),
}
NEEDED = tuple(number for number, bone in enumerate(HUMAN_BONES) if bone.needed)
"""Without these a body has no legs."""


def find_bone(name: str) -> int | None:
    """The number of a bone, in any letter case: Unity and VRM 0 say LeftHand, VRM 1 leftHand."""
    return _BY_NAME.get(name.lower())


def is_unused(name: str) -> bool:
    """Whether it is a bone of the humanoid that is not used: an eye, the jaw, or of a finger."""
    return name.lower() in _UNUSED


def nearest_above(bone: int, present: Collection[int]) -> int:
    """The next bone above that is present, or −1."""
    above = PARENTS[bone]
    while above >= 0 and above not in present:
        above = PARENTS[above]
    return above
