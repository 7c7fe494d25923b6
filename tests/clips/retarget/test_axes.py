from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.retarget.body import make_body
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core import quaternion
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton

WALK = next(clip for clip in synthetic_clips()[0] if clip.name == "walk")


def rolled(name: str, angle: float) -> tuple[Skeleton, Motion]:
    """The walk for a joint whose axes are rolled about the vertical: places are the same."""
    skeleton = WALK.skeleton
    joint = skeleton.index(name)
    turn = quaternion.from_yaw(np.array(angle))
    offsets = np.array(skeleton.offsets, np.float64)
    local = np.array(WALK.motion.local_rotations, np.float64)
    local[:, joint] = quaternion.multiply(local[:, joint], quaternion.conjugate(turn))
    for child in [j for j, p in enumerate(skeleton.parents) if p == joint]:
        offsets[child] = quaternion.rotate(turn, offsets[child])
        local[:, child] = quaternion.multiply(turn, local[:, child])
    return (
        replace(skeleton, offsets=offsets.astype(np.float32)),
        replace(WALK.motion, local_rotations=local.astype(np.float32)),
    )


@pytest.mark.parametrize("angle", [-2.5, -0.3, 0.3, 1.5, 3.0])
def test_a_rolled_joint_of_the_spine_is_seen(angle):
    """The axes of a vertebra turn with it; its bone, 5° from the vertical, would hardly tell."""
    joint = WALK.skeleton.index("upperback")
    plain = make_body(WALK.skeleton, [WALK.motion]).axes(joint)
    skeleton, motion = rolled("upperback", angle)
    got = make_body(skeleton, [motion]).axes(joint)
    want = quaternion.multiply(quaternion.from_yaw(np.array(angle)), plain)
    assert np.degrees(quaternion.angle_between(got, np.asarray(want))) < 6.0
    # The rest pose alone does not show it.
    alone = make_body(skeleton).axes(joint)
    assert np.degrees(quaternion.angle_between(alone, np.asarray(want))) > 10.0


@pytest.mark.parametrize("name", ["lwrist", "head"])
def test_hands_and_heads_that_rest_elsewhere(name):
    """What is turned by 1.2 on average has another rest pose; by 0.3, it is meant."""
    joint = WALK.skeleton.index(name)
    plain = make_body(WALK.skeleton, [WALK.motion]).axes(joint)
    for angle, most in ((1.2, 30.0), (0.3, 0.01)):
        local = np.array(WALK.motion.local_rotations, np.float64)
        turn = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(angle))
        local[:, joint] = quaternion.multiply(local[:, joint], quaternion.conjugate(turn))
        motion = replace(WALK.motion, local_rotations=local.astype(np.float32))
        got = make_body(WALK.skeleton, [motion]).axes(joint)
        want = quaternion.multiply(turn, plain) if angle > 1 else plain
        assert np.degrees(quaternion.angle_between(got, np.asarray(want))) < most


def test_joints_without_axes_have_those_above():
    body = make_body(WALK.skeleton, [WALK.motion])
    index = WALK.skeleton.index
    np.testing.assert_array_equal(body.axes(index("lthumb")), body.axes(index("lwrist")))
    np.testing.assert_array_equal(body.axes(index("lhipjoint")), body.axes(0))
