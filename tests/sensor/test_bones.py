"""Bones, axes and rest poses, there and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core import quaternion
from mgjax.core.errors import SkeletonError
from mgjax.core.kinematics import forward, global_positions
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.io.load import load_motion
from mgjax.sensor.bone_table import BONES, JOINT_NAMES, PARENTS
from mgjax.sensor.bones import encode, find_bones, flip_places, flip_rotations, t_pose, usual_places


def still(skeleton: Skeleton) -> Motion:
    rotations = np.zeros((1, skeleton.num_joints, 4), np.float32)
    rotations[..., 0] = 1.0
    place = np.array([[0.1, 0.9, -0.2]], np.float32)
    return Motion(root_translation=place, local_rotations=rotations, frame_rate=30.0)


def matrix(q: np.ndarray) -> np.ndarray:
    return np.stack([np.asarray(quaternion.rotate(q, axis)) for axis in np.eye(3)], axis=1)


def in_unity(poses, frame: int = 0) -> dict[str, np.ndarray]:
    """World places by plain loops over what is sent, in Unity's own axes."""
    places: dict[str, np.ndarray] = {}
    turns: dict[str, np.ndarray] = {}
    for number, bone in enumerate(poses.bones):
        above = PARENTS[bone]
        while above >= 0 and above not in poses.bones:
            above = PARENTS[above]
        place, turn = poses.places[frame, number], matrix(poses.rotations[frame, number])
        if above >= 0:
            place = places[BONES[above]] + turns[BONES[above]] @ place
            turn = turns[BONES[above]] @ turn
        places[BONES[bone]], turns[BONES[bone]] = place, turn
    return places


def test_the_table() -> None:
    assert len(set(BONES)) == len(set(JOINT_NAMES)) == len(BONES) == 22
    assert PARENTS[0] == -1
    assert all(0 <= parent < bone for bone, parent in enumerate(PARENTS) if bone)
    skeleton = synthetic_skeleton()
    assert {BONES[b]: skeleton.names[j] for b, j in find_bones(skeleton).items()} == dict(
        zip(BONES, JOINT_NAMES, strict=True)
    )


