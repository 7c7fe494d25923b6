from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.prepare import prepare_clips
from mgjax.clips.retarget.body import Body, make_body
from mgjax.clips.retarget.clip import carry, retarget
from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip
from mgjax.core import quaternion
from mgjax.core.body.rest import standing_rest
from mgjax.core.contacts import floor_steps, foot_joints, planted, stays_planted
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import forward, global_positions
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.io.load import load_motion
from tests.clips.retarget.bodies import along_y, mixamo, turned_rest, xsens

MADE = {clip.name: clip for clip in synthetic_clips()[0]}
LEG = ("femur", "tibia", "foot", "toes")
OTHER = {"mixamo": mixamo, "xsens": xsens}


def stands(clip: Clip) -> tuple[Skeleton, Motion]:
    rest = standing_rest(clip.skeleton)
    return (
        (clip.skeleton, clip.motion) if rest is None else (rest.skeleton, rest.motion(clip.motion))
    )


def body_of(clip: Clip) -> Body:
    skeleton, motion = stands(clip)
    return make_body(skeleton, [motion])


def places(skeleton: Skeleton, motion: Motion) -> np.ndarray:
    return np.asarray(global_positions(skeleton, motion), np.float64)


def bends(body: Body, motion: Motion, side: str) -> np.ndarray:
    """[F] bend of a knee about its hinge, rad; below 0 to the front."""
    p, turns = (
        np.asarray(x)
        for x in forward(
            body.skeleton,
            np.asarray(motion.root_translation, np.float64),
            np.asarray(motion.local_rotations, np.float64),
        )
    )
    hip, knee, ankle = (body.roles[f"{side}_{part}"] for part in ("hip", "knee", "ankle"))
    thigh, shin = p[:, knee] - p[:, hip], p[:, ankle] - p[:, knee]
    axis = quaternion.rotate(turns[:, hip], body.hinge(f"{side}_hip")[None])
    return np.arctan2((np.cross(thigh, shin) * axis).sum(-1), (thigh * shin).sum(-1))


@pytest.mark.parametrize("kind", OTHER)
@pytest.mark.parametrize("name", ["walk", "duck", "walk_curve", "sidestep"])
def test_what_was_made_of_a_clip_becomes_it_again(kind, name):
    clip = MADE[name]
    other = OTHER[kind](clip)
    skeleton, motion = stands(other)
    moved, row = carry(make_body(skeleton, [motion]), body_of(clip), motion, other.name)
    want, got = places(clip.skeleton, clip.motion), places(clip.skeleton, moved)
    away = np.linalg.norm(got - want, axis=-1)
    legs = [
        j for j, n in enumerate(clip.skeleton.names) if n[1:] in ("femur", "tibia", "foot", "toes")
    ]
    assert len(legs) == 8
    assert away[:, legs].max() < 0.006
    # A rest pose along one axis does not say how clavicles and fingers lie: they are a little off.
    joints = [j for j, n in enumerate(clip.skeleton.names) if not n.endswith("_end")]
    assert away[:, joints].mean() < (0.004 if kind == "xsens" else 0.025)
    assert away[:, joints].max() < (0.02 if kind == "xsens" else 0.065)
    # No bone is twisted, also where that does not move a joint: blends would turn it back.
    ends = ("_end", "hand", "thumb", "fingers", "wrist", "joint")
    for joint, part in enumerate(clip.skeleton.names):
        pair = [np.asarray(m.local_rotations)[:, joint] for m in (clip.motion, moved)]
        degrees = np.degrees(quaternion.angle_between(*pair))
        assert degrees.max() < (60.0 if part.endswith(ends) else 20.0), (part, degrees.max())
    assert row.clip == name
    assert row.joints == other.skeleton.num_joints
    assert row.scale == pytest.approx(1 / 1.12 if kind == "mixamo" else 1 / 0.85, abs=0.01)
    assert (row.limits_before, row.limits_after) == (0, 0)
    assert row.foot_slide_after_m <= row.foot_slide_before_m + 1e-6


@pytest.mark.parametrize("name", ["walk", "crouch_jump"])
def test_a_body_of_its_own_changes_nothing(name):
    clip = MADE[name]
    moved, row = carry(body_of(clip), body_of(clip), clip.motion)
    away = places(clip.skeleton, moved) - places(clip.skeleton, clip.motion)
    assert np.abs(away).max() < 0.004
    assert row.scale == 1.0
    assert row.end_error_m < 1e-3


