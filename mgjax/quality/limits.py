"""How far joints turn beyond what the capture of that very joint shows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.arrays import Array, namespace
from mgjax.core.body.joint_limits import JointLimits, joint_limits, swing_twist
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True, eq=False)
class CapturedRanges:
    """The angles that capture shows of each joint.

    Attributes:
        joints: all that turn, but the root, whose rotation is that of the body. [n]
        limits: their ranges. [n]
    """

    joints: Int[Array, " n"]
    limits: JointLimits


def captured_ranges(skeleton: Skeleton, rotations: Float[np.ndarray, "F J 4"]) -> CapturedRanges:
    """The ranges of swing and twist over all frames.

    Angles are counted from a joint's mean rotation; its bone points at the middle of its children.

    Args:
        skeleton: of the capture.
        rotations: local ones, of all its frames.
    """
    ends = set(skeleton.end_joints)
    joints = [j for j in range(1, skeleton.num_joints) if j not in ends]
    offsets = np.asarray(skeleton.offsets, np.float64)
    bones = np.zeros((len(joints), 3))
    for row, joint in enumerate(joints):
        children = [j for j, parent in enumerate(skeleton.parents) if parent == joint]
        bones[row] = offsets[children].mean(axis=0) if children else 0.0
    turns = np.asarray(rotations, np.float64)[:, joints]
    moments = np.einsum("fni,fnj->nij", turns, turns)
    centre = np.linalg.eigh(moments)[1][..., -1]
    free = [[-math.pi, math.pi] * 2] * len(joints)
    wide = joint_limits(bones, swing=free, twist=[[-math.pi, math.pi]] * len(joints), centre=centre)
    swing, twist = (np.asarray(angles) for angles in swing_twist(turns, wide))
    low, high = swing.min(axis=0), swing.max(axis=0)
    limits = JointLimits(
        centre=wide.centre,
        bone=wide.bone,
        across=wide.across,
        swing=np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], axis=-1).astype(np.float32),
        twist=np.stack([twist.min(axis=0), twist.max(axis=0)], axis=-1).astype(np.float32),
    )
    return CapturedRanges(joints=np.array(joints, np.int32), limits=limits)


def beyond(rotations: Float[Array, "*b J 4"], ranges: CapturedRanges) -> Float[Array, "*b n 2"]:
    """Degrees by which each joint is outside its range, in swing and in twist; 0 inside.

    Gradients are finite everywhere.
    """
    xp = namespace(rotations, ranges.limits.swing)
    turns = rotations[..., ranges.joints, :]
    swing, twist = swing_twist(turns, ranges.limits)
    box = _like(ranges.limits.swing, swing)
    span = _like(ranges.limits.twist, swing)
    over = xp.maximum(box[..., 0::2] - swing, 0.0) + xp.maximum(swing - box[..., 1::2], 0.0)
    swung = xp.sqrt(xp.maximum(xp.sum(over * over, axis=-1), 1e-16))
    # Half a turn to either side is the same twist.
    middle, half = (span[..., 0] + span[..., 1]) / 2, (span[..., 1] - span[..., 0]) / 2
    off = twist - middle
    off = off - 2 * math.pi * xp.round(off / (2 * math.pi))
    turned = xp.maximum(xp.abs(off) - half, 0.0)
    return xp.stack([xp.where(swung > 1e-8, swung, 0.0), turned], axis=-1) * (180 / math.pi)


def _like(values: Array, angles: Array) -> Array:
    """The ranges with the rank and type of the angles."""
    xp = namespace(values, angles)
    return xp.asarray(values, dtype=angles.dtype).reshape((1,) * (angles.ndim - 2) + values.shape)
