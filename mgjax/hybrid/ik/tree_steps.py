"""FABRIK over a tree of joints: several targets, a shared torso, joint limits.

The state is the joints' rotations rather than their places, so that a joint with several children,
such as the chest with neck and both collar bones, stays one rigid body, limits have frames to refer
to, and the result is a pose.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Bool, Float, Int

from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.body.joint_limits import JointLimits, clamp

_TWISTED = 1e-6
"""Least squared arm of children about their mean direction from which on they twist a joint, m²."""


class Tree(NamedTuple):
    """The joints that are moved. Hashable.

    Attributes:
        parents: of each joint, a parent before its children; −1 for the base, joint 0.
        ends: the joints with targets, in the targets' order: exactly the joints without children.
    """

    parents: tuple[int, ...]
    ends: tuple[int, ...]


class TreeProblem(NamedTuple):
    """What is fixed while one tree is solved, and the tree's tables.

    Attributes:
        offsets: of each joint in its parent's frame, m; the base's is not used.
        base: place of joint 0, m.
        frame: world rotation of what joint 0 hangs on.
        targets: wanted places of the ends, m.
        parents: −1 for the base.
        children: padded with −1.
        below: whether an end hangs on a joint, the end itself excepted.
        end_of: which target a joint is to meet, or −1.
        ends: joints of the targets.
    """

    offsets: Float[Array, "n 3"]
    base: Float[Array, "3"]
    frame: Float[Array, "4"]
    targets: Float[Array, "E 3"]
    parents: Int[Array, " n"]
    children: Int[Array, "n C"]
    below: Bool[Array, "n E"]
    end_of: Int[Array, " n"]
    ends: Int[Array, " E"]


def tree_tables(tree: Tree) -> tuple[np.ndarray, ...]:
    """``parents``, ``children``, ``below``, ``end_of`` and ``ends`` of a :class:`TreeProblem`."""
    count = len(tree.parents)
    hanging: list[list[int]] = [[] for _ in range(count)]
    for joint, parent in enumerate(tree.parents):
        if parent >= 0:
            hanging[parent].append(joint)
    children = np.full((count, max(len(c) for c in hanging)), -1, np.int32)
    for joint, members in enumerate(hanging):
        children[joint, : len(members)] = members
    below = np.zeros((count, len(tree.ends)), bool)
    end_of = np.full(count, -1, np.int32)
    for slot, end in enumerate(tree.ends):
        end_of[end] = slot
        joint = tree.parents[end]
        while joint >= 0:
            below[joint, slot] = True
            joint = tree.parents[joint]
    ends = np.array(tree.ends, np.int32)
    return np.array(tree.parents, np.int32), children, below, end_of, ends


def place(
    problem: TreeProblem, local: Float[Array, "n 4"]
) -> tuple[Float[Array, "n 3"], Float[Array, "n 4"]]:
    """Places (m) and world rotations of all joints."""
    count = local.shape[0]

    def step(joint: jax.Array, state: tuple[jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array]:
        places, turns = state
        parent = problem.parents[joint]
        above = jnp.where(parent < 0, problem.frame, turns[parent])
        placed = places[parent] + quaternion.rotate(above, problem.offsets[joint])
        places = places.at[joint].set(jnp.where(parent < 0, problem.base, placed))
        return places, turns.at[joint].set(quaternion.multiply(above, local[joint]))

    return lax.fori_loop(0, count, step, (jnp.zeros_like(problem.offsets), jnp.zeros_like(local)))


def fabrik_iteration(
    problem: TreeProblem, local: Float[Array, "n 4"], limits: JointLimits | None
) -> Array:
    """One forward and one backward stage (Aristidou & Lasenby 2011, algorithm 1 and section 4).

    A joint with several children, a sub-base, is turned to fit them all and goes to the mean of the
    places that they ask for. With limits, each stage brings each joint's rotation inside them as
    soon as it is known.
    """
    places, turns = place(problem, local)
    count = local.shape[0]

    def inward(index: jax.Array, state: tuple[jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array]:
        wanted, turns = state
        joint = count - 1 - index
        kids, real, arms = _kids(problem, joint)
        turn = _fit(quaternion.rotate(turns[joint], arms), wanted[kids] - places[joint][None], real)
        turned = quaternion.multiply(turn, turns[joint])
        if limits is not None:
            child = kids[0]
            bent = quaternion.multiply(quaternion.conjugate(turned), turns[child])
            held = _clamp_one(bent, limits, child)
            back = quaternion.multiply(turns[child], quaternion.conjugate(held))
            turned = jnp.where((jnp.sum(real) == 1) & ~_is_end(problem, child), back, turned)
        asked = wanted[kids] - quaternion.rotate(turned, arms)
        count_of = jnp.maximum(jnp.sum(real), 1).astype(asked.dtype)
        mean = jnp.sum(jnp.where(real[:, None], asked, 0.0), axis=0) / count_of
        end = problem.end_of[joint]
        goal = jnp.where(end < 0, mean, problem.targets[end])
        turned = jnp.where(end < 0, turned, turns[joint])
        return wanted.at[joint].set(goal), turns.at[joint].set(turned)

    def outward(joint: jax.Array, state: tuple[jax.Array, ...]) -> tuple[jax.Array, ...]:
        new_places, new_turns, new_local = state
        parent = problem.parents[joint]
        above = jnp.where(parent < 0, problem.frame, new_turns[parent])
        placed = new_places[parent] + quaternion.rotate(above, problem.offsets[joint])
        here = jnp.where(parent < 0, problem.base, placed)
        kids, real, arms = _kids(problem, joint)
        now = forward[joint]
        turn = _fit(quaternion.rotate(now, arms), wanted[kids] - here[None], real)
        bent = quaternion.multiply(quaternion.conjugate(above), quaternion.multiply(turn, now))
        bent = bent if limits is None else _clamp_one(bent, limits, joint)
        bent = jnp.where(_is_end(problem, joint), local[joint], quaternion.normalise(bent))
        return (
            new_places.at[joint].set(here),
            new_turns.at[joint].set(quaternion.multiply(above, bent)),
            new_local.at[joint].set(bent),
        )

    wanted, forward = lax.fori_loop(0, count, inward, (places, turns))
    return lax.fori_loop(0, count, outward, (places, turns, local))[2]


def damped_least_squares_step(
    problem: TreeProblem,
    local: Float[Array, "n 4"],
    limits: JointLimits | None,
    weights: Float[Array, " E"] | None = None,
) -> Array:
    """One damped least-squares step of all joints towards all targets, of equal or given weights.

    With r the arm from a joint to an end, the joint's turn ω moves the end by ω × r. The turns of
    least size that move the ends by e solve (J Jᵀ + λ) f = e, ω = Σ r × f, with λ = |e|²/2
    (Sugihara 2011), so that the step is bold only near the targets. Where a limit stops a joint,
    the step is computed again with only what the limit leaves of the joint's turn.
    """
    places, turns = place(problem, local)
    above = jnp.where(problem.parents[:, None] < 0, problem.frame[None], turns[problem.parents])
    arms = jnp.where(problem.below[..., None], places[problem.ends][None] - places[:, None], 0.0)
    x, y, z = (arms[..., i] for i in range(3))
    zero = jnp.zeros_like(x)
    # [n, E, 3, 3] with jacobian @ ω = ω × r.
    rows = [[zero, z, -y], [-z, zero, x], [y, -x, zero]]
    jacobian = jnp.stack([jnp.stack(row, axis=-1) for row in rows], axis=-2)
    count, ends = arms.shape[:2]
    jacobian = jnp.swapaxes(jacobian.reshape(count, 3 * ends, 3), 0, 1)
    miss = (problem.targets - places[problem.ends]).reshape(-1)
    if weights is not None:
        rows_of = jnp.repeat(weights, 3)
        jacobian, miss = jacobian * rows_of[:, None, None], miss * rows_of
    damping = 0.5 * jnp.sum(miss * miss) + 1e-7

    def step(freedom: Float[Array, "n 3 3"]) -> tuple[Array, Array]:
        loose = jnp.einsum("anj,njk->ank", jacobian, freedom)
        square = jnp.einsum("anj,bnj->ab", loose, jacobian)
        square = square + damping * jnp.eye(square.shape[0], dtype=square.dtype)
        turn = jnp.einsum("anj,a->nj", loose, jnp.linalg.solve(square, miss))
        size = jnp.sqrt(jnp.sum(turn**2, axis=-1, keepdims=True) + 1e-16)
        turn = turn * jnp.minimum(1.0, 0.7 / size)
        size = jnp.minimum(size, 0.7)
        spun = quaternion.from_axis_angle(turn / size, size[..., 0])
        inner = quaternion.multiply(spun, quaternion.multiply(above, local))
        bent = quaternion.multiply(quaternion.conjugate(above), inner)
        return turn, quaternion.normalise(bent)

    free = jnp.broadcast_to(jnp.eye(3, dtype=local.dtype), (count, 3, 3))
    turn, bent = step(free)
    if limits is None:
        return bent
    held = clamp(bent, limits)
    old, new = (quaternion.multiply(above, q) for q in (local, held))
    done = quaternion.log(quaternion.multiply(new, quaternion.conjugate(old)))
    product = jnp.sum(done * turn, axis=-1)
    left = done[:, :, None] * done[:, None, :] / jnp.maximum(product, 1e-12)[:, None, None]
    stopped = jnp.sum((done - turn) ** 2, axis=-1) > 1e-4 * jnp.sum(turn**2, axis=-1)
    left = jnp.where((product > 1e-12)[:, None, None], left, 0.0)
    return clamp(step(jnp.where(stopped[:, None, None], left, free))[1], limits)


def residuals(problem: TreeProblem, local: Float[Array, "n 4"]) -> Float[Array, " E"]:
    """Distance of each end from its target, m."""
    off = place(problem, local)[0][problem.ends] - problem.targets
    return jnp.sqrt(jnp.sum(off * off, axis=-1))


def _kids(problem: TreeProblem, joint: Array) -> tuple[Array, Array, Array]:
    kids = problem.children[joint]
    real = kids >= 0
    kids = jnp.maximum(kids, 0)
    return kids, real, jnp.where(real[:, None], problem.offsets[kids], 0.0)


def _is_end(problem: TreeProblem, joint: Array) -> Array:
    return problem.end_of[joint] >= 0


def _fit(arms: Float[Array, "C 3"], wanted: Float[Array, "C 3"], real: Bool[Array, " C"]) -> Array:
    """A rotation that turns ``arms`` towards ``wanted``: the sums by a swing, then a twist."""
    have = jnp.where(real[:, None], arms, 0.0)
    want = jnp.where(real[:, None], wanted, 0.0)
    # Children nearer than a tenth of a millimetre do not turn the joint.
    want = jnp.where(jnp.sum(have * have, axis=-1, keepdims=True) > 1e-8, want, 0.0)
    total = jnp.sum(want, axis=0)
    swing = quaternion.from_two_vectors(jnp.sum(have, axis=0), total)
    axis = total / jnp.sqrt(jnp.maximum(jnp.sum(total * total), 1e-12))
    have = quaternion.rotate(swing, have)
    have = have - jnp.sum(have * axis[None], axis=-1, keepdims=True) * axis[None]
    sine = jnp.sum(jnp.cross(have, want) @ axis)
    cosine = jnp.sum(have * want)
    sided = jnp.sum(have * have) > _TWISTED
    angle = jnp.arctan2(jnp.where(sided, sine, 0.0), jnp.where(sided, cosine, 1.0))
    return quaternion.multiply(quaternion.from_axis_angle(axis, angle), swing)


def _clamp_one(rotation: Float[Array, "4"], limits: JointLimits, joint: Array) -> Array:
    one = jax.tree.map(lambda field: jnp.asarray(field)[joint][None], limits)
    return clamp(rotation[None], one)[0]
