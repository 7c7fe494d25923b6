"""Forward kinematics, one depth level of the skeleton at a time."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from mgjax.core import planar, quaternion
from mgjax.core.arrays import Array, namespace
from mgjax.core.body.heading import across_joints
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton, depth_levels


def forward(
    skeleton: Skeleton,
    root_translation: Float[Array, "*b 3"],
    local_rotations: Float[Array, "*b J 4"],
    joint_offsets: Float[Array, "*b J 3"] | None = None,
) -> tuple[Float[Array, "*b J 3"], Float[Array, "*b J 4"]]:
    """World positions (m) and rotations of all joints.

    A joint's rotation turns its children; its own place comes from its parent's rotation and its
    offset. The root stands at ``root_translation``; its offset is not added. All joints of one
    depth are computed together, which compiles and runs several times faster than joint by joint.
    ``joint_offsets`` replaces the skeleton's offsets where bones are not rigid.
    """
    offsets = skeleton.offsets if joint_offsets is None else joint_offsets
    xp = namespace(root_translation, local_rotations, offsets)
    batch = (1,) * (root_translation.ndim - 1)
    offsets = xp.reshape(offsets, batch + offsets.shape) if offsets.ndim == 2 else offsets
    levels = depth_levels(skeleton.parents)
    positions = [root_translation[..., None, :]]
    rotations = [local_rotations[..., :1, :]]
    for above, level in zip(levels[:-1], levels[1:], strict=True):
        slot = {joint: i for i, joint in enumerate(above)}
        parents = np.array([slot[skeleton.parents[j]] for j in level])
        joints = np.array(level)
        parent_rotation = rotations[-1][..., parents, :]
        positions.append(
            positions[-1][..., parents, :]
            + quaternion.rotate(parent_rotation, offsets[..., joints, :])
        )
        rotations.append(quaternion.multiply(parent_rotation, local_rotations[..., joints, :]))
    order = np.argsort(np.concatenate([np.array(level) for level in levels]))
    return (
        xp.concatenate(positions, axis=-2)[..., order, :],
        xp.concatenate(rotations, axis=-2)[..., order, :],
    )


def global_positions(skeleton: Skeleton, motion: Motion) -> Float[Array, "F J 3"]:
    """World position of every joint in every frame, m."""
    return forward(skeleton, motion.root_translation, motion.local_rotations, motion.joint_offsets)[
        0
    ]


def planar_frames(skeleton: Skeleton, positions: Float[Array, "*b J 3"]) -> Float[Array, "*b 3"]:
    """The planar frame (θ, x, z) of the body for each pose; see :func:`planar.frame_of`."""
    left, right = across_joints(skeleton)
    return planar.frame_of(positions[..., 0, :], positions[..., left, :], positions[..., right, :])


def joint_velocities(positions: Float[Array, "F J 3"], frame_rate: float) -> Float[Array, "F J 3"]:
    """Velocity of each joint, m/s: central differences, one-sided at both ends; one frame: zero."""
    xp = namespace(positions)
    if positions.shape[0] < 2:
        return xp.zeros_like(positions)
    first = (positions[1:2] - positions[:1]) * frame_rate
    last = (positions[-1:] - positions[-2:-1]) * frame_rate
    inner = (positions[2:] - positions[:-2]) * (0.5 * frame_rate)
    return xp.concatenate([first, inner, last], axis=0)
