"""Skeletons and motions of every kind that a format has to carry, and what must come back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.motion import Motion, cut
from mgjax.core.skeleton import Skeleton
from tests.conftest import make_motion, make_skeleton


def _moving_bones() -> tuple[Skeleton, Motion]:
    skeleton = make_skeleton()
    motion = make_motion(skeleton, frames=9)
    shift = np.random.default_rng(1).normal(0, 0.05, (9, skeleton.num_joints, 3))
    shift[:, [0, *skeleton.end_joints]] = 0
    offsets = (np.asarray(skeleton.offsets) + shift).astype(np.float32)
    return skeleton, replace(motion, joint_offsets=offsets)


def _deep_chain() -> tuple[Skeleton, Motion]:
    """More joints than a byte counts."""
    joints = 300
    parents = tuple([-1] + [j - 1 if j % 7 else max(j - 9, 0) for j in range(1, joints)])
    offsets = np.random.default_rng(2).normal(0, 0.1, (joints, 3)).astype(np.float32)
    skeleton = Skeleton(
        names=tuple(f"Bone {j} (ü)" for j in range(joints)), parents=parents, offsets=offsets
    )
    return skeleton, make_motion(skeleton, frames=3, frame_rate=59.94)


def _single() -> tuple[Skeleton, Motion]:
    skeleton = Skeleton(names=("only",), parents=(-1,), offsets=np.ones((1, 3), np.float32))
    return skeleton, make_motion(skeleton, frames=1, frame_rate=25.0)


def _still() -> tuple[Skeleton, Motion]:
    """Nothing moves, and there are zero offsets."""
    skeleton = make_skeleton()
    offsets = np.array(skeleton.offsets)
    offsets[[1, 3]] = 0
    motion = make_motion(skeleton, frames=1)
    return (
        replace(skeleton, offsets=offsets),
        replace(
            motion,
            root_translation=np.repeat(motion.root_translation, 50, axis=0),
            local_rotations=np.repeat(motion.local_rotations, 50, axis=0),
        ),
    )


def _inner_end() -> tuple[Skeleton, Motion]:
    """An end joint that carries another joint."""
    skeleton = replace(make_skeleton(), end_joints=(11, 12, 14))
    return skeleton, make_motion(skeleton, frames=4, frame_rate=1 / 0.0083333)


def _clip() -> tuple[Skeleton, Motion]:
    clip = next(clip for clip in synthetic_clips()[0] if clip.name == "walk")
    return clip.skeleton, cut(clip.motion, 60, 160)


CASES = {
    "random": lambda: (make_skeleton(), make_motion(make_skeleton(), frames=40)),
    "clip": _clip,
    "moving bones": _moving_bones,
    "deep chain": _deep_chain,
    "single": _single,
    "still": _still,
    "inner end": _inner_end,
}
"""By name, a function that makes the skeleton and the motion."""


def assert_same(
    a: tuple[Skeleton, Motion], b: tuple[Skeleton, Motion], *, tolerance: float = 0.0
) -> None:
    """The same numbers, exactly or up to a tolerance; q and −q count as two."""
    assert a[0].names == b[0].names
    assert a[0].parents == b[0].parents
    assert a[0].end_joints == b[0].end_joints
    assert a[1].frame_rate == b[1].frame_rate
    np.testing.assert_allclose(a[0].offsets, b[0].offsets, rtol=0, atol=tolerance)
    for name in ("root_translation", "local_rotations", "joint_offsets"):
        one, other = getattr(a[1], name), getattr(b[1], name)
        assert (one is None) == (other is None), name
        if one is not None:
            assert one.dtype == other.dtype == np.float32
            np.testing.assert_allclose(one, other, rtol=0, atol=tolerance, err_msg=name)
