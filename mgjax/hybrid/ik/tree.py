"""FABRIK with joint limits, with several targets, or both.

The stages and steps are in :mod:`mgjax.hybrid.ik.tree_steps`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.hybrid.ik import tree_steps as steps
from mgjax.hybrid.ik.chain import NOT_CONVERGED, REACHED, UNREACHABLE_FAR, UNREACHABLE_NEAR
from mgjax.hybrid.ik.joint_limits import JointLimits, clamp, from_swing_twist

_STEPS = 32
"""Least-squares steps at most after the stages, from each start."""
_REACH = 0.999
"""Share of its length to which a chain is stretched towards a target that is too far."""
_STARTS = 8
"""Poses tried with limits: the given one, the limits' centre, and some inside the limits."""


@partial(jax.jit, static_argnames=("parents", "ends"))
def fabrik_tree(
    offsets: Float[Array, "n 3"],
    base: Float[Array, "*b 3"],
    rotations: Float[Array, "*b n 4"],
    targets: Float[Array, "*b E 3"],
    *,
    parents: tuple[int, ...],
    ends: tuple[int, ...],
    frame: Float[Array, "*b 4"] | None = None,
    limits: JointLimits | None = None,
    tolerance: float | Float[Array, ""] = 1e-3,
    max_iterations: int | Int[Array, ""] = 16,
    max_steps: int | Int[Array, ""] = _STEPS,
    max_starts: int | Int[Array, ""] = _STARTS,
) -> tuple[Float[Array, "*b n 4"], Int[Array, "*b E"]]:
    """Local rotations of a tree of joints such that its ends meet their targets.

    FABRIK's stages run until all ends are within the tolerance, at most ``max_iterations`` times;
    what then is left, ``max_steps`` damped least-squares steps bring to the targets. With limits,
    poses out of which neither finds a way are left for another start. Bones are exact, the base
    does not move, twists that no limit or sub-base changes are kept.

    Deviation:
        Aristidou and Lasenby stop with the stages. With limits these stall: the one stage moves a
        joint where the other may not have it. And at a sub-base they leave the mean of what the
        branches ask for, which meets no target exactly.

    Args:
        offsets: of each joint in its parent's frame, m.
        base: place of joint 0, m.
        rotations: local rotations to start from. Those of the ends are left as they are.
        targets: wanted places of ``ends``, m.
        parents: −1 for joint 0, a parent before its children.
        ends: all joints without children, in the order of the targets.
        frame: world rotation of what joint 0 hangs on; default: the identity.
        limits: on (of all n joints; an end's are not used) or off (None). Also the start is brought
            inside them.
        tolerance: distance at which an end counts as having arrived, m.
        max_iterations: forward and backward stages at most, from each start.
        max_steps: least-squares steps at most, from each start; 0 for FABRIK alone.
        max_starts: starts at most, up to 8; only with limits is there more than one.

    Returns:
        ``(rotations, status)``, one status of :mod:`mgjax.hybrid.ik.chain` for each end. Too
        far and too near are judged by bone lengths; what limits forbid is ``NOT_CONVERGED``.
    """
    tree = steps.tree_tables(steps.Tree(parents, ends))
    batch = base.shape[:-1]
    starts = _starts(rotations.shape[-2], limits)
    budget = max_iterations, max_steps, max_starts
    goal = jnp.asarray(tolerance, jnp.float32)

    lengths = _lengths(jnp.asarray(offsets), tree)

    def one(base: Array, rotations: Array, targets: Array, frame: Array) -> tuple[Array, Array]:
        problem = steps.TreeProblem(
            jnp.asarray(offsets), base, frame, targets, *map(jnp.asarray, tree)
        )
        nearer = problem._replace(targets=_within_length(problem, lengths))
        solved = _search(nearer, rotations, starts, limits, goal, budget)
        return solved, _status(problem, solved, lengths, goal)

    if frame is None:
        frame = jnp.zeros((*batch, 4), jnp.float32).at[..., 0].set(1.0)
    arrays = (base, rotations, targets, frame)
    flat = [jnp.reshape(jnp.asarray(a, jnp.float32), (-1, *a.shape[len(batch) :])) for a in arrays]
    solved, status = jax.vmap(one)(*flat)
    return solved.reshape(rotations.shape), status.reshape(*batch, len(ends))


