"""A humanoid in its T-pose: which joints are which bones, and how far the rest pose is from it.

VRM takes the rest pose of an animation for a T-pose (arms to the sides, legs down, facing +Z). Ours
may be any, so each bone's rotation from our rest pose to the T-pose is found first: that of the
trunk from the line between the hips and the line up to the neck, those of the limbs by the
smallest further rotation that lays them along their direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.body.roles import find_role
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton, rest_positions

_TRUNK = {"hips": "root", "spine": "spine", "chest": "chest", "neck": "neck", "head": "head"}
_LIMBS = {
    "UpperLeg": "hip",
    "LowerLeg": "knee",
    "Foot": "ankle",
    "Toes": "toe",
    "UpperArm": "shoulder",
    "LowerArm": "elbow",
    "Hand": "wrist",
}
ROLES = _TRUNK | {
    f"{side}{bone}": f"{side}_{role}" for side in ("left", "right") for bone, role in _LIMBS.items()
}
"""The role of each bone that is written, by VRM's name of it."""
OPTIONAL = {"chest", "neck", "leftToes", "rightToes"}
"""Bones that VRM does not ask for (VRMC_vrm 1.0, humanoid)."""
_ABOVE = {"Toes": "Foot", "Hand": "LowerArm"}
"""Bones at the end of a limb lie along the one above."""
_NEXT = {
    "Shoulder": "UpperArm",
    "UpperLeg": "LowerLeg",
    "LowerLeg": "Foot",
    "Foot": "Toes",
    "UpperArm": "LowerArm",
    "LowerArm": "Hand",
}
"""The bone whose place tells the direction of a limb's bone."""
_APART = ("UpperLeg", "UpperArm", "LowerLeg", "LowerArm")
_FOOT = np.array([0.0, -0.42, 0.91])
"""From the ankle to the ball of a foot whose sole is flat."""
_SHORTEST_M = 1e-4


@dataclass(frozen=True, kw_only=True)
class Humanoid:
    """The bones of a skeleton that VRM knows, a parent before its children.

    Attributes:
        names: VRM's names; the first is ``hips``.
        joints: of the skeleton.
        parents: index among these bones, −1 for the hips.
        places: in the T-pose, with the lowest at y = 0, m.
        turns: from the rest pose to the T-pose, in the world.
    """

    names: tuple[str, ...]
    joints: tuple[int, ...]
    parents: tuple[int, ...]
    places: Float[np.ndarray, "B 3"]
    turns: Float[np.ndarray, "B 4"]


def find_humanoid(skeleton: Skeleton) -> Humanoid:
    """The humanoid bones; :class:`SkeletonError` names all that are missing."""
    joints = {bone: find_role(skeleton, role) for bone, role in ROLES.items()}
    if joints["spine"] is None:  # a single joint between hips and neck is VRM's spine
        joints["spine"], joints["chest"] = joints["chest"], None
    missing = [bone for bone, joint in joints.items() if joint is None and bone not in OPTIONAL]
    if missing:
        raise SkeletonError(
            got=f"no joint for the bones {', '.join(missing)} among {', '.join(skeleton.names)}",
            expected="joints for all bones that VRM requires",
        )
    found = _nested(skeleton, {b: j for b, j in joints.items() if j is not None})
    found = _with_shoulders(skeleton, found)
    names = tuple(found)
    parents = tuple(_parent(skeleton, found, bone) for bone in names)
    turns = _turns(skeleton, found)
    rest = rest_positions(skeleton)
    places = np.zeros((len(names), 3))
    for bone, (name, parent) in enumerate(zip(names, parents, strict=True)):
        if parent >= 0:
            bone_in_rest = rest[found[name]] - rest[found[names[parent]]]
            places[bone] = places[parent] + quaternion.rotate(turns[parent], bone_in_rest)
    places[:, 1] -= places[:, 1].min()
    return Humanoid(
        names=names, joints=tuple(found.values()), parents=parents, places=places, turns=turns
    )


def _nested(skeleton: Skeleton, found: dict[str, int]) -> dict[str, int]:
    """Without optional bones that are no joint of their own; required ones must be distinct."""
    owners: dict[int, str] = {}
    kept: dict[str, int] = {}
    for bone in sorted(found, key=lambda bone: (bone in OPTIONAL, list(ROLES).index(bone))):
        joint = found[bone]
        if joint not in owners:
            owners[joint] = bone
            kept[bone] = joint
        elif bone not in OPTIONAL:
            name = skeleton.names[joint]
            raise SkeletonError(
                got=f"joint {name!r} for the bones {owners[joint]} and {bone}",
                expected="a joint of its own for each bone that VRM requires",
            )
    return dict(sorted(kept.items(), key=lambda item: item[1]))


