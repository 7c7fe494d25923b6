from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.folder import load_clips
from mgjax.clips.oddities import first_clean_frame
from mgjax.clips.prepare import prepare_clips
from mgjax.clips.types import Clip, Label
from mgjax.core.contacts import foot_joints, planted
from mgjax.core.errors import MotionError, SkeletonError
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, cut, mirror
from mgjax.core.skeleton import Skeleton
from mgjax.io.load import load_motion
from tests.conftest import make_skeleton

BODY = make_skeleton()


def calm(frames: int = 60, *, frame_rate: float = 30.0, lift: float = 0.0) -> Motion:
    """Arms up, swaying a little: nowhere near the rest pose and without jumps."""
    t = np.arange(frames) / frame_rate
    rotations = np.tile(np.float32([1, 0, 0, 0]), (frames, BODY.num_joints, 1))
    angle = 1.2 + 0.05 * np.sin(2 * np.pi * 0.5 * t)
    for name in ("lhumerus", "rhumerus", "thorax", "lfemur", "rfemur"):
        j = BODY.index(name)
        rotations[:, j] = np.stack([np.cos(angle), np.sin(angle), 0 * t, 0 * t], axis=1)
    root = np.stack([0.2 * t, 1.0 + lift + 0 * t, 0 * t], axis=1).astype(np.float32)
    return Motion(root_translation=root, local_rotations=rotations, frame_rate=frame_rate)


def label(start: float, end: float, kind: str = "duck", direction: str = "") -> Label:
    return Label(start_s=start, end_s=end, kind=kind, direction=direction)


def prepare(motion: Motion, labels=(), *, rate: float = 30.0, mirrored=False, skeleton=BODY):
    clip = Clip(name="c", skeleton=BODY, motion=motion)
    return prepare_clips(
        [clip], {"c": tuple(labels)}, skeleton=skeleton, frame_rate=rate, mirrored=mirrored
    )


def joined(*parts: Motion) -> Motion:
    return replace(
        parts[0],
        root_translation=np.concatenate([p.root_translation for p in parts]),
        local_rotations=np.concatenate([p.local_rotations for p in parts]),
    )


def rest(motion: Motion) -> Motion:
    """One frame of the rest pose where the motion begins."""
    one = cut(motion, 0, 1)
    still = np.tile(np.float32([1, 0, 0, 0]), (1, BODY.num_joints, 1))
    return replace(one, local_rotations=still)


def test_a_clip_that_needs_nothing():
    motion = calm()
    (clip,), notes = prepare(motion, [label(1.0, 1.5, direction="left"), label(0.2, 0.6)])
    assert clip.name == "c"
    assert notes == []
    np.testing.assert_array_equal(clip.motion.root_translation, motion.root_translation)
    np.testing.assert_array_equal(clip.motion.local_rotations, motion.local_rotations)
    np.testing.assert_array_equal(clip.label_frames, [[6, 18], [30, 45]])
    assert [x.direction for x in clip.labels] == ["", "left"]
    assert prepare(motion)[0][0].label_frames.shape == (0, 2)


def test_labels_at_another_rate():
    (clip,), _ = prepare(calm(240, frame_rate=120.0), [label(0.51, 0.99)])
    assert clip.motion.frame_rate == 30.0
    assert clip.motion.num_frames == 60
    np.testing.assert_array_equal(clip.label_frames, [[15, 30]])


@pytest.mark.parametrize("rate", [10.0, 15.0, 27.0, 30.0, 50.0, 120.0])
@pytest.mark.parametrize("frames", [29, 30, 31, 40])
def test_a_label_to_the_end_of_its_clip_stays(rate, frames):
    motion = calm(frames, frame_rate=rate)
    (clip,), notes = prepare(motion, [label(0.0, frames / rate)])
    assert notes == []
    # Frames are picked at 0, 1/30 s, …, so the last may stand for more than the label's end.
    end = min(round(frames / rate * 30.0), clip.motion.num_frames)
    assert end >= clip.motion.num_frames - 1
    np.testing.assert_array_equal(clip.label_frames, [[0, end]])


