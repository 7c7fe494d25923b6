"""From places of joints back to local rotations: swing applied, twist kept, bones rigid."""

from __future__ import annotations

from collections.abc import Sequence

from jaxtyping import Float

from mgjax.core import kinematics, quaternion
from mgjax.core.arrays import Array, namespace
from mgjax.core.skeleton import Skeleton


def chain_rotations(
    skeleton: Skeleton,
    root_translation: Float[Array, "*b 3"],
    local_rotations: Float[Array, "*b J 4"],
    chain: Sequence[int],
    joints: Float[Array, "*b K 3"],
    *,
    steady: Sequence[int] = (),
) -> Float[Array, "*b J 4"]:
    """Local rotations that put the joints of a chain where they are wanted.

    Each joint of the chain is turned in the world by the smallest rotation from its old to its new
    bone, so a bone's twist about itself stays as captured. Lengths come from the skeleton: where
    ``joints`` keep them, forward kinematics gives ``joints`` back. A bone of no length follows the
    bone before it.

    Args:
        skeleton: of the pose; its bones are rigid.
        root_translation, local_rotations: the pose.
        chain: indices of joints, each the parent of the next; the first one does not move.
        joints: wanted places of the chain's joints, m.
        steady: joints outside the chain, or its end, that keep their world orientation
            (:func:`mgjax.hybrid.ik.limbs.orientation_locked`).
    """
    xp = namespace(root_translation, local_rotations, joints)
    places, turns = kinematics.forward(skeleton, root_translation, local_rotations)
    new: dict[int, Array] = {}
    swing = None
    first = skeleton.parents[chain[0]]
    one = xp.asarray([1, 0, 0, 0], dtype=turns.dtype)
    nothing = xp.broadcast_to(one, turns[..., 0, :].shape)
    above = nothing if first < 0 else turns[..., first, :]
    for slot, (joint, child) in enumerate(zip(chain, chain[1:], strict=False)):
        old_bone = places[..., child, :] - places[..., joint, :]
        new_bone = joints[..., slot + 1, :] - joints[..., slot, :]
        here = quaternion.from_two_vectors(old_bone, new_bone)
        long = xp.sum(xp.square(old_bone), axis=-1, keepdims=True) > 1e-12
        swing = xp.where(long, here, nothing if swing is None else swing)
        world = quaternion.multiply(swing, turns[..., joint, :])
        new[joint] = quaternion.normalise(quaternion.multiply(quaternion.conjugate(above), world))
        above = quaternion.multiply(above, new[joint])
    return with_local_rotations(skeleton, local_rotations, turns, new, steady)


def with_local_rotations(
    skeleton: Skeleton,
    local_rotations: Float[Array, "*b J 4"],
    turns: Float[Array, "*b J 4"],
    new: dict[int, Array],
    steady: Sequence[int],
) -> Float[Array, "*b J 4"]:
    """The pose with new local rotations of some joints, others steady in the world.

    Args:
        skeleton: of the pose.
        local_rotations: the old pose.
        turns: its world rotations.
        new: local rotations by joint. With a joint also all joints between it and the first of
            them are there.
        steady: joints that keep their world rotation and hang on one of ``new``, or are one.
    """
    xp = namespace(local_rotations, turns)
    columns = [local_rotations[..., joint, :] for joint in range(skeleton.num_joints)]
    world: dict[int, Array] = {}
    for joint in sorted({*new, *steady}):
        parent = skeleton.parents[joint]
        above = world.get(parent, turns[..., max(parent, 0), :])
        if joint in steady:
            back = quaternion.multiply(quaternion.conjugate(above), turns[..., joint, :])
            columns[joint], world[joint] = quaternion.normalise(back), turns[..., joint, :]
        else:
            columns[joint] = new[joint]
            world[joint] = quaternion.multiply(above, new[joint])
    return xp.stack(columns, axis=-2)
