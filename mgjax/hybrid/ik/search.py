"""What a solve tries: poses to start from, and which of several targets are given up.

A step towards the targets ends where limits stop it: an elbow that bends to one side only and is
straight, with the target on its line, feels no pull to bend. No step leads out of there, but
another start avoids it. Poses inside the limits are drawn once, and those whose ends lie nearest to
the targets are started from.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Bool, Float

from mgjax.core import quaternion
from mgjax.core.arrays import Array
from mgjax.core.body.joint_limits import JointLimits, clamp, from_swing_twist
from mgjax.hybrid.ik import tree_steps as steps

STARTS = 16
"""Poses started from with limits: the given one, and the nearest of each group drawn."""
_GROUP = 128
"""Poses of a group. Groups keep the starts apart, and finding the nearest cheap."""
_GIVEN_UP = 2
"""Targets at most that are given up for the others."""
_TRIES = 4
"""Starts of each choice of targets to give up; without limits one."""
_FAINT = 1e-2
"""Weight of a target that is given up, while the others are not yet met."""


class Budget(NamedTuple):
    """How much is tried: FABRIK's stages and least-squares steps from each start, and starts."""

    iterations: Array | int
    steps: Array | int
    starts: int


class Drawn(NamedTuple):
    """Groups of poses inside the limits.

    Attributes:
        poses: local rotations.
        ends: their places as seen from the base, in the frame that it hangs on, m.
    """

    poses: Float[Array, "G D n 4"]
    ends: Float[Array, "G D E 3"]


def drawn_poses(tree: steps.TreeProblem, limits: JointLimits) -> Drawn:
    """Poses to start from, of all problems with this tree."""
    count, groups = tree.offsets.shape[0], STARTS - 1
    numbers = np.random.default_rng(0).uniform(0, 1, (groups * _GROUP, count, 3))
    numbers = jnp.asarray(numbers, jnp.float32)
    box, span = jnp.asarray(limits.swing), jnp.asarray(limits.twist)
    low, high = box[None, :, 0::2], box[None, :, 1::2]
    swing = low + (high - low) * numbers[..., :2]
    turn = span[None, :, 0] + (span[:, 1] - span[:, 0])[None] * numbers[..., 2]
    poses = clamp(from_swing_twist(swing, turn, limits), limits)
    origin = jnp.zeros(3, jnp.float32)
    upright = jnp.array([1.0, 0.0, 0.0, 0.0], jnp.float32)
    tree = tree._replace(base=origin, frame=upright)
    ends = jax.vmap(lambda pose: steps.place(tree, pose)[0])(poses)[:, tree.ends]
    return Drawn(*(x.reshape(groups, _GROUP, *x.shape[1:]) for x in (poses, ends)))


def search_on(
    problem: steps.TreeProblem,
    first: Float[Array, "n 4"],
    within: Bool[Array, " E"],
    drawn: Drawn | None,
    limits: JointLimits | None,
    tolerance: Float[Array, ""],
    budget: Budget,
) -> Float[Array, "n 4"]:
    """The first pose that meets all targets, else the best that was found.

    Best is what meets most targets. Of targets that cannot be met together the earlier ones are
    met, and the others approached as far as that allows.

    Args:
        problem: what is solved.
        first: what :func:`climb` came to.
        within: which targets are as near as the bones are long; others cannot be met.
        drawn: poses to start from next; None without limits.
        limits: of all joints, or None.
        tolerance: distance at which an end has arrived, m.
        budget: how much is tried.
    """
    best = first
    if drawn is not None:
        best = _from_drawn(problem, best, drawn, limits, tolerance, budget)
    if len(problem.ends) > 1:
        best = _give_up(problem, best, within, drawn, limits, tolerance, budget)
    return best


def climb(
    problem: steps.TreeProblem,
    start: Array,
    limits: JointLimits | None,
    tolerance: Array,
    budget: Budget,
) -> tuple[Array, Array]:
    """The best pose on the way from a start, and its worst miss, m."""
    everything = jnp.ones(problem.targets.shape[:1], bool)

    def stage(local: Array) -> Array:
        return steps.fabrik_iteration(problem, local, limits)

    def step(local: Array) -> Array:
        return steps.damped_least_squares_step(problem, local, limits)

    local, _ = _repeat(problem, stage, start, budget.iterations, everything, tolerance)
    return _repeat(problem, step, local, budget.steps, everything, tolerance)


