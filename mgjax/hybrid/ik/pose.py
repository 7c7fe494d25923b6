"""A pose whose hands and head are where they are wanted."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Float, Int

from mgjax.core import kinematics
from mgjax.core.arrays import Array
from mgjax.core.body.joint_limits import JointLimits
from mgjax.core.calls.door import takes_not_finite
from mgjax.core.errors import SkeletonError
from mgjax.core.skeleton import Skeleton
from mgjax.hybrid.ik.chain import fabrik
from mgjax.hybrid.ik.limbs import Limb, orientation_locked
from mgjax.hybrid.ik.rotations import chain_rotations, with_local_rotations
from mgjax.hybrid.ik.tree import fabrik_tree


def moved_joints(limbs: tuple[Limb, ...]) -> tuple[int, ...]:
    """The joints of all limbs, each once, parents first: the order of limits for them."""
    return tuple(sorted({joint for limb in limbs for joint in limb.joints}))


@takes_not_finite
@partial(jax.jit, static_argnames=("limbs", "max_iterations"))
def reach_pose(
    skeleton: Skeleton,
    root_translation: Float[Array, "*b 3"],
    local_rotations: Float[Array, "*b J 4"],
    targets: Float[Array, "*b E 3"],
    *,
    limbs: tuple[Limb, ...],
    limits: JointLimits | None = None,
    tolerance: float | Float[Array, ""] = 1e-3,
    max_iterations: int = 16,
) -> tuple[Float[Array, "*b J 4"], Int[Array, "*b E"]]:
    """Local rotations with which the ends of ``limbs`` are at ``targets``.

    One limb without limits is a chain (:func:`mgjax.hybrid.ik.chain.fabrik`), solved in closed
    form where it must be; several limbs share the torso and are a tree, as is a limb with limits
    (:func:`mgjax.hybrid.ik.tree.fabrik_tree`). Root and legs stay as they are. What moves
    along with the torso keeps its orientation in the world where it has no target of its own
    (:func:`mgjax.hybrid.ik.limbs.orientation_locked`).

    Args:
        skeleton: of the pose; its bones are rigid.
        root_translation, local_rotations: the poses.
        targets: wanted places of the limbs' ends, in their order, m.
        limbs: different ones.
        limits: of :func:`moved_joints`, in that order, or None for none.
        tolerance: m.
        max_iterations: of FABRIK's stages.

    Returns:
        ``(local_rotations, status)``, the status of each limb.

    Raises:
        SkeletonError: a limb is given twice, or one ends inside another.
    """
    steady = orientation_locked(skeleton, limbs)
    if len(limbs) == 1 and limits is None:
        chain = limbs[0].joints
        places, _ = kinematics.forward(skeleton, root_translation, local_rotations)
        joints, status = fabrik(
            places[..., jnp.array(chain), :],
            targets[..., 0, :],
            tolerance=tolerance,
            max_iterations=max_iterations,
        )
        solved = chain_rotations(
            skeleton, root_translation, local_rotations, chain, joints, steady=steady
        )
        return solved, status[..., None]
    moved = moved_joints(limbs)
    ends = tuple(moved.index(limb.joints[-1]) for limb in limbs)
    above = tuple(skeleton.parents[joint] for joint in moved)
    parents = tuple(moved.index(p) if p in moved else -1 for p in above)
    if len(set(ends)) < len(ends) or any(end in parents for end in ends):
        names = ", ".join(limb.name for limb in limbs)
        raise SkeletonError(f"limbs are {names}, expected each once, none inside another")
    if parents.count(-1) > 1:
        names = ", ".join(limb.name for limb in limbs)
        raise SkeletonError(f"limbs {names} share no joint below the root")
    places, turns = kinematics.forward(skeleton, root_translation, local_rotations)
    index = jnp.array(moved)
    rotations, status = fabrik_tree(
        jnp.asarray(skeleton.offsets)[index],
        places[..., moved[0], :],
        local_rotations[..., index, :],
        targets,
        parents=parents,
        ends=ends,
        frame=turns[..., above[0], :],
        limits=limits,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
    solved = with_local_rotations(
        skeleton,
        local_rotations,
        turns,
        dict(zip(moved, jnp.moveaxis(rotations, -2, 0), strict=True)),
        steady,
    )
    return solved, status
