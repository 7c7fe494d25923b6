from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

from mgjax.clips.oddities import (
    Oddity,
    find_oddities,
    first_clean_frame,
    jump_frames,
)
from mgjax.core.motion import Motion, cut, resample
from mgjax.io.load import load_motion


def walking(body, frames: int = 240, rate: float = 120.0) -> Motion:
    """Arms and legs swing, the root goes ahead at 1.5 m/s; nothing odd."""
    time = np.arange(frames) / rate
    rotations = np.tile(np.array([1.0, 0, 0, 0]), (frames, body.num_joints, 1))
    for name, phase in (("lfemur", 0), ("rfemur", np.pi), ("lhumerus", np.pi), ("rhumerus", 0)):
        half = 0.5 * (0.5 + 0.5 * np.sin(2 * np.pi * time + phase))
        rotations[:, body.index(name), 0] = np.cos(half)
        rotations[:, body.index(name), 1] = np.sin(half)
    root = np.stack([0 * time, 0 * time + 1.05, 1.5 * time], axis=-1)
    return Motion(
        root_translation=root.astype(np.float32),
        local_rotations=rotations.astype(np.float32),
        frame_rate=rate,
    )


def with_t_pose(body, motion: Motion, turn: float = 1.2) -> Motion:
    """The arms hang down (turned about z) but for an extra frame 0 in the rest pose."""
    rotations = motion.local_rotations.copy()
    for name, sign in (("lhumerus", -1), ("rhumerus", 1)):
        rotations[:, body.index(name)] = (np.cos(turn / 2), 0, 0, sign * np.sin(turn / 2))
    rest = np.zeros_like(rotations[:1]) + np.array([1, 0, 0, 0], np.float32)
    return replace(
        motion,
        local_rotations=np.concatenate([rest, rotations]),
        root_translation=motion.root_translation[[0, *range(motion.num_frames)]],
    )


def kinds(body, motion) -> list[str]:
    return [oddity.kind for oddity in find_oddities(body, motion)]


def test_nothing_odd(body):
    motion = walking(body)
    assert find_oddities(body, motion) == ()
    assert jump_frames(body, motion).size == 0
    assert first_clean_frame(body, motion) == 0
    assert first_clean_frame(body, motion) == 0
    assert find_oddities(body, cut(motion, 0, 1)) == ()


def test_jump(body):
    motion = walking(body)
    root = motion.root_translation.copy()
    root[100:, 0] += 0.3  # 36 m/s
    jumped = replace(motion, root_translation=root)
    np.testing.assert_array_equal(jump_frames(body, jumped), [100])
    (oddity,) = find_oddities(body, jumped)
    assert (oddity.kind, oddity.frame) == ("jump", 100)
    assert "0.30 m from frame 99 to frame 100 (36 m/s)" in oddity.text
    root = motion.root_translation.copy()
    root[100:, 0] += 0.19  # 23 m/s: a fast hand might
    assert jump_frames(body, replace(motion, root_translation=root)).size == 0
    # At a high rate 25 m/s is a small step: noise.
    root = motion.root_translation.copy()
    root[100:, 0] += 0.14
    assert jump_frames(body, replace(motion, root_translation=root, frame_rate=1000)).size == 0


def test_many_jumps_are_summed_up(body):
    motion = walking(body)
    root = motion.root_translation.copy()
    root[::2, 0] += 1
    found = find_oddities(body, replace(motion, root_translation=root))
    assert [o.kind for o in found] == ["jump"] * 11
    assert "229 more jumps, the last to frame 239" in found[-1].text
    assert jump_frames(body, replace(motion, root_translation=root)).size == 239


@pytest.mark.parametrize("step", [1, 4])
def test_t_pose(body, step):
    motion = with_t_pose(body, walking(body))
    motion = resample(motion, 120 / step)
    assert first_clean_frame(body, motion) > 0
    assert jump_frames(body, motion).size == 0  # the step out of it is not one
    (oddity,) = find_oddities(body, motion)
    assert (oddity.kind, oddity.frame) == ("t_pose_first_frame", 0)
    assert first_clean_frame(body, motion) == 1
    rest = cut(motion, 1, motion.num_frames)
    assert find_oddities(body, rest) == ()


