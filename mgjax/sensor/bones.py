"""Bones of Unity's humanoid, on which the VMC protocol is built, and the joints of our skeletons.

Axes: Unity's are left-handed with Y up; a body that faces +Z has its left hand at −X. Ours are
right-handed with Y up; a body that faces +Z has its left hand at +X. So x changes its sign, and
with it the y and z components of a rotation; the same in both directions.

Rest pose: where a Unity bone has the identity rotation the body is in the T-pose, upright, facing
+Z, arms straight to the sides, palms down. Where our joints have the identity a body is in its
skeleton's own rest pose, which may differ: the legs of captured skeletons point outwards by 20°.
So each joint has a turn that takes it from its rest pose to the T-pose, found from the directions
of its bones: the whole body by the heading of its hips; upper and lower arm to the side, upper and
lower leg down, each by the smallest turn; the hand with the forearm; the foot by its heading, so
that it points ahead, and the toes with it. A joint's world rotation in Unity is its own times the
inverse of this turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.body.roles import find_role, require_roles
from mgjax.core.errors import SkeletonError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.sensor.bone_table import (
    BONES,
    HUMAN_BONES,
    JOINT_NAMES,
    NEEDED,
    PARENTS,
    nearest_above,
)

_DOWN = np.array([0.0, -1.0, 0.0])
_AHEAD = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, kw_only=True)
class BonePoses:
    """What a body sends, in Unity's axes, local to the nearest bone above that is sent, too.

    Attributes:
        bones: which, as places in :data:`mgjax.sensor.bone_table.BONES`.
        places: m; those of the hips in the world.
        rotations: wxyz.
    """

    bones: tuple[int, ...]
    places: Float[np.ndarray, "F B 3"]
    rotations: Float[np.ndarray, "F B 4"]


def flip_places(places: Float[Array, "*b 3"]) -> Float[np.ndarray, "*b 3"]:
    """From our axes to Unity's, or back."""
    return np.asarray(places) * np.array([-1.0, 1.0, 1.0])


def flip_rotations(rotations: Float[Array, "*b 4"]) -> Float[np.ndarray, "*b 4"]:
    """From our axes to Unity's, or back; wxyz."""
    return np.asarray(rotations) * np.array([1.0, 1.0, -1.0, -1.0])


def find_bones(skeleton: Skeleton) -> dict[int, int]:
    """The joint for each bone that a skeleton has, by the joint's name or else its role.

    Raises:
        SkeletonError: it has no hips, legs or feet.
    """
    require_roles(skeleton, ("left_hip", "left_knee", "left_ankle"))
    require_roles(skeleton, ("right_hip", "right_knee", "right_ankle"))
    by_name = {name.lower(): joint for joint, name in enumerate(skeleton.names)}
    joints: dict[int, int] = {}
    for bone, row in enumerate(HUMAN_BONES):
        joint = by_name.get(row.joint, find_role(skeleton, row.role) if row.role else None)
        if bone == 0:
            joint = 0
        if joint is not None and joint not in joints.values():
            joints[bone] = joint
    missing = [BONES[bone] for bone in NEEDED if bone not in joints]
    if missing:
        raise SkeletonError(f"found no joint for {missing[0]} among {', '.join(skeleton.names)}")
    return joints


def t_pose(skeleton: Skeleton, bones: dict[int, int]) -> dict[int, Float[np.ndarray, "4"]]:
    """World rotation of the joint of each bone when the body is in the T-pose."""
    places = rest_positions(skeleton)
    across = (
        places[bones[BONES.index("LeftUpperLeg")]] - places[bones[BONES.index("RightUpperLeg")]]
    )
    body_turn = _heading_turn(across, np.array([1.0, 0.0, 0.0]))
    turns: dict[int, np.ndarray] = {}
    for bone, joint in bones.items():
        row = HUMAN_BONES[bone]
        turns[bone] = body_turn
        if row.t_pose == "parent":
            turns[bone] = turns.get(PARENTS[bone], body_turn)
        below = BONES.index(row.points_to) if row.points_to else -1
        if below not in bones:
            continue
        direction = quaternion.rotate(body_turn, places[bones[below]] - places[joint])
        if row.t_pose == "ahead":
            turn = _heading_turn(np.asarray(direction), _AHEAD)
        else:
            goal = _DOWN if row.t_pose == "down" else np.array([float(row.side), 0.0, 0.0])
            turn = quaternion.from_two_vectors(direction, goal)
        turns[bone] = np.asarray(quaternion.multiply(turn, body_turn))
    return turns


def _heading_turn(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """About the vertical, from the heading of one direction to that of another."""
    flat = np.array([1.0, 0.0, 1.0])
    return np.asarray(quaternion.from_two_vectors(a * flat, b * flat))


def encode(skeleton: Skeleton, motion: Motion) -> BonePoses:
    """A motion as a VMC sender sends it; the model's root stays in the world's origin."""
    bones = find_bones(skeleton)
    turns = t_pose(skeleton, bones)
    root = np.asarray(motion.root_translation, np.float64)
    local = np.asarray(motion.local_rotations, np.float64)
    offsets = motion.joint_offsets
    placed, turned = forward(
        skeleton, root, local, None if offsets is None else np.asarray(offsets, np.float64)
    )
    world = {
        bone: np.asarray(quaternion.multiply(turned[:, joint], quaternion.conjugate(turns[bone])))
        for bone, joint in bones.items()
    }
    places = np.zeros((len(root), len(bones), 3))
    rotations = np.zeros((len(root), len(bones), 4))
    for number, (bone, joint) in enumerate(bones.items()):
        above = nearest_above(bone, bones)
        places[:, number], rotations[:, number] = placed[:, joint], world[bone]
        if above >= 0:
            back = quaternion.conjugate(world[above])
            places[:, number] = quaternion.rotate(back, placed[:, joint] - placed[:, bones[above]])
            rotations[:, number] = quaternion.multiply(back, world[bone])
    return BonePoses(
        bones=tuple(bones), places=flip_places(places), rotations=flip_rotations(rotations)
    )


def usual_places() -> Float[np.ndarray, "B 3"]:
    """[22,3] local places of all bones in the T-pose of the embedded body, our axes, m."""
    skeleton = synthetic_skeleton()
    identity = np.zeros((1, skeleton.num_joints, 4), np.float32)
    identity[..., 0] = 1.0
    still = Motion(
        root_translation=np.zeros((1, 3), np.float32), local_rotations=identity, frame_rate=1.0
    )
    return flip_places(encode(skeleton, still).places[0])


def make_body(places: Float[np.ndarray, "B 3"], present: set[int]) -> Skeleton:
    """The skeleton of a body that is received: its rest pose is the T-pose.

    Args:
        places: local places of all bones, our axes, m.
        present: which of them the sender has.
    """
    bones = sorted(present)
    offsets = np.asarray(places[bones], np.float32)
    offsets[0] = 0.0
    return Skeleton(
        names=tuple(JOINT_NAMES[bone] for bone in bones),
        parents=tuple(
            -1 if bone == 0 else bones.index(nearest_above(bone, present)) for bone in bones
        ),
        offsets=offsets,
    )