def test_a_label_without_a_frame_is_noted():
    (clip,), notes = prepare(calm(240, frame_rate=120.0), [label(0.505, 0.515), label(1.0, 1.2)])
    np.testing.assert_array_equal(clip.label_frames, [[30, 36]])
    assert notes == [
        "c: label 0.505 … 0.515 s left out, there is a jump in it or no frame at 30 Hz"
    ]


def test_a_t_pose_is_cut_off_and_labels_shift():
    motion = calm()
    (clip,), notes = prepare(joined(rest(motion), motion), [label(0.0, 0.2), label(1.0, 1.5)])
    assert notes == ["c: T-pose in the first frame cut off"]
    assert clip.name == "c"
    np.testing.assert_array_equal(clip.motion.local_rotations, motion.local_rotations)
    np.testing.assert_array_equal(clip.label_frames, [[0, 5], [29, 44]])


def test_frames_with_a_trace_of_the_t_pose_go_with_it():
    motion = calm(240, frame_rate=120.0)
    still = rest(motion)
    traces = []
    for share in (0.4, 0.7, 0.9):  # as a filter of the angles leaves them
        mixed = still.local_rotations * (1 - share) + motion.local_rotations[:1] * share
        mixed /= np.linalg.norm(mixed, axis=-1, keepdims=True)
        traces.append(replace(still, local_rotations=mixed.astype(np.float32)))
    whole = joined(still, *traces, motion)
    assert first_clean_frame(BODY, whole) == 4
    (clip,), notes = prepare(whole, [label(0.5, 1.0)])
    assert notes == ["c: T-pose in the first frame cut off, with 3 frames that have a trace of it"]
    np.testing.assert_array_equal(clip.motion.local_rotations, motion.local_rotations[::4])
    np.testing.assert_array_equal(clip.label_frames, [[14, 29]])


def test_a_clip_is_split_where_it_jumps():
    a, b = calm(30), calm(40)
    far = replace(b, root_translation=b.root_translation + np.float32([0, 0, 4]))
    labels = [
        label(0.2, 0.6, "a"),
        label(0.9, 1.1, "b"),
        label(1.0, 1.0 + 1 / 3, "c"),
        label(2, 2.3),
    ]
    labels = [x for x in labels if x.kind != "c"]
    pieces, notes = prepare(joined(a, far), labels)
    assert [p.name for p in pieces] == ["c#0", "c#1"]
    np.testing.assert_array_equal(pieces[0].motion.root_translation, a.root_translation)
    np.testing.assert_array_equal(pieces[1].motion.root_translation, far.root_translation)
    assert "c: split where it jumps, at 1.00 s" in notes
    assert "c: label 0.9 … 1.1 s left out, there is a jump in it or no frame at 30 Hz" in notes
    np.testing.assert_array_equal(pieces[0].label_frames, [[6, 18]])
    np.testing.assert_array_equal(pieces[1].label_frames, [[30, 39]])


def test_labels_that_touch_a_jump_stay():
    a, b = calm(30), calm(40)
    far = replace(b, root_translation=b.root_translation + np.float32([0, 0, 4]))
    pieces, notes = prepare(joined(a, far), [label(0.5, 1.0, "a"), label(1.0, 1.5, "b")])
    assert len(notes) == 1
    np.testing.assert_array_equal(pieces[0].label_frames, [[15, 30]])
    np.testing.assert_array_equal(pieces[1].label_frames, [[0, 15]])


def test_mirrored_copies():
    motion = calm()
    items = [label(0.2, 0.6, direction="left"), label(1.0, 1.5, direction="right")]
    (plain, other), notes = prepare(motion, [*items, label(1.6, 1.8)], mirrored=True)
    assert (plain.name, other.name) == ("c", "c~mirrored")
    assert notes == ["1 clips mirrored left-right"]
    assert [x.direction for x in other.labels] == ["right", "left", ""]
    assert [x.direction for x in plain.labels] == ["left", "right", ""]
    np.testing.assert_array_equal(plain.label_frames, other.label_frames)
    want = mirror(BODY, motion)
    np.testing.assert_array_equal(other.motion.local_rotations, want.local_rotations)
    np.testing.assert_array_equal(other.motion.root_translation, want.root_translation)


def scaled(factor: float) -> Skeleton:
    return replace(BODY, offsets=BODY.offsets * np.float32(factor))