def test_what_is_no_t_pose(body):
    # The motion stays in the rest pose for a while and then moves on smoothly: it continues it.
    motion = walking(body)
    still = replace(motion, local_rotations=np.concatenate(
        [np.tile(motion.local_rotations[:1] * 0 + np.array([1, 0, 0, 0], np.float32), (5, 1, 1)),
         motion.local_rotations[5:]]
    ))  # fmt: skip
    assert first_clean_frame(body, still) == 0
    # A jump to frame 1, but towards the rest pose.
    hanging = with_t_pose(body, walking(body))
    rotations = hanging.local_rotations.copy()
    rotations[[0, 1]] = rotations[[1, 0]]
    swapped = replace(hanging, local_rotations=rotations)
    assert first_clean_frame(body, swapped) == 0
    assert 1 in jump_frames(body, swapped)
    # Two frames in the rest pose, and the first of them elsewhere: frame 1 continues the pose.
    twice = hanging.local_rotations.copy()
    twice[1] = twice[0]
    root = hanging.root_translation.copy()
    root[0, 0] = 3
    both = replace(hanging, local_rotations=twice, root_translation=root)
    assert first_clean_frame(body, both) == 0
    # A jump with no change of pose.
    root = motion.root_translation.copy()
    root[0, 0] = 3
    np.testing.assert_array_equal(jump_frames(body, replace(motion, root_translation=root)), [1])


def test_a_t_pose_that_was_blended_in(body):
    motion = with_t_pose(body, walking(body))
    rotations = motion.local_rotations.copy()
    for frame, share in ((1, 0.6), (2, 0.3), (3, 0.1)):
        mixed = rotations[frame] * (1 - share) + rotations[0] * share
        rotations[frame] = mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)
    blended = replace(motion, local_rotations=rotations)
    assert first_clean_frame(body, blended) > 0
    assert first_clean_frame(body, blended) == 4


def test_feet_under_the_floor(body):
    motion = walking(body)
    root = motion.root_translation.copy()
    root[60:70, 1] -= np.hanning(10) * 0.3
    (oddity,) = find_oddities(body, replace(motion, root_translation=root))
    assert oddity.kind == "feet_under_floor"
    assert 60 < oddity.frame < 70
    assert "0.2" in oddity.text
    # A hand under the floor is no foot.
    names = tuple(n.replace("foot", "paw") for n in body.names)
    assert "feet_under_floor" in kinds(
        replace(body, names=names), replace(motion, root_translation=root)
    )


def test_zero_offsets_and_moving_bones(body):
    motion = walking(body)
    offsets = body.offsets.copy()
    offsets[[0, 3]] = 0  # the root's does not count
    (oddity,) = find_oddities(replace(body, offsets=offsets), motion)
    assert oddity == Oddity("zero_offsets", None, "1 joint has zero offset: lfemur")
    moving = np.tile(body.offsets, (motion.num_frames, 1, 1))
    moving[:, [2, 4], 1] += np.linspace(0, 0.01, motion.num_frames)[:, None]
    (oddity,) = find_oddities(body, replace(motion, joint_offsets=moving))
    assert oddity.kind == "moving_bones"
    assert oddity.text.startswith("2 joints have no fixed place")
    assert oddity.text.endswith("head, ltibia")


def test_real_capture(capture):
    """Two converted files begin with a T-pose that was filtered into the next frames; no other."""
    with (capture / "MANIFEST.csv").open(newline="") as file:
        names = [row["file"] for row in csv.DictReader(file)]
    found = {name: find_oddities(*load_motion(capture / name)) for name in names}
    with_kind = {
        kind: sorted(n for n, all_of in found.items() if any(o.kind == kind for o in all_of))
        for kind in ("t_pose_first_frame", "jump", "moving_bones", "zero_offsets")
    }
    blended = ["ball/cmu135_bvh/135_04.bvh", "ball/cmu135_bvh/135_07.bvh"]
    assert with_kind["t_pose_first_frame"] == blended
    assert with_kind["jump"] == blended
    assert with_kind["moving_bones"] == []
    assert len(with_kind["zero_offsets"]) == 65
    for name in blended:
        skeleton, motion = load_motion(capture / name)
        np.testing.assert_array_equal(jump_frames(skeleton, motion), [2, 3])
        assert first_clean_frame(skeleton, motion) == 8
        clean = cut(motion, 8, motion.num_frames)
        assert first_clean_frame(skeleton, clean) == 0
        assert jump_frames(skeleton, clean).size == 0