def test_bone_axes_mean_nothing():
    clip = MADE["walk"]
    skeleton, convert = along_y(clip.skeleton)
    motion = convert(clip.motion)
    np.testing.assert_allclose(
        places(skeleton, motion), places(clip.skeleton, clip.motion), atol=1e-5
    )
    assert standing_rest(skeleton) is not None
    got = places(clip.skeleton, retarget(skeleton, motion, clip.skeleton))
    away = np.linalg.norm(got - places(clip.skeleton, clip.motion), axis=-1)
    legs = [
        clip.skeleton.index(n) for n in ("ltibia", "lfoot", "ltoes", "rtibia", "rfoot", "rtoes")
    ]
    assert away[:, legs].max() < 0.006
    # And back: what the skeleton came with is what is written.
    back = retarget(clip.skeleton, clip.motion, skeleton)
    again = np.linalg.norm(places(skeleton, back) - places(skeleton, motion), axis=-1)
    assert again[:, legs].max() < 0.03


def test_a_rest_pose_that_faces_elsewhere():
    clip = MADE["walk_curve"]
    skeleton, motion = turned_rest(clip.skeleton, clip.motion, np.pi)
    assert standing_rest(skeleton) is None
    got = places(clip.skeleton, retarget(skeleton, motion, clip.skeleton))
    assert np.abs(got - places(clip.skeleton, clip.motion)).max() < 0.012


def longer_shins(skeleton: Skeleton) -> Skeleton:
    """Another build: shins 1.3 times as long, wide hips, short thighs, small feet."""
    offsets = np.array(skeleton.offsets, np.float32)
    for side in "lr":
        offsets[skeleton.index(f"{side}foot")] *= 1.3
        offsets[skeleton.index(f"{side}tibia")] *= 0.85
        offsets[skeleton.index(f"{side}femur"), 0] *= 1.6
        offsets[skeleton.index(f"{side}toes")] *= 0.8
    return replace(skeleton, offsets=offsets)


@pytest.mark.parametrize("name", ["walk", "duck", "crouch_jump", "mixed1"])
def test_other_proportions_keep_feet_and_knees(name):
    clip = MADE[name]
    target = make_body(longer_shins(clip.skeleton))
    source = body_of(clip)
    moved, row = carry(source, target, clip.motion)
    before, after = places(clip.skeleton, clip.motion), places(target.skeleton, moved)
    feet = list(foot_joints(clip.skeleton))
    on = planted(before[:, feet], clip.motion.frame_rate)
    assert on.any()
    # Planted feet are where they were, scaled, on the floor, and do not slide.
    want = before[:, feet] * row.scale
    np.testing.assert_allclose(after[:, feet][on], want[on], atol=0.012)
    slid = [np.asarray(floor_steps(p[:, feet]))[stays_planted(on)].sum() for p in (before, after)]
    assert slid[1] <= row.scale * slid[0] + 1e-5 * on.sum()
    assert after[..., 1].min() > -0.01
    for side in ("left", "right"):
        now = bends(target, moved, side)
        assert now.min() > 0.0  # no knee bends to the front
        length = target.thigh_and_shin
        hip, ankle = target.roles[f"{side}_hip"], target.roles[f"{side}_ankle"]
        reach = np.linalg.norm(after[:, ankle] - after[:, hip], axis=-1) / length
        old = np.linalg.norm(before[:, ankle] - before[:, hip], axis=-1) / source.thigh_and_shin
        assert (reach <= np.maximum(old, 0.985) + 2e-3).all()
    # Nothing jerks that did not.
    jerk = [np.abs(np.diff(p[:, 0], 2, axis=0)).max() for p in (before, after)]
    assert jerk[1] < row.scale * jerk[0] + 0.01
    # The root's way is scaled.
    ways = [np.linalg.norm(np.diff(p[:, 0, ::2], axis=0), axis=1).sum() for p in (before, after)]
    assert ways[1] == pytest.approx(row.scale * ways[0], rel=0.02)


