from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.core.errors import MotionError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, cut, mirror, resample, sample, validate_motion
from tests.conftest import make_motion, make_skeleton
from tests.reference import kinematics as reference


def test_length_in_seconds(body, random_motion):
    motion = random_motion(body, 30, frame_rate=60.0)
    assert motion.num_frames == 30
    assert motion.seconds == 0.5


def test_resampling_picks_frames_when_the_rate_divides(body, random_motion):
    motion = random_motion(body, 10, frame_rate=120.0)
    third = resample(motion, 30)  # frames 0, 4, 8
    assert third.frame_rate == 30
    np.testing.assert_array_equal(third.local_rotations, motion.local_rotations[[0, 4, 8]])
    np.testing.assert_array_equal(third.root_translation, motion.root_translation[[0, 4, 8]])
    same = resample(motion, 120)
    np.testing.assert_array_equal(same.local_rotations, motion.local_rotations)


def test_resampling_slerps_otherwise(body, random_motion):
    motion = random_motion(body, 4, frame_rate=30.0)
    twice = resample(motion, 60)  # 0, ½, 1 … 3
    assert twice.num_frames == 7
    np.testing.assert_allclose(twice.root_translation[::2], motion.root_translation, atol=1e-6)
    middle = 0.5 * (motion.root_translation[0] + motion.root_translation[1])
    np.testing.assert_allclose(twice.root_translation[1], middle, atol=1e-6)
    for joint in range(body.num_joints):
        pair = motion.local_rotations[0, joint], motion.local_rotations[1, joint]
        want = reference.slerp(*pair, 0.5)
        got = reference.matrix(twice.local_rotations[1, joint])
        np.testing.assert_allclose(got, want, atol=1e-5)


@pytest.mark.parametrize(
    ("old", "new", "frames", "want"),
    [
        (120, 30, 1, 1),
        (120, 30, 4, 1),
        (120, 30, 5, 2),
        (30, 120, 2, 5),
        (50, 30, 6, 4),  # 0.1 s at 30 Hz: frames at 0, 1/30, 2/30, 3/30 s
        (50, 30, 5, 3),
        (29.97, 30, 100, 100),
        (25, 30, 2, 2),
    ],
)
def test_number_of_resampled_frames(body, random_motion, old, new, frames, want):
    motion = resample(random_motion(body, frames, frame_rate=float(old)), new)
    assert motion.num_frames == want


def test_moving_offsets_are_resampled_too(body, random_motion):
    motion = random_motion(body, 4, frame_rate=30.0)
    offsets = np.random.default_rng(1).normal(size=(4, body.num_joints, 3)).astype(np.float32)
    motion = replace(motion, joint_offsets=offsets)
    np.testing.assert_array_equal(resample(motion, 15).joint_offsets, offsets[::2])
    np.testing.assert_allclose(
        resample(motion, 60).joint_offsets[1], 0.5 * (offsets[0] + offsets[1]), atol=1e-6
    )
    np.testing.assert_array_equal(cut(motion, 1, 3).joint_offsets, offsets[1:3])


@pytest.mark.parametrize("rate", [0, -1, float("nan"), float("inf"), 1e9])
def test_bad_rates_are_refused(body, random_motion, rate):
    with pytest.raises(MotionError, match="frame rate"):
        resample(random_motion(body), rate)


def test_sample_holds_the_ends(body, random_motion):
    motion = random_motion(body, 3)
    got = sample(motion, np.array([-5.0, 0, 2, 7]))
    np.testing.assert_allclose(got.root_translation, motion.root_translation[[0, 0, 2, 2]])
    one = sample(cut(motion, 0, 1), np.array([0.0, 0.7]))
    np.testing.assert_allclose(one.root_translation, motion.root_translation[[0, 0]])


def test_sample_under_jit(body, random_motion):
    motion = random_motion(body, 5)
    frames = np.array([0.0, 0.25, 3.5, 4.0], np.float32)
    want = sample(motion, frames)
    got = jax.jit(sample)(jax.tree.map(jax.numpy.asarray, motion), frames)
    np.testing.assert_allclose(got.local_rotations, want.local_rotations, atol=1e-5)
    np.testing.assert_allclose(got.root_translation, want.root_translation, atol=1e-6)


