"""Another rest pose is the same motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core.body.mirrored import mirror_joints
from mgjax.core.body.rest import standing_rest
from mgjax.core.body.roles import find_roles
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, mirror
from mgjax.core.skeleton import Skeleton, rest_positions

BODY = synthetic_skeleton()


def turned(seed: int) -> Skeleton:
    """The body with the frame of every joint turned at random: a rest pose that is no pose."""
    turns = Rotation.random(BODY.num_joints, np.random.default_rng(seed)).as_matrix()
    offsets = np.asarray(BODY.offsets, np.float64)
    moved = [turns[max(p, 0)] @ offsets[j] for j, p in enumerate(BODY.parents)]
    return replace(BODY, offsets=np.array(moved, np.float32))


def random_motion(skeleton: Skeleton, seed: int, frames: int = 4) -> Motion:
    rng = np.random.default_rng(seed)
    quats = rng.normal(size=(frames, skeleton.num_joints, 4))
    quats /= np.linalg.norm(quats, axis=-1, keepdims=True)
    quats[:, list(skeleton.end_joints)] = (1, 0, 0, 0)
    return Motion(
        root_translation=rng.normal(size=(frames, 3)).astype(np.float32),
        local_rotations=quats.astype(np.float32),
        frame_rate=30.0,
    )


def test_a_rest_pose_that_stands_stays() -> None:
    assert standing_rest(BODY) is None


def test_no_body_stays() -> None:
    assert (
        standing_rest(Skeleton(names=("a", "b"), parents=(-1, 0), offsets=np.ones((2, 3)))) is None
    )


@given(st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_places_are_the_same(seed: int) -> None:
    skeleton = turned(seed)
    motion = random_motion(skeleton, seed)
    rest = standing_rest(skeleton)
    assert rest is not None
    np.testing.assert_allclose(
        np.asarray(global_positions(rest.skeleton, rest.motion(motion))),
        np.asarray(global_positions(skeleton, motion)),
        atol=1e-5,
    )
    # It stands, as long as it was, and looks ahead.
    roles = find_roles(rest.skeleton)
    places = rest_positions(rest.skeleton)
    np.testing.assert_allclose(
        np.linalg.norm(np.asarray(rest.skeleton.offsets), axis=1),
        np.linalg.norm(np.asarray(skeleton.offsets), axis=1),
        atol=1e-6,
    )
    assert places[roles["head"], 1] > places[roles["left_hip"], 1] > places[roles["left_knee"], 1]
    assert places[roles["left_wrist"], 0] > 0.4 > -0.4 > places[roles["right_wrist"], 0]
    assert places[roles["left_toe"], 2] > places[roles["left_ankle"], 2]
    assert standing_rest(rest.skeleton) is None


def test_mirrored_places() -> None:
    """On a standing rest pose, mirroring joints mirrors places, whatever the file's axes were."""
    offsets = np.asarray(BODY.offsets).copy()
    flat = np.zeros_like(offsets)
    flat[:, 0] = np.linalg.norm(offsets, axis=1)
    rest = standing_rest(replace(BODY, offsets=flat))
    assert rest is not None
    motion = random_motion(rest.skeleton, 1)
    twins = list(mirror_joints(rest.skeleton))
    want = np.asarray(global_positions(rest.skeleton, motion))[:, twins] * [-1, 1, 1]
    got = np.asarray(global_positions(rest.skeleton, mirror(rest.skeleton, motion)))
    np.testing.assert_allclose(got, want, atol=0.02)
