"""A motion: the poses of one skeleton at a fixed frame rate, and the simple things done to it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.arrays import Array, namespace
from mgjax.core.body.mirrored import mirror_joints
from mgjax.core.errors import MotionError
from mgjax.core.shown import Shown, like, made_of
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.pytree import register

MOST_OFF = 0.01
"""Of the squared length of a quaternion from 1."""


@register("frame_rate")
@dataclass(frozen=True, kw_only=True)
class Motion(Shown):
    """Poses over time.

    Attributes:
        root_translation: place of the root in the world, m.
        local_rotations: rotation of each joint in its parent's frame, wxyz, unit; the root's is in
            the world. End joints have the identity.
        frame_rate: frames per second.
        joint_offsets: only where bones are not rigid (a file whose joints have moving position
            channels): each joint's place in its parent's frame, m, instead of the skeleton's.
    """

    root_translation: Float[Array, "F 3"]
    local_rotations: Float[Array, "F J 4"]
    frame_rate: float
    joint_offsets: Float[Array, "F J 3"] | None = None

    @property
    def num_frames(self) -> int:
        return self.root_translation.shape[0]

    @property
    def seconds(self) -> float:
        """Frames divided by rate: each frame lasts one period."""
        return self.num_frames / self.frame_rate


def validate_motion(skeleton: Skeleton, motion: Motion) -> None:
    """Raises :class:`MotionError` unless a motion is finite and fits the skeleton."""
    for name in ("root_translation", "local_rotations"):
        if not isinstance(getattr(motion, name), np.ndarray | jax.Array):
            kind = type(getattr(motion, name)).__name__
            raise MotionError(got=f"{name} as a {kind}", expected="an array")
    frames, joints = motion.root_translation.shape[0], skeleton.num_joints
    if motion.local_rotations.shape != (frames, joints, 4):
        raise MotionError(
            f"rotations have shape {motion.local_rotations.shape}, expected {(frames, joints, 4)}"
        )
    if frames < 1:
        raise MotionError("the motion has no frames, expected at least one")
    if not 0 < motion.frame_rate <= 10000:
        raise MotionError(f"frame rate is {motion.frame_rate}, expected 0 … 10000 per second")
    offsets = motion.joint_offsets
    if offsets is not None and offsets.shape != (frames, joints, 3):
        raise MotionError(
            f"joint offsets have shape {offsets.shape}, expected {(frames, joints, 3)}"
        )
    for name in ("root_translation", "local_rotations", "joint_offsets"):
        values = getattr(motion, name)
        if values is None:
            continue
        finite = np.isfinite(np.asarray(values)).reshape(frames, -1).all(axis=1)
        if not finite.all():
            raise MotionError(f"{name} is not finite in frame {int(np.argmin(finite))}")
    rotations = np.asarray(motion.local_rotations)
    off = np.abs((rotations * rotations).sum(-1) - 1) > MOST_OFF
    if off.any():
        frame, joint = np.argwhere(off)[0].tolist()
        length = float(np.linalg.norm(rotations[frame, joint]))
        raise MotionError(
            got=f"a quaternion of length {length:.3g} at joint {joint} in frame {frame}",
            expected="unit quaternions, wxyz",
        )


def cut(motion: Motion, start: int, stop: int) -> Motion:
    """Frames ``start … stop − 1``; :class:`MotionError` outside the motion."""
    if not 0 <= start < stop <= motion.num_frames:
        raise MotionError(f"frames {start}…{stop} of a motion with {motion.num_frames}")
    return _pick(motion, slice(start, stop))


def _pick(motion: Motion, frames: slice) -> Motion:
    offsets = motion.joint_offsets
    picked = replace(
        motion,
        root_translation=motion.root_translation[frames],
        local_rotations=motion.local_rotations[frames],
        joint_offsets=None if offsets is None else offsets[frames],
    )
    return like(picked, motion)


def sample(motion: Motion, frames: Float[Array, " T"]) -> Motion:
    """Poses at fractional frame numbers: the root linearly, rotations by slerp; ends are held."""
    xp = namespace(motion.root_translation, motion.local_rotations, frames)
    last = motion.num_frames - 1
    where = xp.clip(frames, 0, last)
    floor = xp.minimum(xp.floor(where), max(last - 1, 0))
    low = floor.astype("int32")
    high = xp.minimum(low + 1, last)
    t = (where - floor).astype(motion.root_translation.dtype)

    def linear(values: Array) -> Array:
        weight = xp.reshape(t, (-1,) + (1,) * (values.ndim - 1))
        return values[low] * (1 - weight) + values[high] * weight

    rotations = quaternion.slerp(
        motion.local_rotations[low], motion.local_rotations[high], t[:, None]
    )
    offsets = motion.joint_offsets
    poses = replace(
        motion,
        root_translation=linear(motion.root_translation),
        local_rotations=rotations,
        joint_offsets=None if offsets is None else linear(offsets),
    )
    return like(poses, motion)


def resample(motion: Motion, frame_rate: float) -> Motion:
    """A motion at another rate; where the old rate is a multiple of it, frames are picked.

    The result has the frames at 0, 1/rate, 2/rate, … up to the last captured frame.
    """
    if not 0 < frame_rate <= 10000:
        raise MotionError(f"frame rate is {frame_rate}, expected 0 … 10000 per second")
    step = motion.frame_rate / frame_rate
    count = int(np.floor((motion.num_frames - 1) / step + 1e-6)) + 1
    if round(step) >= 1 and abs(step - round(step)) < 1e-6:
        poses = _pick(motion, slice(None, None, round(step)))
    else:
        poses = sample(motion, np.arange(count) * step)
    return like(replace(poses, frame_rate=float(frame_rate)), motion)


def mirror(skeleton: Skeleton, motion: Motion) -> Motion:
    """The motion reflected left–right (x → −x), with left and right joints exchanged.

    Bones keep their lengths, so on a skeleton that is not quite symmetric the result is off by the
    difference of its sides.
    """
    xp = namespace(motion.root_translation, motion.local_rotations)
    twins = np.array(mirror_joints(skeleton))
    flip = xp.asarray(np.array([[[1, 1, -1, -1]]], dtype=motion.local_rotations.dtype))
    flip_x = xp.asarray(np.array([[-1, 1, 1]], dtype=motion.root_translation.dtype))
    offsets = motion.joint_offsets
    mirrored = replace(
        motion,
        root_translation=motion.root_translation * flip_x,
        local_rotations=motion.local_rotations[:, twins] * flip,
        joint_offsets=None if offsets is None else offsets[:, twins] * flip_x[None],
    )
    return made_of(mirrored, skeleton)