def test_sample_has_finite_gradients(body):
    still = Motion(  # equal rotations in all frames
        root_translation=np.zeros((3, 3), np.float32),
        local_rotations=np.tile(np.eye(4, dtype=np.float32)[0], (3, body.num_joints, 1)),
        frame_rate=30.0,
    )

    def total(motion, frames):
        return sample(motion, frames).local_rotations.sum()

    gradient = jax.jit(jax.grad(total, argnums=(0, 1)))(still, np.array([0.5, 1.0], np.float32))
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(gradient))


def test_cut(body, random_motion):
    motion = random_motion(body, 6)
    np.testing.assert_array_equal(cut(motion, 2, 5).root_translation, motion.root_translation[2:5])
    for start, stop in ((-1, 3), (3, 3), (4, 2), (0, 7)):
        with pytest.raises(MotionError, match="motion with 6"):
            cut(motion, start, stop)


@given(st.integers(0, 10**6))
def test_mirroring_twice_is_nothing(seed):
    body = make_skeleton()
    motion = make_motion(body, 3, seed=seed)
    again = mirror(body, mirror(body, motion))
    np.testing.assert_array_equal(again.local_rotations, motion.local_rotations)
    np.testing.assert_array_equal(again.root_translation, motion.root_translation)


@given(st.integers(0, 10**6))
def test_mirrored_positions_are_reflected(seed):
    body = make_skeleton()
    motion = make_motion(body, 3, seed=seed)
    plain = global_positions(body, motion)
    mirrored = global_positions(body, mirror(body, motion))
    for joint, name in enumerate(body.names):
        other = {"l": "r", "r": "l"}.get(name[0], name[0]) + name[1:]
        twin = body.index(other) if other in body.names else joint
        np.testing.assert_allclose(mirrored[:, joint], plain[:, twin] * [-1, 1, 1], atol=1e-5)


def test_mirroring_moving_offsets_on_jax_arrays(body, random_motion):
    offsets = np.random.default_rng(2).normal(size=(3, body.num_joints, 3)).astype(np.float32)
    motion = replace(random_motion(body, 3), joint_offsets=offsets)
    want = mirror(body, motion)
    got = mirror(body, jax.tree.map(jax.numpy.asarray, motion))
    for a, b in zip(jax.tree.leaves(want), jax.tree.leaves(got), strict=True):
        np.testing.assert_array_equal(a, b)
    plain = global_positions(body, motion)[:, body.index("lfoot")]
    np.testing.assert_allclose(
        global_positions(body, want)[:, body.index("rfoot")], plain * [-1, 1, 1], atol=1e-5
    )


def unchecked(motion: Motion, **changes) -> Motion:
    """A motion that the type checker would refuse, as a user without it could make one."""
    result = object.__new__(Motion)
    for name, value in {**motion.__dict__, **changes}.items():
        object.__setattr__(result, name, value)
    return result


def test_validate(body, random_motion):
    motion = random_motion(body, 4)
    validate_motion(body, motion)
    nothing = replace(
        motion,
        root_translation=motion.root_translation[:0],
        local_rotations=motion.local_rotations[:0],
    )
    bad = motion.local_rotations.copy()
    bad[2, 3] = np.nan
    far = motion.root_translation.copy()
    far[1, 0] = np.inf
    offsets = np.zeros((4, body.num_joints, 3), np.float32)
    offsets[3] = np.nan
    cases = [
        (unchecked(motion, local_rotations=offsets), "rotations have shape"),
        (nothing, "no frames"),
        (replace(motion, local_rotations=bad), "local_rotations is not finite in frame 2"),
        (replace(motion, root_translation=far), "root_translation is not finite in frame 1"),
        (replace(motion, joint_offsets=offsets), "joint_offsets is not finite in frame 3"),
        (unchecked(motion, joint_offsets=offsets[:, :2]), "joint offsets have shape"),
        (replace(motion, frame_rate=0.0), "frame rate"),
        (replace(motion, frame_rate=float("nan")), "frame rate"),
    ]
    for wrong, message in cases:
        with pytest.raises(MotionError, match=message):
            validate_motion(body, wrong)
