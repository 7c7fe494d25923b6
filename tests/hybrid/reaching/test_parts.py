from __future__ import annotations

import math

import numpy as np
import pytest

from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.core import quaternion
from mgjax.core.body.joint_limits import clamp, random_rotations
from mgjax.core.body.roles import find_role
from mgjax.core.kinematics import forward, global_positions
from mgjax.core.timing.easing import plateau, smoothstep
from mgjax.graph.walk import unroll
from mgjax.hybrid.body.capsules import (
    arm_clearance,
    make_capsules,
    segment_distance,
    to_bar,
    to_points,
)
from mgjax.hybrid.body.limb_limits import make_limb_limits
from mgjax.hybrid.body.pelvis import lower_pelvis
from mgjax.hybrid.ik.limbs import ARMS, find_limb
from mgjax.hybrid.reaching.dubins import dubins
from mgjax.hybrid.reaching.placements import radius_of
from mgjax.hybrid.reaching.stops import Stop, play
from tests.hybrid.paths.made import walking
from tests.reference import reach as reference

RIGHT, LEFT = ARMS


def test_segment_distance() -> None:
    rng = np.random.default_rng(0)
    a, b, c, d = rng.normal(size=(4, 40, 3))
    found = segment_distance(a, b, c, d - c)
    wanted = [reference.segment_distance(*row) for row in zip(a, b, c, d, strict=True)]
    np.testing.assert_allclose(found, wanted, atol=2e-3)
    # Parallel ones, one beside the other and one beyond its end.
    x = np.eye(3)[:1]
    z = np.zeros((1, 3))
    assert segment_distance(z, x, z + np.array([0.2, 0.3, 0]), x)[0] == pytest.approx(0.3)
    assert segment_distance(z, x, z + np.array([3.0, 0, 0]), x)[0] == pytest.approx(2)


def test_body() -> None:
    skeleton = synthetic_skeleton()
    body = make_capsules(skeleton)
    assert {"torso", "head", "upper arm", "forearm", "hand", "thigh", "shin"} <= set(body.parts)
    arms = [p for p, limb in zip(body.parts, body.limbs, strict=True) if limb is LEFT]
    assert set(arms) == {"upper arm", "forearm", "hand"}
    rest = np.zeros((1, skeleton.num_joints, 4))
    rest[..., 0] = 1
    positions = np.asarray(forward(skeleton, np.zeros((1, 3)), rest)[0])
    head = positions[0, find_limb(skeleton, "head").joints[-1]]
    assert to_points(body, positions, head[None] + 0.0).min() < 0
    top = positions[0, :, 1].max()
    bar = np.array([[-1, top + 0.5, 0.0], [1, top + 0.5, 0.0]])
    radius = body.radii[body.parts.index("head")]
    assert to_bar(body, positions, bar, 0.03)[0] == pytest.approx(0.47 - radius, abs=0.02)
    assert arm_clearance(body, positions, RIGHT)[0] > 0.1


def test_radius_by_hand() -> None:
    limb = find_limb(synthetic_skeleton(), "right_hand")
    offsets = np.linalg.norm(
        np.asarray(synthetic_skeleton().offsets)[list(limb.joints[1:])], axis=1
    )
    for height in (0.2, 0.9, 1.6, 9.0):
        wanted = reference.radius(offsets.tolist(), height, 0.9)
        assert radius_of(limb, height, 0.9, 0.0) == pytest.approx(wanted, nan_ok=True)
    assert radius_of(limb, 0.4, 0.9, 0.5) == pytest.approx(0.95 * limb.reach_m)


def test_weights() -> None:
    wanted = [reference.weight(frame, 20, 25, 10) for frame in range(50)]
    np.testing.assert_allclose(plateau(np.arange(50), 20, 25, 10, 10), wanted, atol=1e-12)
    slope = np.diff(smoothstep(np.linspace(-0.5, 1.5, 2001))) * 1000
    assert np.abs(np.diff(slope)).max() < 0.01
    assert abs(slope[0]) + abs(slope[-1]) == 0


def test_playback() -> None:
    played = play(100, 30.0, [Stop(frame=0, frames=10), Stop(frame=50, frames=6),
                              Stop(frame=100, frames=12)])  # fmt: skip
    steps = np.diff(played.frames)
    assert (steps >= -1e-9).all()
    assert steps.max() < 1.05
    assert np.abs(np.diff(steps)).max() < 0.12  # no jump in speed
    for (first, last), frame in zip(played.stands, (0, 50, 100), strict=True):
        np.testing.assert_allclose(played.frames[first : last + 1], frame, atol=1e-9)
    assert played.frames[-1] == 100
    np.testing.assert_array_equal(play(7, 30.0, []).frames, np.arange(8))