def _repeat(
    problem: steps.TreeProblem,
    move: Callable[[Array], Array],
    local: Array,
    times: Array | int,
    counted: Array,
    tolerance: Array,
) -> tuple[Array, Array]:
    """Moves until the targets that count are met; the best pose, and the worst of their misses."""

    def worst(local: Array) -> Array:
        return jnp.max(jnp.where(counted, steps.residuals(problem, local), 0.0))

    def body(state: tuple[Array, ...]) -> tuple[Array, ...]:
        k, local, best, least = state
        local = move(local)
        miss = worst(local)
        best = jnp.where(miss < least, local, best)
        return k + 1, local, best, jnp.minimum(miss, least)

    state = (jnp.int32(0), local, local, worst(local))
    state = lax.while_loop(lambda s: (s[0] < times) & (s[3] > tolerance), body, state)
    return state[2], state[3]


def _nearest(problem: steps.TreeProblem, drawn: Drawn, group: Array, counted: Array) -> Array:
    """The pose of a group whose ends are nearest to the targets that count."""
    back = quaternion.conjugate(problem.frame)[None]
    wanted = quaternion.rotate(back, problem.targets - problem.base[None])
    square = jnp.sum((drawn.ends[group] - wanted[None]) ** 2, axis=-1)
    square = jnp.sum(jnp.where(counted[None], square, 0.0), axis=-1)
    return drawn.poses[group, jnp.argmin(square)]


def _from_drawn(
    problem: steps.TreeProblem,
    first: Array,
    drawn: Drawn,
    limits: JointLimits | None,
    tolerance: Array,
    budget: Budget,
) -> Array:
    """The best pose after further starts, as many as it takes to meet the targets."""
    everything = jnp.ones(problem.targets.shape[:1], bool)

    def again(state: tuple[Array, ...]) -> tuple[Array, ...]:
        k, best, least = state
        start = _nearest(problem, drawn, k, everything)
        solved, miss = climb(problem, start, limits, tolerance, budget)
        return k + 1, jnp.where(miss < least, solved, best), jnp.minimum(miss, least)

    more = jnp.minimum(budget.starts - 1, STARTS - 1)
    state = (jnp.int32(0), first, jnp.max(steps.residuals(problem, first)))
    return lax.while_loop(lambda s: (s[0] < more) & (s[2] > tolerance), again, state)[1]


def _choices(ends: int, tries: int) -> tuple[np.ndarray, np.ndarray]:
    """[A, E] which targets are kept in each attempt, most first, and [A] the try."""
    kept = []
    for gone in range(1, min(_GIVEN_UP, ends - 1) + 1):
        for stay in combinations(range(ends), ends - gone):
            kept += [[end in stay for end in range(ends)]] * tries
    return np.array(kept), np.tile(np.arange(tries), len(kept) // tries)


def _give_up(
    problem: steps.TreeProblem,
    best: Array,
    within: Array,
    drawn: Drawn | None,
    limits: JointLimits | None,
    tolerance: Array,
    budget: Budget,
) -> Array:
    """The best pose, after some targets were given up where that meets more of the others."""
    kept, number = _choices(len(problem.ends), 1 if drawn is None else _TRIES)
    sizes = jnp.asarray(kept.sum(axis=-1))
    kept, number = jnp.asarray(kept), jnp.asarray(number)
    compromise = best

    def met(local: Array) -> Array:
        return jnp.sum(within & (steps.residuals(problem, local) <= tolerance))

    def attempt(state: tuple[Array, ...]) -> tuple[Array, ...]:
        k, best, count = state
        stay, local = kept[k], compromise
        if drawn is not None:
            near = _nearest(problem, drawn, jnp.maximum(number[k] - 1, 0), stay)
            local = jnp.where(number[k] > 0, near, compromise)
        faint, alone = jnp.where(stay, 1.0, _FAINT), jnp.where(stay, 1.0, 0.0)

        def step(local: Array, weights: Array) -> Array:
            return steps.damped_least_squares_step(problem, local, limits, weights)

        local = lax.fori_loop(0, budget.steps, lambda _, pose: step(pose, faint), local)
        local, _ = _repeat(
            problem, lambda pose: step(pose, alone), local, budget.steps, stay, tolerance
        )
        more = met(local) > count
        return k + 1, jnp.where(more, local, best), jnp.maximum(met(local), count)

    def worth(state: tuple[Array, ...]) -> Array:
        k, _, count = state
        size = sizes[jnp.minimum(k, len(sizes) - 1)]
        return (k < len(sizes)) & (count < size)

    return lax.while_loop(worth, attempt, (jnp.int32(0), best, met(best)))[1]
