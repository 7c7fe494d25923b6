"""Joint limits: how far a bone may swing away from its place, and how far it may turn about itself.

After Aristidou and Lasenby 2011, section 4: the *rotor* limits the turn of a bone about itself, and
the bone may *swing* inside a cone with up to four angles (a hinge where two of them are zero).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.arrays import Array, namespace
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True)
class JointLimits:
    """Limits of n joints, each relative to a centre.

    A local rotation is ``centre · swing · twist``: first the twist about the bone, then the swing,
    whose rotation vector is square to the bone.

    Attributes:
        centre: local rotation from which angles are counted. [n, 4]
        bone: unit vector along the bone in the joint's own frame. [n, 3]
        across: unit vector square to the bone: the first axis of swing; the second is
            ``bone × across``. [n, 3]
        swing: lowest and highest angle about the first axis, then about the second, rad; the lowest
            −π … 0, the highest 0 … π. [n, 4]
        twist: lowest and highest angle about the bone, rad. [n, 2]
    """

    centre: Float[Array, "n 4"]
    bone: Float[Array, "n 3"]
    across: Float[Array, "n 3"]
    swing: Float[Array, "n 4"]
    twist: Float[Array, "n 2"]


def joint_limits(
    bones: Float[Array, "n 3"],
    *,
    swing: Sequence[Sequence[float]],
    twist: Sequence[Sequence[float]],
    across: Sequence[Sequence[float]] | None = None,
    centre: Float[Array, "n 4"] | None = None,
) -> JointLimits:
    """Limits from angles; see :class:`JointLimits`.

    Args:
        bones: vectors along the bones in the joints' frames, of any length; for a zero vector
            the y axis is taken.
        swing: four angles for each joint, rad; ``(low, high, 0, 0)`` is a hinge about ``across``.
        twist: two angles for each joint, rad.
        across: first axes of swing; made square to the bones. Default: any.
        centre: default: the identity, the rest pose.
    """
    vectors = np.array(bones, np.float64)
    count = len(vectors)
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    bone = np.where(lengths > 1e-9, vectors / np.maximum(lengths, 1e-9), [[0.0, 1.0, 0.0]])
    if across is None:
        first = np.where(np.abs(bone[:, :1]) < 0.6, [[1.0, 0, 0]], [[0, 1.0, 0]])
    else:
        first = np.array(across, np.float64)
    first = first - np.sum(first * bone, axis=-1, keepdims=True) * bone
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    middle = np.tile([1.0, 0, 0, 0], (count, 1)) if centre is None else np.array(centre)
    return JointLimits(
        centre=middle.astype(np.float32),
        bone=bone.astype(np.float32),
        across=first.astype(np.float32),
        swing=np.array(swing, np.float32),
        twist=np.array(twist, np.float32),
    )


def swing_twist(
    rotations: Float[Array, "*b n 4"], limits: JointLimits
) -> tuple[Float[Array, "*b n 2"], Float[Array, "*b n"]]:
    """Angles of swing about the two axes, and of twist, of local rotations, rad."""
    centre, bone, across, second = _axes(limits, rotations)
    xp = namespace(rotations, centre)
    q = quaternion.multiply(quaternion.conjugate(centre), rotations)
    along = xp.sum(q[..., 1:] * bone, axis=-1)
    size = xp.sqrt(q[..., 0] ** 2 + along**2)
    half_turn = size < 1e-6  # of swing: then there is no twist
    w = xp.where(half_turn, 1.0, q[..., 0]).astype(q.dtype)
    along = xp.where(half_turn, 0.0, along).astype(q.dtype)
    back = quaternion.normalise(xp.concatenate([w[..., None], -along[..., None] * bone], axis=-1))
    swing = quaternion.multiply(q, back)
    swing = xp.where(swing[..., :1] < 0, -swing, swing)
    sine = xp.sqrt(xp.maximum(xp.sum(swing[..., 1:] ** 2, axis=-1), 1e-16))
    angle = 2 * xp.arctan2(sine, swing[..., 0]) / sine
    angles = [angle * xp.sum(swing[..., 1:] * axis, axis=-1) for axis in (across, second)]
    turn = 2 * xp.arctan2(along, w)
    turn = turn - 2 * math.pi * xp.round(turn / (2 * math.pi))
    return xp.stack(angles, axis=-1), turn


def from_swing_twist(
    swing: Float[Array, "*b n 2"], twist: Float[Array, "*b n"], limits: JointLimits
) -> Float[Array, "*b n 4"]:
    """Local rotations of angles; the inverse of :func:`swing_twist`."""
    centre, bone, across, second = _axes(limits, swing)
    xp = namespace(swing, centre)
    vector = swing[..., :1] * across + swing[..., 1:] * second
    angle = xp.sqrt(xp.maximum(xp.sum(vector**2, axis=-1), 1e-16))
    turned = quaternion.from_axis_angle(vector / angle[..., None], angle)
    spun = quaternion.from_axis_angle(bone, twist)
    return quaternion.multiply(centre, quaternion.multiply(turned, spun))


def clamp(rotations: Float[Array, "*b n 4"], limits: JointLimits) -> Float[Array, "*b n 4"]:
    """The rotations brought inside the limits; those inside stay as they are.

    Deviation:
        The paper projects the bone's direction on a plane across the cone and takes the nearest
        point of a conic, which only works below 90°. Here the swing's rotation vector is held
        inside an ellipse with the four angles as half axes, quadrant by quadrant: first inside its
        box, then radially. That is defined up to 180°, and exact for hinges.
    """
    swing, twist = swing_twist(rotations, limits)
    xp = namespace(swing, limits.swing)
    batch = (1,) * (swing.ndim - 2)
    box = xp.reshape(xp.asarray(limits.swing), (*batch, *limits.swing.shape))
    span = xp.reshape(xp.asarray(limits.twist), (*batch, *limits.twist.shape))
    low, high = box[..., 0::2], box[..., 1::2]
    half = xp.maximum(xp.where(swing < 0, -low, high), 1e-6)
    boxed = xp.clip(swing, low, high)
    square = xp.sum((boxed / half) ** 2, axis=-1, keepdims=True)
    held = boxed / xp.sqrt(xp.maximum(square, 1.0))
    turned = xp.clip(twist, span[..., 0], span[..., 1])
    moved = xp.max(xp.abs(held - swing), axis=-1) + xp.abs(turned - twist)
    bounded = from_swing_twist(held, turned, limits)
    return xp.where((moved > 1e-6)[..., None], bounded, rotations)


def random_rotations(
    generator: np.random.Generator, count: int, limits: JointLimits
) -> Float[np.ndarray, "count n 4"]:
    """Poses inside the limits, uniform in the angles' ellipses and ranges."""
    joints = limits.swing.shape[0]
    box, span = np.asarray(limits.swing, np.float64), np.asarray(limits.twist, np.float64)
    around = generator.uniform(0, 2 * np.pi, (count, joints))
    radius = np.sqrt(generator.uniform(0, 1, (count, joints)))
    point = np.stack([np.cos(around), np.sin(around)], axis=-1) * radius[..., None]
    swing = point * np.where(point < 0, -box[:, 0::2], box[:, 1::2])
    twist = generator.uniform(span[:, 0], span[:, 1], (count, joints))
    return np.asarray(from_swing_twist(swing, twist, limits), np.float32)


def _axes(limits: JointLimits, like: Array) -> tuple[Array, Array, Array, Array]:
    """Centre, bone, and both axes of swing, with the rank of ``like``."""
    xp = namespace(limits.bone, limits.across, like)
    batch = (1,) * (like.ndim - 2)
    bone, across = xp.asarray(limits.bone), xp.asarray(limits.across)
    bx, by, bz = (bone[..., i] for i in range(3))
    ax, ay, az = (across[..., i] for i in range(3))
    second = xp.stack([by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax], axis=-1)
    parts = (xp.asarray(limits.centre), bone, across, second)
    centre, bone, across, second = (xp.reshape(v, (*batch, *v.shape)) for v in parts)
    return centre, bone, across, second