def test_dubins() -> None:
    rng = np.random.default_rng(0)
    for begin, end in rng.uniform(-3, 3, (100, 2, 3)):
        line = dubins(begin, end, 0.7, 0.05)
        np.testing.assert_allclose(line[[0, -1]], [begin[1:], end[1:]], atol=1e-6)
        way = np.diff(line, axis=0)
        turned = np.arctan2(way[:, 0], way[:, 1])
        for found, wanted in ((turned[0], begin[0]), (turned[-1], end[0])):
            assert abs(math.remainder(found - wanted, 2 * math.pi)) < 0.06
    straight = dubins(np.zeros(3), np.array([0, 0, 2.0]), 0.7, 0.1)
    assert np.linalg.norm(np.diff(straight, axis=0), axis=1).sum() == pytest.approx(2)


def test_lowered_pelvis_keeps_the_feet() -> None:
    graph = walking()
    motion = unroll(graph, [int(graph.out_edges[0])])
    drop = np.linspace(0, 0.4, motion.num_frames)
    lowered = lower_pelvis(graph.skeleton, motion, drop)
    old, new = (
        forward(graph.skeleton, np.asarray(m.root_translation, np.float64),
                np.asarray(m.local_rotations, np.float64)) for m in (motion, lowered)
    )  # fmt: skip
    np.testing.assert_allclose(old[0][:, 0, 1] - new[0][:, 0, 1], drop, atol=2e-4)
    for role in ("left_ankle", "right_ankle", "left_toe", "right_toe"):
        joint = find_role(graph.skeleton, role)
        assert joint is not None
        np.testing.assert_allclose(new[0][:, joint], old[0][:, joint], atol=2e-3)
    thigh = find_role(graph.skeleton, "left_knee")
    heading = (
        old[0][-1, find_role(graph.skeleton, "left_toe")]
        - old[0][-1, find_role(graph.skeleton, "left_ankle")]
    )
    assert np.dot((new[0] - old[0])[-1, thigh] * [1, 0, 1], heading) > 0  # knees go forward
    plain = lower_pelvis(graph.skeleton, motion, 0 * drop)
    assert plain is motion


@pytest.mark.parametrize("name", ["right_hand", "left_hand", "head"])
def test_limits_hold_every_captured_pose(name: str) -> None:
    graph = walking()
    limb = find_limb(graph.skeleton, name)
    limits = make_limb_limits(graph).of((limb,))
    stop = int(graph.clip_stops[-1])
    captured = graph.local_rotations[:stop][:, list(limb.joints)]
    assert np.asarray(quaternion.angle_between(clamp(captured, limits), captured)).max() < 0.02


def test_elbows_bend_one_way() -> None:
    graph = walking()
    skeleton = graph.skeleton
    limb = find_limb(skeleton, "right_hand")
    limits = make_limb_limits(graph).of((limb,))
    poses = random_rotations(np.random.default_rng(0), 300, limits)
    elbow = find_role(skeleton, "right_elbow")
    assert elbow is not None
    local = np.zeros((300, skeleton.num_joints, 4), np.float32)
    local[..., 0] = 1
    local[:, list(limb.joints)] = poses
    places = np.asarray(forward(skeleton, np.zeros((300, 3), np.float32), local)[0])
    stop = int(graph.clip_stops[-1])
    _, walked = forward(
        skeleton, graph.root_translation[:stop], graph.local_rotations[:stop].astype(np.float32)
    )
    joints = global_positions(skeleton, unroll(graph, [int(graph.out_edges[0])]))
    assert np.isfinite(np.asarray(joints)).all()
    # The axis about which captured elbows bend, in the upper arm's frame.
    above = skeleton.parents[elbow]
    lower = limb.joints[limb.joints.index(elbow) + 1]
    upper = np.asarray(skeleton.offsets, np.float64)[elbow]
    bone = np.asarray(skeleton.offsets, np.float64)[lower]
    axis = np.cross(upper, quaternion.rotate(graph.local_rotations[:stop, elbow], bone[None])).sum(
        axis=0
    )
    axis /= np.linalg.norm(axis)
    bent = np.cross(upper, quaternion.rotate(poses[:, limb.joints.index(elbow)], bone[None]))
    angle = np.arcsin(np.linalg.norm(bent, axis=1) / np.linalg.norm(upper) / np.linalg.norm(bone))
    side = (bent / np.linalg.norm(bent, axis=1, keepdims=True)) @ axis
    assert (side[angle > 0.25] > 0.8).all()
    assert above == limb.joints[limb.joints.index(elbow) - 1]
    assert walked.shape[0] == stop
    assert np.isfinite(places).all()
