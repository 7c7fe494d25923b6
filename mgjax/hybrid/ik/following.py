"""How a solved pose changes with what it was solved for.

The search for a pose has loops of unknown length and starts over; its result does not depend on how
it was found: the ends are at the targets. As the targets move, the pose follows by the smallest
turns that keep the ends there, and as the start changes, the pose changes with it and then follows.
That is differentiable forwards and backwards, at the cost of one least-squares step.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.body.joint_limits import JointLimits, clamp
from mgjax.hybrid.ik.tree_steps import TreeProblem, place

_DAMPING = 1e-7
"""Least damping, m²: a straight chain cannot follow along its line."""

_PROBE = 1e-2
"""Angle by which a joint is turned to see whether its limits allow it, rad."""


@jax.custom_jvp
def following(
    problem: TreeProblem,
    given: Float[Array, "n 4"],
    limits: JointLimits | None,
    solved: Float[Array, "n 4"],
) -> Float[Array, "n 4"]:
    """The solved pose as a function of the problem and of the pose that it began with.

    Joints do not turn where their limits forbid it in either sense. Ends that are not at their
    targets follow less, the farther they are off: their damping is half the square of the miss.
    """
    return solved


@following.defjvp
def _following_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    problem, given, limits, solved = primals
    solved = following(problem, given, limits, solved)
    pose = jax.lax.stop_gradient(solved)
    free = _freedom(pose, limits)

    def moved(problem: TreeProblem, given: Array) -> Array:
        begun = quaternion.multiply(quaternion.conjugate(jax.lax.stop_gradient(given)), given)
        carried = quaternion.multiply(pose, begun)
        places, turns = place(problem, carried)
        miss = (problem.targets - places[problem.ends]).reshape(-1)
        jacobian = jax.lax.stop_gradient(_jacobian(problem, places, turns))
        loose = jnp.einsum("anj,njk->ank", jacobian, free)
        square = jnp.einsum("ank,bnk->ab", loose, loose)
        off = jax.lax.stop_gradient(miss)
        damping = 0.5 * jnp.sum(off * off) + _DAMPING
        square = square + damping * jnp.eye(len(off), dtype=square.dtype)
        force = jnp.linalg.solve(square, miss - off)
        turn = jnp.einsum("njk,ank,a->nj", free, loose, force)
        half = jnp.concatenate([jnp.ones_like(turn[:, :1]), turn / 2], axis=-1)
        return quaternion.multiply(carried, quaternion.normalise(half))

    _, change = jax.jvp(moved, (problem, given), tangents[:2])
    return solved, change


def _jacobian(problem: TreeProblem, places: Array, turns: Array) -> Float[Array, "A n 3"]:
    """How the ends move as joints turn about their own axes; the ends' components first."""
    arms = jnp.where(problem.below[..., None], places[problem.ends][None] - places[:, None], 0.0)
    axes = quaternion.rotate(turns[:, None], jnp.eye(3, dtype=places.dtype)[None])
    moves = jnp.cross(axes[:, None], arms[:, :, None])  # [n, E, axis, 3]
    count, ends = arms.shape[:2]
    return jnp.transpose(moves, (1, 3, 0, 2)).reshape(3 * ends, count, 3)


def _freedom(pose: Array, limits: JointLimits | None) -> Float[Array, "n 3 3"]:
    """What limits leave of small turns about each joint's own axes; columns by axis."""
    axes = jnp.eye(3, dtype=pose.dtype)
    if limits is None:
        return jnp.broadcast_to(axes, (len(pose), 3, 3))

    def left(sign: float) -> Array:
        def one(axis: Array) -> Array:
            spin = quaternion.from_axis_angle(sign * axis, jnp.asarray(_PROBE, pose.dtype))
            held = clamp(quaternion.multiply(pose, spin[None]), limits)
            turned = quaternion.log(quaternion.multiply(quaternion.conjugate(pose), held))
            return sign * turned / _PROBE

        return jnp.stack([one(axis) for axis in axes], axis=-1)

    up, down = left(1.0), left(-1.0)
    less = jnp.sum(up * up, axis=-2, keepdims=True) < jnp.sum(down * down, axis=-2, keepdims=True)
    return jax.lax.stop_gradient(jnp.where(less, up, down))