def _starts(count: int, limits: JointLimits | None) -> Array:
    """[A, n, 4] poses to start from after the given one."""
    if limits is None:
        return jnp.zeros((0, count, 4), jnp.float32)
    numbers = np.random.default_rng(0).uniform(0, 1, (_STARTS - 1, count, 3))
    numbers[0] = 0.5
    numbers = jnp.asarray(numbers, jnp.float32)
    box, span = jnp.asarray(limits.swing), jnp.asarray(limits.twist)
    low, high = box[None, :, 0::2], box[None, :, 1::2]
    swing = low + (high - low) * numbers[..., :2]
    turn = span[None, :, 0] + (span[:, 1] - span[:, 0])[None] * numbers[..., 2]
    return clamp(from_swing_twist(swing, turn, limits), limits)


def _search(
    problem: steps.TreeProblem,
    given: Array,
    starts: Array,
    limits: JointLimits | None,
    tolerance: Array,
    budget: tuple,
) -> Array:
    """The pose of the first start that gets there, else the best."""

    def worst(local: Array) -> Array:
        return jnp.max(steps.residuals(problem, local))

    max_iterations, max_steps, max_starts = budget

    def repeat(move: Callable, local: Array, times: Array | int) -> tuple[Array, Array]:
        """The best pose on the way, and its miss."""

        def body(state):
            k, local, best, least = state
            local = move(problem, local, limits)
            miss = worst(local)
            best = jnp.where(miss < least, local, best)
            return k + 1, local, best, jnp.minimum(miss, least)

        state = (0, local, local, worst(local))
        state = lax.while_loop(lambda s: (s[0] < times) & (s[3] > tolerance), body, state)
        return state[2], state[3]

    def climb(local: Array) -> tuple[Array, Array]:
        local, _ = repeat(steps.fabrik_iteration, local, max_iterations)
        return repeat(steps.damped_least_squares_step, local, max_steps)

    first = given if limits is None else clamp(given, limits)
    best, least = climb(first)

    def again(state):
        k, best, least = state
        solved, miss = climb(starts[k])
        return k + 1, jnp.where(miss < least, solved, best), jnp.minimum(miss, least)

    if starts.shape[0]:
        state = (0, best, least)
        more = jnp.minimum(max_starts - 1, starts.shape[0])
        best = lax.while_loop(lambda s: (s[0] < more) & (s[2] > tolerance), again, state)[1]
    ends = problem.end_of[:, None] >= 0
    return jnp.where(ends, given, best)


def _lengths(offsets: Array, tree: tuple[np.ndarray, ...]) -> Array:
    """[E, n] length of each bone on the way from the base to each end, 0 for others."""
    _, _, below, _, ends = tree
    # The bone of a joint comes from its parent: those of the joints above an end, and its own.
    on_way = below | (np.arange(len(below))[:, None] == ends[None])
    on_way[0] = False
    lengths = jnp.sqrt(jnp.sum(offsets**2, axis=-1))
    return jnp.where(jnp.asarray(on_way.T), lengths[None], 0.0)


def _within_length(problem: steps.TreeProblem, lengths: Array) -> Array:
    """The targets; those too far brought within reach, so that they do not spoil the others."""
    displacement = problem.targets - problem.base[None]
    distance = jnp.sqrt(jnp.maximum(jnp.sum(displacement * displacement, axis=-1), 1e-12))
    share = jnp.minimum(1.0, _REACH * jnp.sum(lengths, axis=-1) / distance)
    near = problem.base[None] + share[:, None] * displacement
    return jnp.where((distance > jnp.sum(lengths, axis=-1))[:, None], near, problem.targets)


def _status(problem: steps.TreeProblem, local: Array, lengths: Array, tolerance: Array) -> Array:
    total, longest = jnp.sum(lengths, axis=-1), jnp.max(lengths, axis=-1)
    distance = jnp.sqrt(jnp.sum((problem.targets - problem.base[None]) ** 2, axis=-1))
    status = jnp.where(distance < 2 * longest - total, UNREACHABLE_NEAR, NOT_CONVERGED)
    status = jnp.where(distance > total, UNREACHABLE_FAR, status)
    return jnp.where(steps.residuals(problem, local) <= tolerance, REACHED, status).astype(
        jnp.int32
    )
