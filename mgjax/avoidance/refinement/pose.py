"""Poses with their channels changed: joints turn, and legs keep their feet where they are."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.refinement.rig import Rig
from mgjax.core import quaternion, two_bone
from mgjax.core.arrays import Array, namespace
from mgjax.core.kinematics import forward


def changed(
    rig: Rig,
    root: Float[Array, "*b 3"],
    rotations: Float[Array, "*b J 4"],
    channels: Float[Array, "*b C"],
    ankles: Float[Array, "*b L 3"],
    feet: Float[Array, "*b L 4"],
) -> tuple[Float[Array, "*b 3"], Float[Array, "*b J 4"]]:
    """Root and local rotations of poses whose channels are changed.

    Root and trunk are turned first. Then the legs are bent in two-bone inverse kinematics until
    each ankle is at its old place plus what its own channel says; feet keep their orientation.

    Args:
        rig: the channels.
        root, rotations: the poses.
        channels: see :class:`~mgjax.avoidance.refinement.rig.Rig`.
        ankles, feet: places and world rotations of the ankles of ``rig.legs`` in those poses.
    """
    xp = namespace(root, rotations, channels)
    groups, legs = len(rig.groups), len(rig.legs)
    vectors = channels[..., 3 : 3 + 3 * groups]
    vectors = vectors.reshape(*vectors.shape[:-1], groups, 3)
    shares = xp.asarray(rig.shares, dtype=channels.dtype)
    turns = xp.einsum("...gx,gj->...jx", vectors, shares)
    turned = quaternion.multiply(rotations, quaternion.exp(turns))
    moved = root + channels[..., :3]
    if not legs:
        return moved, turned
    places, world = forward(rig.skeleton, moved, turned)
    shift = channels[..., 3 + 3 * groups :]
    targets = ankles + shift.reshape(*shift.shape[:-1], legs, 3)
    hips, knees, ends = (np.array(joints) for joints in zip(*rig.legs, strict=True))
    pole = quaternion.rotate(world[..., knees, :], _ahead(rig, xp, channels))
    hip_turn, knee_turn = two_bone.solve(
        places[..., hips, :], places[..., knees, :], places[..., ends, :], targets, pole
    )
    parents = [
        np.array([rig.skeleton.parents[j] for j in joints]) for joints in (hips, knees, ends)
    ]
    local = two_bone.local_rotations(
        hip_turn,
        knee_turn,
        (world[..., parents[0], :], world[..., parents[1], :], world[..., parents[2], :]),
        (world[..., hips, :], world[..., knees, :], feet),
    )
    joints = rotations.shape[-2]
    order = np.arange(joints)
    order[np.concatenate([hips, knees, ends])] = joints + np.arange(3 * legs)
    return moved, xp.concatenate([turned, *local], axis=-2)[..., order, :]


def ankles_of(
    rig: Rig, root: Float[Array, "*b 3"], rotations: Float[Array, "*b J 4"]
) -> tuple[Float[Array, "*b L 3"], Float[Array, "*b L 4"]]:
    """Places, m, and world rotations of the ankles of a rig's legs."""
    places, world = forward(rig.skeleton, root, rotations)
    ends = np.array([leg[2] for leg in rig.legs], dtype=np.int64)
    return places[..., ends, :], world[..., ends, :]


def _ahead(rig: Rig, xp: object, like: Array) -> Array:
    """Where a knee points in its own frame where the leg is straight: ahead in the rest pose."""
    ahead = np.tile(np.array([0.0, 0.0, 1.0]), (len(rig.legs), 1))
    ahead = ahead.reshape((1,) * (like.ndim - 1) + ahead.shape)
    return namespace(like).asarray(ahead, dtype=like.dtype)
