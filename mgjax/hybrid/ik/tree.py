"""FABRIK with joint limits, with several targets, or both.

The stages and steps are in :mod:`mgjax.hybrid.ik.tree_steps`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.core.body.joint_limits import JointLimits, clamp
from mgjax.core.calls.door import takes_not_finite
from mgjax.hybrid.ik import tree_steps as steps
from mgjax.hybrid.ik.chain import NOT_CONVERGED, REACHED, UNREACHABLE_FAR, UNREACHABLE_NEAR
from mgjax.hybrid.ik.following import following
from mgjax.hybrid.ik.search import STARTS, Budget, climb, drawn_poses, search_on

_STEPS = 32
"""Least-squares steps at most after the stages, from each start."""
_REACH = 0.999
"""Share of its length to which a chain is stretched towards a target that is too far."""


@takes_not_finite
@partial(jax.jit, static_argnames=("parents", "ends", "max_starts"))
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
    max_starts: int = STARTS,
) -> tuple[Float[Array, "*b n 4"], Int[Array, "*b E"]]:
    """Local rotations of a tree of joints such that its ends meet their targets.

    FABRIK's stages run until all ends are within the tolerance, at most ``max_iterations`` times;
    what then is left, ``max_steps`` damped least-squares steps bring to the targets. With limits,
    poses out of which neither finds a way are left for another start. Where not all targets can be
    met, as many as possible are, of those that exclude each other the earlier ones; the others are
    approached as far as that allows. Bones are exact, the base does not move, twists that no limit
    or sub-base changes are kept.

    Gradients (forward and reverse mode) with respect to offsets, base, rotations, targets and frame
    are those of the pose that follows by the smallest turns
    (:mod:`mgjax.hybrid.ik.following`); tolerance and limits have none.

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
        max_starts: starts at most, up to 16; only with limits is there more than one. With 1, no
            target is given up for others, either.

    Returns:
        ``(rotations, status)``, one status of :mod:`mgjax.hybrid.ik.chain` for each end. Too
        far and too near are judged by bone lengths; what limits forbid is ``NOT_CONVERGED``.
    """
    batch = base.shape[:-1]
    offsets, goal = jnp.asarray(offsets), jnp.asarray(tolerance, jnp.float32)
    tables = steps.tree_tables(steps.Tree(parents, ends))
    lengths = _lengths(offsets, tables)
    tables = tuple(map(jnp.asarray, tables))
    if frame is None:
        frame = jnp.zeros((*batch, 4), jnp.float32).at[..., 0].set(1.0)
    arrays = (base, frame, targets, rotations)
    flat = [jnp.reshape(jnp.asarray(a, jnp.float32), (-1, *a.shape[len(batch) :])) for a in arrays]

    def problem_of(base: Array, frame: Array, targets: Array) -> steps.TreeProblem:
        return steps.TreeProblem(offsets, base, frame, targets, *tables)

    def nearer(*setting: Array) -> tuple[steps.TreeProblem, Array]:
        return _brought_near(problem_of(*setting), lengths, goal)

    # The search is not differentiated: its result is, by what it fulfils.
    fixed, budget = lax.stop_gradient, Budget(max_iterations, max_steps, max_starts)

    def searched(*setting: Array) -> tuple[steps.TreeProblem, Array]:
        return fixed(nearer(*setting))

    solved = _solve(searched, fixed(flat), fixed(limits), goal, budget)

    def follow(base: Array, frame: Array, targets: Array, given: Array, solved: Array) -> Array:
        return following(nearer(base, frame, targets)[0], given, limits, solved)

    bases, frames, wanted, given = flat
    solved = jax.vmap(follow)(bases, frames, wanted, given, solved)

    def status_of(base: Array, frame: Array, targets: Array, local: Array) -> Array:
        return _status(problem_of(base, frame, targets), local, lengths, goal)

    status = jax.vmap(status_of)(bases, frames, wanted, solved)
    return solved.reshape(rotations.shape), status.reshape(*batch, len(ends))


def _solve(
    problem_of: Callable[..., tuple[steps.TreeProblem, Array]],
    flat: Sequence[Array],
    limits: JointLimits | None,
    tolerance: Array,
    budget: Budget,
) -> Array:
    """[N, n, 4] poses: of the first start, and where that misses, of whatever else is tried."""
    bases, frames, wanted, given = flat

    def start(base: Array, frame: Array, targets: Array, given: Array) -> tuple[Array, Array]:
        inside = given if limits is None else clamp(given, limits)
        return climb(problem_of(base, frame, targets)[0], inside, limits, tolerance, budget)

    first, least = jax.vmap(start)(bases, frames, wanted, given)
    tree, _ = problem_of(jnp.zeros(3), jnp.zeros(4), jnp.zeros(wanted.shape[1:]))

    def more() -> Array:
        drawn = None if limits is None else drawn_poses(tree, limits)

        def one(base: Array, frame: Array, targets: Array, first: Array) -> Array:
            problem, within = problem_of(base, frame, targets)
            return search_on(problem, first, within, drawn, limits, tolerance, budget)

        return jax.vmap(one)(bases, frames, wanted, first)

    if budget.starts > 1 and (limits is not None or tree.ends.shape[0] > 1):
        first = lax.cond(jnp.any(least > tolerance), more, lambda: first)
    return jnp.where(tree.end_of[None, :, None] >= 0, given, first)


def _lengths(offsets: Array, tree: tuple[np.ndarray, ...]) -> Array:
    """[E, n] length of each bone on the way from the base to each end, 0 for others."""
    _, _, below, _, ends = tree
    # The bone of a joint comes from its parent: those of the joints above an end, and its own.
    on_way = below | (np.arange(len(below))[:, None] == ends[None])
    on_way[0] = False
    lengths = jnp.sqrt(jnp.sum(offsets**2, axis=-1))
    return jnp.where(jnp.asarray(on_way.T), lengths[None], 0.0)


def _brought_near(
    problem: steps.TreeProblem, lengths: Array, tolerance: Array
) -> tuple[steps.TreeProblem, Array]:
    """The targets, those too far brought within reach, so that they do not spoil the others.

    And which are within the length of the bones: rounding puts a straight chain's end beyond it.
    """
    displacement = problem.targets - problem.base[None]
    distance = jnp.sqrt(jnp.maximum(jnp.sum(displacement * displacement, axis=-1), 1e-12))
    total = jnp.sum(lengths, axis=-1)
    near = problem.base[None] + (_REACH * total / distance)[:, None] * displacement
    within = distance <= total + 0.5 * tolerance
    return problem._replace(targets=jnp.where(within[:, None], problem.targets, near)), within


def _status(problem: steps.TreeProblem, local: Array, lengths: Array, tolerance: Array) -> Array:
    total, longest = jnp.sum(lengths, axis=-1), jnp.max(lengths, axis=-1)
    distance = jnp.sqrt(jnp.sum((problem.targets - problem.base[None]) ** 2, axis=-1))
    status = jnp.where(distance < 2 * longest - total, UNREACHABLE_NEAR, NOT_CONVERGED)
    status = jnp.where(distance > total, UNREACHABLE_FAR, status)
    return jnp.where(steps.residuals(problem, local) <= tolerance, REACHED, status).astype(
        jnp.int32
    )
