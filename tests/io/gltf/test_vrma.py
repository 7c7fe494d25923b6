"""VRM animations: the extension, the T-pose, and directions of bones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core import quaternion
from mgjax.core.body.roles import find_roles
from mgjax.core.errors import SkeletonError
from mgjax.core.kinematics import global_positions
from mgjax.core.skeleton import Skeleton
from mgjax.io.gltf.tpose import OPTIONAL, ROLES, find_humanoid
from mgjax.io.gltf.vrma import save_vrma
from mgjax.io.load import load_motion
from tests.conftest import make_motion, make_skeleton
from tests.io.gltf.test_write import document
from tests.io.skeletons import CASES
from tests.io.three import issues, modules, node


@pytest.fixture(scope="module")
def clip():
    found = next(clip for clip in synthetic_clips()[0] if clip.name == "mixed1")
    return found.skeleton, found.motion


def turned_rest(skeleton: Skeleton, motion, turns: np.ndarray):
    """The same motion on a skeleton whose rest pose has each joint turned, in the world, by C.

    Offsets become C(parent)·offset and global rotations G·C⁻¹, hence local ones Cₚ·l·C⁻¹.
    """
    parents = [max(parent, 0) for parent in skeleton.parents]
    offsets = quaternion.rotate(turns[parents], np.asarray(skeleton.offsets, np.float64))
    above = turns[parents]
    above[0] = (1, 0, 0, 0)
    local = quaternion.multiply(
        above[None], quaternion.multiply(np.asarray(motion.local_rotations, np.float64),
                                         quaternion.conjugate(turns)[None])
    )  # fmt: skip
    return (
        replace(skeleton, offsets=offsets.astype(np.float32)),
        replace(motion, local_rotations=local.astype(np.float32)),
    )


def test_the_extension_names_the_bones(clip, tmp_path):
    save_vrma(tmp_path / "x.vrma", *clip)
    file = document(tmp_path / "x.vrma")
    assert file["extensionsUsed"] == ["VRMC_vrm_animation"]
    extension = file["extensions"]["VRMC_vrm_animation"]
    assert extension["specVersion"] == "1.0"
    bones = extension["humanoid"]["humanBones"]
    assert set(ROLES) - OPTIONAL <= set(bones)
    assert {"chest", "neck", "leftToes", "rightShoulder"} <= set(bones)
    assert all(file["nodes"][bone["node"]]["name"] == name for name, bone in bones.items())
    moved = [c["target"] for c in file["animations"][0]["channels"]]
    places = [target["node"] for target in moved if target["path"] == "translation"]
    assert places == [bones["hips"]["node"]]  # of all bones only the hips may
    assert {target["path"] for target in moved} == {"translation", "rotation"}
    assert all(node.get("rotation") is None for node in file["nodes"])


def test_the_validator_finds_no_error_and_no_warning(clip, tmp_path):
    save_vrma(tmp_path / "x.vrma", *clip)
    found = issues(tmp_path / "x.vrma")
    assert (found["numErrors"], found["numWarnings"]) == (0, 0)


def test_another_reader_finds_the_same_tracks(clip, tmp_path):
    save_vrma(tmp_path / "x.vrma", *clip)
    folder = modules("three", "@pixiv/three-vrm-animation")
    theirs = node("vrma.mjs", folder, tmp_path / "x.vrma")
    bones, moves = load_motion(tmp_path / "x.vrma")
    assert theirs["duration"] == pytest.approx((moves.num_frames - 1) / 30, rel=1e-6)
    np.testing.assert_allclose(theirs["hips"], bones.offsets[0], atol=1e-6)
    assert set(theirs["rotation"]) == set(bones.names)
    for bone, values in theirs["rotation"].items():
        turns = np.reshape(values, (-1, 4))[:, [3, 0, 1, 2]]
        want = moves.local_rotations[:, bones.index(bone)]
        np.testing.assert_allclose(np.abs(np.sum(turns * want, axis=1)), 1, atol=1e-5)
    hips = np.reshape(theirs["translation"]["hips"], (-1, 3))
    np.testing.assert_allclose(hips, clip[1].root_translation, atol=1e-6)


def test_the_rest_pose_is_a_t_pose_facing_z(clip):
    humanoid = find_humanoid(clip[0])
    at = dict(zip(humanoid.names, humanoid.places, strict=True))
    assert at["hips"][1] == pytest.approx(0.99, abs=0.05)
    assert min(place[1] for place in at.values()) == 0
    for side, sign in (("left", 1), ("right", -1)):
        arm = [at[f"{side}{bone}"] for bone in ("UpperArm", "LowerArm", "Hand")]
        for bone in np.diff(arm, axis=0):
            np.testing.assert_allclose(bone / np.linalg.norm(bone), [sign, 0, 0], atol=1e-6)
        leg = [at[f"{side}{bone}"] for bone in ("UpperLeg", "LowerLeg", "Foot")]
        for bone in np.diff(leg, axis=0):
            np.testing.assert_allclose(bone / np.linalg.norm(bone), [0, -1, 0], atol=1e-6)
        toes = at[f"{side}Toes"] - at[f"{side}Foot"]
        assert toes[2] > 0.8 * np.linalg.norm(toes)
    assert at["leftUpperLeg"][0] > 0 > at["rightUpperLeg"][0]


@pytest.mark.parametrize("seed", [None, 0, 1])
def test_bones_point_where_they_pointed(clip, tmp_path, seed):
    """Whatever the rest pose is: limbs in every frame have the directions of the motion."""
    skeleton, motion = clip
    if seed is not None:
        turns = np.random.default_rng(seed).normal(size=(skeleton.num_joints, 4))
        skeleton, motion = turned_rest(skeleton, motion, np.asarray(quaternion.normalise(turns)))
    save_vrma(tmp_path / "x.vrma", skeleton, motion)
    bones, moves = load_motion(tmp_path / "x.vrma")
    humanoid = find_humanoid(skeleton)
    joints = dict(zip(humanoid.names, humanoid.joints, strict=True))
    want, got = global_positions(skeleton, motion), global_positions(bones, moves)
    np.testing.assert_allclose(got[:, bones.index("hips")], want[:, 0], atol=1e-6)
    for side in ("left", "right"):
        for upper, lower in (
            ("UpperLeg", "LowerLeg"), ("LowerLeg", "Foot"), ("Foot", "Toes"),
            ("UpperArm", "LowerArm"), ("LowerArm", "Hand"),
        ):  # fmt: skip
            a, b = f"{side}{upper}", f"{side}{lower}"
            bone = got[:, bones.index(b)] - got[:, bones.index(a)]
            joint = want[:, joints[b]] - want[:, joints[a]]
            np.testing.assert_allclose(bone, joint, atol=1e-5, err_msg=a)


def test_the_t_pose_has_the_trunk_upright_for_any_rest_pose(clip):
    skeleton, motion = clip
    q = np.random.default_rng(4).normal(size=4)
    turns = np.repeat(q[None] / np.linalg.norm(q), skeleton.num_joints, axis=0)
    lying, _ = turned_rest(skeleton, motion, turns)
    np.testing.assert_allclose(
        find_humanoid(lying).places, find_humanoid(skeleton).places, atol=1e-5
    )


def test_missing_bones_are_named(tmp_path):
    skeleton, motion = CASES["random"]()  # has no elbows and wrists
    with pytest.raises(SkeletonError, match=r"no joint for the bones leftLowerArm, leftHand"):
        save_vrma(tmp_path / "x.vrma", skeleton, motion)
    assert not list(tmp_path.iterdir())


def test_two_bones_cannot_share_a_joint(clip):
    skeleton, _ = clip
    roles = find_roles(skeleton)
    roles["left_ankle"] = roles["left_knee"]
    with pytest.raises(SkeletonError, match="'ltibia' for the bones leftLowerLeg and leftFoot"):
        find_humanoid(replace(skeleton, roles=tuple(roles.items())))


def test_a_skeleton_of_the_required_bones_only(tmp_path):
    made = make_skeleton()
    parent = {"l": made.index("lhumerus_end"), "r": made.index("rhumerus_end")}
    extra = [(f"{s}radius", parent[s]) for s in "lr"]
    names = [n.replace("lhumerus_end", "lx").replace("rhumerus_end", "rx") for n in made.names]
    offsets = [*np.asarray(made.offsets)]
    parents = [*made.parents]
    for side, sign in (("l", 1), ("r", -1)):
        for name, above in ((f"{side}radius", dict(extra)[f"{side}radius"]), (f"{side}wrist", -1)):
            parents.append(above if above >= 0 else len(names) - 1)
            names.append(name)
            offsets.append(np.array([0.25 * sign, 0, 0], np.float32))
    names[1] = "spine"
    skeleton = Skeleton(
        names=tuple(names), parents=tuple(parents), offsets=np.array(offsets, np.float32)
    )
    save_vrma(tmp_path / "x.vrma", skeleton, make_motion(skeleton, frames=5))
    bones, _ = load_motion(tmp_path / "x.vrma")
    assert set(bones.names) == set(ROLES) - {"chest", "neck"}