def test_axes_by_hand() -> None:
    # Ahead stays ahead, what is on the left of the body stays there: +X here, −X in Unity.
    np.testing.assert_array_equal(flip_places(np.array([1.0, 2.0, 3.0])), [-1, 2, 3])
    rng = np.random.default_rng(0)
    q = np.asarray(quaternion.normalise(rng.normal(size=(20, 4))))
    reflect = np.diag([-1.0, 1.0, 1.0])
    for one in q:
        np.testing.assert_allclose(
            matrix(flip_rotations(one)), reflect @ matrix(one) @ reflect, atol=1e-12
        )
    np.testing.assert_array_equal(flip_rotations(flip_rotations(q)), q)
    # Turning to the left takes +Z to +X here, and to −X in Unity.
    left = quaternion.from_yaw(np.array(np.pi / 2))
    np.testing.assert_allclose(matrix(np.asarray(left)) @ [0, 0, 1], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(matrix(flip_rotations(left)) @ [0, 0, 1], [-1, 0, 0], atol=1e-12)


def spread(skeleton: Skeleton) -> Skeleton:
    """Another rest pose: all of the body turned by 40°, arms hang at 45°, legs spread, toes out."""
    yaw = np.asarray(quaternion.from_yaw(np.array(np.radians(40))))
    offsets = np.asarray(skeleton.offsets, np.float64).copy()
    for side, sign in (("l", 1), ("r", -1)):
        for name in ("radius", "wrist", "hand", "fingers"):
            joint = skeleton.index(side + name)
            offsets[joint] = np.linalg.norm(offsets[joint]) * np.array([sign, -1, 0]) / np.sqrt(2)
        for name in ("tibia", "foot"):
            joint = skeleton.index(side + name)
            offsets[joint] = np.linalg.norm(offsets[joint]) * np.array(
                [sign * np.sin(0.35), -np.cos(0.35), 0]
            )
        joint = skeleton.index(side + "toes")
        out = np.asarray(quaternion.from_yaw(np.array(sign * 0.3)))
        offsets[joint] = np.asarray(quaternion.rotate(out, offsets[joint]))
    turned = np.asarray(quaternion.rotate(yaw, offsets))
    return replace(skeleton, offsets=turned.astype(np.float32))


def in_t_pose(skeleton: Skeleton) -> Motion:
    """Every joint with a bone in the T-pose, others like their parents."""
    bones = find_bones(skeleton)
    turns = {bones[bone]: turn for bone, turn in t_pose(skeleton, bones).items()}
    world = np.zeros((skeleton.num_joints, 4))
    local = still(skeleton).local_rotations.copy()
    for joint, parent in enumerate(skeleton.parents):
        world[joint] = turns.get(joint, world[parent])
        if parent >= 0:
            local[0, joint] = quaternion.multiply(quaternion.conjugate(world[parent]), world[joint])
        else:
            local[0, joint] = world[joint]
    return replace(still(skeleton), local_rotations=local)


@pytest.mark.parametrize("kind", ["embedded", "spread", "captured"])
def test_t_pose(kind: str, request: pytest.FixtureRequest) -> None:
    skeleton = synthetic_skeleton()
    if kind == "spread":
        skeleton = spread(skeleton)
    if kind == "captured":
        capture = request.getfixturevalue("capture")
        skeleton, _ = load_motion(capture / "ball/cmu10/10_02.amc")
    sent = encode(skeleton, in_t_pose(skeleton))
    # Identity everywhere is what Unity calls the T-pose.
    np.testing.assert_allclose(np.abs(sent.rotations[0, :, 0]), 1.0, atol=1e-6)
    places = in_unity(sent)
    for side, sign in (("Left", -1), ("Right", 1)):
        for a, b, way in (
            ("UpperArm", "LowerArm", (sign, 0, 0)),
            ("LowerArm", "Hand", (sign, 0, 0)),
            ("UpperLeg", "LowerLeg", (0, -1, 0)),
            ("LowerLeg", "Foot", (0, -1, 0)),
        ):
            bone = places[side + b] - places[side + a]
            np.testing.assert_allclose(bone / np.linalg.norm(bone), way, atol=1e-5)
        foot = places[side + "Toes"] - places[side + "Foot"]
        assert foot[2] > 0
        assert abs(foot[0]) < 1e-5


def test_what_is_sent_stands_where_the_body_stands(body: Skeleton, random_motion) -> None:
    for skeleton in (body, synthetic_skeleton(), spread(synthetic_skeleton())):
        motion = random_motion(skeleton, frames=3)
        places = np.asarray(global_positions(skeleton, motion))
        sent, bones = encode(skeleton, motion), find_bones(skeleton)
        for frame in range(3):
            for name, place in in_unity(sent, frame).items():
                ours = places[frame, bones[BONES.index(name)]]
                np.testing.assert_allclose(place * [-1, 1, 1], ours, atol=1e-5)
    assert "LeftHand" not in {BONES[bone] for bone in find_bones(body)}


def test_an_arm_lowered_by_hand() -> None:
    """In Unity the left arm, at −X, hangs when it is turned by +90° about Z."""
    skeleton = synthetic_skeleton()
    motion = still(skeleton)
    # Here the left arm is at +X, and hangs when turned by −90° about Z.
    down = quaternion.from_euler(np.array([-np.pi / 2]), "Z")
    motion.local_rotations[0, skeleton.index("lhumerus")] = np.asarray(down)
    sent = encode(skeleton, motion)
    number = sent.bones.index(BONES.index("LeftUpperArm"))
    half = np.sqrt(0.5)
    np.testing.assert_allclose(sent.rotations[0, number], [half, 0, 0, half], atol=1e-6)
    places, _ = forward(skeleton, motion.root_translation, motion.local_rotations)
    assert places[0, skeleton.index("lhand"), 1] < 0.9


def test_usual_places_are_those_of_the_embedded_body() -> None:
    skeleton = synthetic_skeleton()
    rest = rest_positions(skeleton)
    for bone, parent in enumerate(PARENTS):
        if parent >= 0:
            a, b = (skeleton.index(JOINT_NAMES[k]) for k in (parent, bone))
            np.testing.assert_allclose(usual_places()[bone], rest[b] - rest[a], atol=1e-6)


def test_a_body_without_legs_is_refused(body: Skeleton) -> None:
    trunk = Skeleton(names=body.names[:3], parents=body.parents[:3], offsets=body.offsets[:3])
    with pytest.raises(SkeletonError, match="left_hip"):
        find_bones(trunk)