def _with_shoulders(skeleton: Skeleton, found: dict[str, int]) -> dict[str, int]:
    """Adds VRM's shoulders (collar bones): the joint above an upper arm that carries only it."""
    taken = set(found.values())
    arms = [set(_above(skeleton, found[f"{side}UpperArm"])) for side in ("left", "right")]
    central = set(_above(skeleton, found["head"])) | (arms[0] & arms[1])
    for side in ("left", "right"):
        joint = skeleton.parents[found[f"{side}UpperArm"]]
        if joint >= 0 and joint not in taken | central:
            found = found | {f"{side}Shoulder": joint}
    return dict(sorted(found.items(), key=lambda item: item[1]))


def _above(skeleton: Skeleton, joint: int) -> list[int]:
    """The joints above one, the nearest first."""
    chain: list[int] = []
    while (joint := skeleton.parents[joint]) >= 0:
        chain.append(joint)
    return chain


def _parent(skeleton: Skeleton, found: dict[str, int], bone: str) -> int:
    """The nearest bone above, as an index."""
    bones = {joint: number for number, joint in enumerate(found.values())}
    above = next((joint for joint in _above(skeleton, found[bone]) if joint in bones), None)
    if above is None and bone != "hips":
        raise SkeletonError(got=f"a bone {bone} above the hips", expected="all bones below them")
    return -1 if above is None else bones[above]


def _turns(skeleton: Skeleton, found: dict[str, int]) -> np.ndarray:
    """[B,4] rotation of each bone from the rest pose to the T-pose."""
    rest = rest_positions(skeleton)
    trunk = _trunk_turn(rest, found)
    turns: list[np.ndarray] = []
    for bone in found:
        side = "left" if bone.startswith("left") else "right"
        part = bone.removeprefix(side)
        lead, follow = (part, _NEXT.get(part)) if part in _NEXT else (_ABOVE.get(part), part)
        turn = trunk
        if f"{side}{lead}" in found and f"{side}{follow}" in found:
            along = rest[found[f"{side}{follow}"]] - rest[found[f"{side}{lead}"]]
            turned, wanted = quaternion.rotate(trunk, along), _direction(part, side)
            # A collar bone goes up and back a little, as it should, where it is one at all.
            astray = part != "Shoulder" or turned @ wanted < 0.7 * np.linalg.norm(along)
            if np.linalg.norm(along) > _SHORTEST_M and astray:
                swing = quaternion.from_two_vectors(turned, wanted)
                turn = quaternion.multiply(swing, trunk)
        turns.append(np.asarray(turn))
    return np.stack(turns)


def _direction(part: str, side: str) -> np.ndarray:
    if part.endswith("Leg"):
        return np.array([0.0, -1.0, 0.0])
    if part in ("Foot", "Toes"):
        return _FOOT
    return np.array([1.0 if side == "left" else -1.0, 0.0, 0.0])


def _trunk_turn(rest: np.ndarray, found: dict[str, int]) -> np.ndarray:
    """Turns the line from the right to the left hip to +X, and the way up to the neck to +Y.

    Where both hips lie at the root, the next pair of joints that lie apart tells left from right.
    """
    lines = [rest[found[f"left{part}"]] - rest[found[f"right{part}"]] for part in _APART]
    left = next((line for line in lines if np.linalg.norm(line) > _SHORTEST_M), None)
    up = rest[found.get("neck", found["head"])] - rest[found["hips"]]
    if left is None or np.linalg.norm(up) < _SHORTEST_M:
        raise SkeletonError(
            got="a rest pose whose sides, or hips and neck, are at one place",
            expected="a body, whose T-pose can be told",
        )
    first = quaternion.from_two_vectors(up, np.array([0.0, 1.0, 0.0]))
    left = quaternion.rotate(first, left)
    yaw = np.arctan2(left[2], left[0])  # about +Y, which turns +Z towards +X
    return np.asarray(quaternion.multiply(quaternion.from_yaw(np.asarray(yaw)), first))