def test_straight_knees_do_not_turn_round():
    """A source whose knees hyperextend by noise of a degree."""
    clip = MADE["walk"]
    rng = np.random.default_rng(0)
    local = np.array(clip.motion.local_rotations, np.float64)
    for name in ("ltibia", "rtibia"):
        joint = clip.skeleton.index(name)
        angle = np.radians(rng.normal(0.0, 1.0, len(local)))
        turn = quaternion.from_axis_angle(np.array([[1.0, 0.0, 0.0]]), angle)
        local[: len(local) // 2, joint] = turn[: len(local) // 2]
    motion = replace(clip.motion, local_rotations=local.astype(np.float32))
    source, target = body_of(clip), make_body(longer_shins(clip.skeleton))
    moved, row = carry(source, target, motion)
    half = len(local) // 2
    assert bends(source, motion, "left")[:half].min() < -0.03
    for side in ("left", "right"):
        now = bends(target, moved, side)
        assert now[:half].min() > 0.0
        assert np.abs(np.diff(now[: half - 8])).max() < 0.3
    assert row.limits_after == 0


def test_twist_bones_stay_straight():
    clip = MADE["walk"]
    target = with_twist_bones(clip.skeleton)
    moved = retarget(clip.skeleton, clip.motion, target)
    twists = [j for j, n in enumerate(target.names) if n.endswith("_twist")]
    assert len(twists) == 6
    still = np.asarray(moved.local_rotations)[:, twists]
    np.testing.assert_allclose(still, np.tile([1.0, 0, 0, 0], (*still.shape[:2], 1)), atol=1e-6)
    want = places(clip.skeleton, clip.motion)
    got = places(target, moved)[:, [target.index(n) for n in clip.skeleton.names]]
    assert np.abs(got - want).max() < 0.006
    # From them, too.
    back = places(clip.skeleton, retarget(target, moved, clip.skeleton))
    assert np.abs(back - want).max() < 0.012


def with_twist_bones(skeleton: Skeleton) -> Skeleton:
    """A joint in the middle of each thigh, shin and upper arm."""
    names, parents, offsets = [], [], []
    where: dict[str, int] = {}
    for name, parent, offset in zip(
        skeleton.names, skeleton.parents, np.asarray(skeleton.offsets), strict=True
    ):
        above = where[skeleton.names[parent]] if parent >= 0 else -1
        if name[1:] in ("tibia", "foot", "radius"):
            names.append(f"{skeleton.names[parent]}_twist")
            parents.append(above)
            offset = offset / 2
            offsets.append(offset)
            above = len(names) - 1
        where[name] = len(names)
        names.append(name)
        parents.append(above)
        offsets.append(offset)
    return Skeleton(
        names=tuple(names),
        parents=tuple(parents),
        offsets=np.array(offsets, np.float32),
        end_joints=tuple(where[skeleton.names[j]] for j in skeleton.end_joints),
    )


def test_fingers_and_thumbs_follow_their_names():
    clip = MADE["walk"]
    local = np.array(clip.motion.local_rotations)
    thumb = clip.skeleton.index("lthumb")
    local[:, thumb] = quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(0.7))
    motion = replace(clip.motion, local_rotations=local)
    moved, _ = carry(body_of(clip), make_body(longer_shins(clip.skeleton)), motion)
    np.testing.assert_allclose(moved.local_rotations[:, thumb], local[:, thumb], atol=1e-4)


def test_bones_that_are_not_rigid_are_refused():
    clip = MADE["walk"]
    moving = np.tile(np.asarray(clip.skeleton.offsets), (clip.motion.num_frames, 1, 1))
    with pytest.raises(MotionError, match="rigid"):
        retarget(clip.skeleton, replace(clip.motion, joint_offsets=moving), clip.skeleton)


@pytest.mark.parametrize("frames", [1, 2, 5])
def test_a_few_frames(frames):
    clip = xsens(MADE["walk"])
    motion = replace(
        clip.motion,
        root_translation=clip.motion.root_translation[:frames],
        local_rotations=clip.motion.local_rotations[:frames],
    )
    moved = retarget(clip.skeleton, motion, MADE["walk"].skeleton)
    assert moved.num_frames == frames
    assert np.isfinite(moved.root_translation).all()
    np.testing.assert_allclose(np.linalg.norm(moved.local_rotations, axis=-1), 1.0, atol=1e-5)


def test_feet_of_captured_clips(capture):
    """Each skeleton of the capture on each other: planted feet stay, knees bend one way."""
    files = ("avoidance/cmu14", "locomotion/cmu16", "bandai/set1")
    wanted = ("14_06.amc", "16_16.amc", "walk_normal_001.bvh", "kick_normal_001.bvh")
    paths = [path for folder in files for path in sorted((capture / folder).iterdir())]
    clips = [
        Clip(name=path.name, skeleton=skeleton, motion=motion)
        for path in paths
        if path.name in wanted
        for skeleton, motion in [load_motion(path)]
    ]
    assert len(clips) == 4
    for onto in clips[:1] + clips[-1:]:
        prepared, _ = prepare_clips(
            clips, {}, skeleton=onto.skeleton, frame_rate=30.0, mirrored=False, retarget=True
        )
        rows = [clip.retargeted for clip in prepared if clip.retargeted]
        assert rows
        for row in rows:
            assert row.foot_slide_after_m <= row.foot_slide_before_m + 1e-6, row
            assert row.limits_after <= row.limits_before, row
            assert row.end_error_m < 0.13, row
        skeleton = stands(onto)[0]
        for clip in prepared:
            feet = places(skeleton, clip.motion)[:, list(foot_joints(skeleton)), 1]
            assert -0.02 < np.quantile(feet.min(axis=1), 0.05) < 0.06, clip.name