def test_another_body_of_the_same_build():
    motion = calm()
    (clip,), _ = prepare(motion, skeleton=scaled(1.25))
    np.testing.assert_allclose(clip.motion.root_translation, 1.25 * motion.root_translation)
    np.testing.assert_array_equal(clip.motion.local_rotations, motion.local_rotations)
    # Everything is 1.25 times as large, so the floor is where it was.
    np.testing.assert_allclose(
        global_positions(scaled(1.25), clip.motion),
        1.25 * global_positions(BODY, motion),
        atol=1e-5,
    )


def test_only_the_legs_decide():
    longer = BODY.offsets.copy()
    longer[BODY.index("lhumerus")] *= 2
    longer[BODY.index("head")] *= 2
    motion = calm()
    (clip,), _ = prepare(motion, skeleton=replace(BODY, offsets=longer))
    np.testing.assert_array_equal(clip.motion.root_translation, motion.root_translation)


def test_skeletons_without_known_legs_are_not_scaled():
    names = tuple(f"j{i}" for i in range(BODY.num_joints))
    one, two = replace(BODY, names=names), replace(scaled(2.0), names=names)
    clip = Clip(name="c", skeleton=one, motion=calm())
    (prepared,), _ = prepare_clips([clip], {}, skeleton=two, frame_rate=30.0, mirrored=False)
    np.testing.assert_array_equal(prepared.motion.root_translation, clip.motion.root_translation)


def test_what_is_refused():
    names = tuple(n.replace("head", "skull") for n in BODY.names)
    clip = Clip(name="c", skeleton=replace(BODY, names=names), motion=calm())
    with pytest.raises(SkeletonError, match="c: got joint 'skull' where the reference has 'head'"):
        prepare_clips([clip], {}, skeleton=BODY, frame_rate=30.0, mirrored=False)
    offsets = np.zeros((60, BODY.num_joints, 3), np.float32)
    offsets[:] = BODY.offsets
    offsets[30, 4, 0] += 0.1
    message = f"c: got '{BODY.names[4]}' moving by up to 0.10 m in its parent's frame, expected"
    with pytest.raises(MotionError, match=message):
        prepare(replace(calm(), joint_offsets=offsets))


def test_a_joint_that_slides_a_little_is_held_still():
    offsets = np.tile(BODY.offsets, (60, 1, 1))
    offsets[:20, 4, 0] += 0.02
    (prepared,), notes = prepare(replace(calm(), joint_offsets=offsets))
    assert prepared.motion.joint_offsets is None
    assert any("1 joints slide in their parent's frame by up to 2.0 cm" in n for n in notes)


@pytest.mark.parametrize(
    ("source", "target"),
    [
        ("avoidance/cmu127", "avoidance/cmu14/14_02.amc"),
        ("locomotion/cmu16", "avoidance/cmu127/127_02.amc"),
        ("ball/cmu135", "avoidance/cmu127/127_02.amc"),
    ],
)
def test_feet_of_another_subject_stay_on_the_floor(capture, source, target):
    skeleton, _ = load_motion(capture / target)
    clips, _ = load_clips(capture / source)
    prepared, _ = prepare_clips(clips, {}, skeleton=skeleton, frame_rate=30.0, mirrored=False)
    feet = list(foot_joints(skeleton))
    moved, unscaled = [], []
    for clip, result in zip(clips, prepared, strict=True):
        np.testing.assert_array_equal(
            result.motion.local_rotations, clip.motion.local_rotations[::4]
        )
        before = np.asarray(global_positions(clip.skeleton, clip.motion))[:, feet]
        on = planted(before, clip.motion.frame_rate)[::4]
        for motion, found in ((result.motion, moved), (clip.motion, unscaled)):
            height = np.asarray(global_positions(skeleton, motion))[:, feet, 1]
            step = len(before) // len(height)
            found.append((height[:: 4 // step] - before[::4, :, 1])[on])
    away = np.abs(np.concatenate(moved))
    assert np.mean(away) < 0.012
    assert np.quantile(away, 0.95) < 0.02
    assert np.mean(away) < 0.8 * np.mean(np.abs(np.concatenate(unscaled)))
