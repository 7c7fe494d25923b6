from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from mgjax.core import kinematics, planar, quaternion
from mgjax.core.errors import SkeletonError
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from tests.core.batches import (
    assert_finite_gradient,
    assert_same_everywhere,
    over_batch_shapes,
    unit_quaternions,
    vectors,
)
from tests.reference import kinematics as reference

S = np.sqrt(0.5)


def test_arm_worked_by_hand():
    skeleton = Skeleton(
        names=("root", "upper", "lower", "tip"),
        parents=(-1, 0, 1, 2),
        offsets=np.array([[9.0, 9, 9], [1, 0, 0], [2, 0, 0], [3, 0, 0]]),
        end_joints=(3,),
    )
    # 90° about z at "upper", another 90° about z at "lower"; the root's offset is not added.
    q = np.array([[1, 0, 0, 0], [S, 0, 0, S], [S, 0, 0, S], [1, 0, 0, 0]])
    places, turns = kinematics.forward(skeleton, np.array([10.0, 20, 30]), q)
    np.testing.assert_allclose(
        places, [[10, 20, 30], [11, 20, 30], [11, 22, 30], [8, 22, 30]], atol=1e-12
    )
    np.testing.assert_allclose(turns[3], [0, 0, 0, 1], atol=1e-12)  # 180° about z


def random_tree(joints: int, seed: int) -> Skeleton:
    rng = np.random.default_rng(seed)
    parents = (-1, *(int(rng.integers(0, j)) for j in range(1, joints)))
    return Skeleton(
        names=tuple(f"j{j}" for j in range(joints)),
        parents=parents,
        offsets=rng.normal(size=(joints, 3)).astype(np.float32),
    )


@over_batch_shapes
def test_forward_matches_joint_by_joint(batch):
    for seed in range(4):
        skeleton = random_tree(9, seed)
        root, local = vectors(batch, seed), unit_quaternions((*batch, 9), seed)
        places, turns = kinematics.forward(skeleton, root, local)
        assert places.shape == (*batch, 9, 3)
        for p, q, r, turn in zip(
            places.reshape(-1, 9, 3),
            turns.reshape(-1, 9, 4),
            root.reshape(-1, 3),
            local.reshape(-1, 9, 4),
            strict=True,
        ):
            want, matrices = reference.forward(skeleton.parents, skeleton.offsets, r, turn)
            np.testing.assert_allclose(p, want, atol=1e-5)
            np.testing.assert_allclose([reference.matrix(x) for x in q], matrices, atol=1e-5)


@over_batch_shapes
def test_numpy_jax_jit_and_vmap_agree(batch, body):
    def run(root, local):
        return kinematics.forward(body, root, local)

    local = unit_quaternions((*batch, body.num_joints), 1)
    assert_same_everywhere(run, vectors(batch), local, atol=1e-5)


def test_moving_offsets_replace_the_skeleton(body, random_motion):
    motion = random_motion(body, 5)
    offsets = vectors((5, body.num_joints), 3)
    moving = replace(motion, joint_offsets=offsets)
    want = reference.global_positions(
        body.parents, offsets, motion.root_translation, motion.local_rotations
    )
    np.testing.assert_allclose(kinematics.global_positions(body, moving), want, atol=1e-5)
    rigid = replace(motion, joint_offsets=np.broadcast_to(body.offsets, offsets.shape).copy())
    np.testing.assert_array_equal(
        kinematics.global_positions(body, rigid), kinematics.global_positions(body, motion)
    )


def test_zero_offsets_have_finite_gradients(body):
    def run(offsets, root, local):
        skeleton = replace(body, offsets=offsets)
        positions = kinematics.forward(skeleton, root, local)[0]
        return positions, kinematics.planar_frames(skeleton, positions)

    local = np.zeros((body.num_joints, 4)) + np.array([1.0, 0, 0, 0])
    assert_finite_gradient(run, np.zeros((body.num_joints, 3)), np.zeros(3), local)


def test_planar_frames_follow_the_body(body, random_motion):
    motion = random_motion(body, 6)
    positions = kinematics.global_positions(body, motion)
    frames = kinematics.planar_frames(body, positions)
    hips = body.index("lfemur"), body.index("rfemur")
    want = [reference.heading(p[hips[0]], p[hips[1]]) for p in positions]
    np.testing.assert_allclose(frames[:, 0], want, atol=1e-5)
    np.testing.assert_allclose(frames[:, 1:], positions[:, 0, [0, 2]])
    local = planar.apply(planar.inverse(frames)[:, None], positions)
    np.testing.assert_allclose(local[:, 0, [0, 2]], 0, atol=1e-5)
    across = local[:, hips[0]] - local[:, hips[1]]
    np.testing.assert_allclose(across[:, 2], 0, atol=1e-5)
    assert (across[:, 0] > 0).all()


def test_planar_frames_without_hips():
    # An animal or a prop has a heading as well: of a line that turns with it.
    skeleton = random_tree(4, 0)
    places = np.random.default_rng(0).normal(size=(4, 3)).astype(np.float32)
    turn = quaternion.from_yaw(np.float32(0.5))
    turned = np.asarray(quaternion.rotate(turn, places))
    frames = [np.asarray(kinematics.planar_frames(skeleton, x)) for x in (places, turned)]
    assert (frames[1][0] - frames[0][0]) % (2 * np.pi) == pytest.approx(0.5, abs=1e-5)
    point = replace(skeleton, offsets=np.zeros((4, 3), np.float32))
    with pytest.raises(SkeletonError, match="4 joints at one place"):
        kinematics.planar_frames(point, np.zeros((4, 3), np.float32))


def test_velocities_worked_by_hand():
    x = np.array([0.0, 1, 4, 9])  # one joint on a parabola, 10 frames a second
    positions = np.stack([x, 0 * x, 0 * x], axis=-1)[:, None]
    # one-sided, (4−0)/0.2, (9−1)/0.2, one-sided
    np.testing.assert_allclose(
        kinematics.joint_velocities(positions, 10.0)[:, 0, 0], [10, 20, 40, 50]
    )
    np.testing.assert_allclose(kinematics.joint_velocities(positions[:2], 10.0)[:, 0, 0], [10, 10])
    np.testing.assert_allclose(kinematics.joint_velocities(positions[:1], 10.0), 0)


def test_velocities_agree_under_jit():
    def run(positions):
        return kinematics.joint_velocities(positions, 120.0)

    positions = np.random.default_rng(0).normal(size=(5, 3, 3)).astype(np.float32)
    np.testing.assert_allclose(jax.jit(run)(positions), run(positions), rtol=1e-5)


def test_far_from_the_origin(body, random_motion):
    motion = random_motion(body, 4)
    moved = replace(motion, root_translation=motion.root_translation + np.float32(50))
    difference = kinematics.global_positions(body, moved) - 50
    np.testing.assert_allclose(difference, kinematics.global_positions(body, motion), atol=2e-5)


def test_motion_of_jax_arrays(body, random_motion):
    motion = random_motion(body, 4)
    want = kinematics.global_positions(body, motion)
    moved = jax.tree.map(jax.numpy.asarray, (body, motion))
    got = jax.jit(kinematics.global_positions)(*moved)
    np.testing.assert_allclose(got, want, atol=1e-5)
    assert isinstance(moved[1], Motion)
