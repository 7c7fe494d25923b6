"""One pass, solved: guess, differential updates, and where they fail the nearest approach."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jax import lax
from jaxtyping import Bool, Float, Int

from mgjax.ballsport.aiming.nearest import nearest_launch
from mgjax.ballsport.aiming.problem import AimProblem, Launch, arrive, clears_net
from mgjax.ballsport.aiming.scan import guess_launch
from mgjax.ballsport.aiming.updates import Updated, differential_updates
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

OK, TOO_FAR, UNDER_NET, IN_GROUND, NOT_FINITE = 0, 1, 2, 3, 4
STATUS_TEXT = (
    "met",
    "out of reach of the largest kick speed",
    "out of reach above the net",
    "target in the ground",
    "a number is not finite",
)
"""What each status of a pass means."""

EXACT = 1e-4
"""Miss up to which a target is met, m."""

_CLOSE = 6e-5
"""Miss that the updates must reach, m: with what a target on the ground is lifted, ``EXACT``."""

_ROUNDING = 1 + 1e-6
"""Factor on the largest speed."""


@register()
@dataclass(frozen=True, kw_only=True)
class Aim:
    """A pass, or with a leading axis many.

    Attributes:
        velocity: of the ball when it leaves, m/s. [3]
        time: of flight, s.
        status: ``OK``; ``TOO_FAR`` or ``UNDER_NET``, and then the launch is the one that passes
            nearest to the target; ``IN_GROUND``, and then the place above the target is met;
            ``NOT_FINITE``, and then the launch is NaN. See ``STATUS_TEXT``.
        miss: distance from the target at ``time``, m.
        arrival: where the ball is at ``time``, m. [3]
        iterations: differential updates tried.
    """

    velocity: Float[Array, "*n 3"]
    time: Float[Array, "*n"]
    status: Int[Array, "*n"]
    miss: Float[Array, "*n"]
    arrival: Float[Array, "*n 3"]
    iterations: Int[Array, "*n"]


def solve(problem: AimProblem, bounces: int) -> Aim:
    """The pass, or the nearest there is."""
    aimed = solve_feasible(problem, bounces)
    return lax.cond(
        (aimed.status == TOO_FAR) | (aimed.status == UNDER_NET),
        lambda: solve_nearest(problem, aimed.status, bounces),
        lambda: aimed,
    )


def solve_feasible(problem: AimProblem, bounces: int) -> Aim:
    """Guess and updates. What does not meet the target has the reason as status."""
    guess = guess_launch(problem, bounces)
    updated = differential_updates(problem, guess.launch, bounces)
    reason = jnp.where(guess.reached & ~guess.feasible, UNDER_NET, TOO_FAR)
    return _result(problem, updated, _meets(problem, updated, bounces), reason)


def solve_nearest(problem: AimProblem, reason: Int[Array, ""], bounces: int) -> Aim:
    """The nearest approach; from there the updates may yet find what the guess did not."""
    launch = nearest_launch(problem, bounces)
    updated = differential_updates(problem, launch, bounces)
    meets = _meets(problem, updated, bounces)
    miss, (_, kept) = arrive(problem, launch, bounces)
    launch = Launch(*(jnp.where(meets, a, b) for a, b in zip(updated.launch, launch, strict=True)))
    miss = jnp.where(meets, updated.miss, miss)
    return _result(problem, Updated(launch, miss, kept, updated.trials), meets, reason)


def _meets(problem: AimProblem, updated: Updated, bounces: int) -> Bool[Array, ""]:
    speed = jnp.sqrt(jnp.sum(updated.launch.velocity**2))
    met = (jnp.sum(updated.miss**2) <= _CLOSE**2) & updated.kept
    met &= speed <= problem.max_speed * _ROUNDING
    return met & clears_net(problem, updated.launch, bounces)


def _result(problem: AimProblem, updated: Updated, meets: Array, reason: Array) -> Aim:
    numbers = (*problem.asked, *problem.start, *problem.guess, problem.max_speed, problem.weight)
    finite = jnp.all(jnp.isfinite(jnp.stack(numbers)))
    sunk = problem.asked[1] < problem.physics.radius - EXACT
    status = jnp.where(meets, jnp.where(sunk, IN_GROUND, OK), reason)
    lift = problem.target[1] - (problem.asked[1] - problem.physics.radius)
    lifted = jnp.stack([jnp.zeros_like(lift), lift, jnp.zeros_like(lift)])
    nothing = jnp.where(finite, 0.0, jnp.nan)
    rest = jnp.stack([problem.start[0], problem.physics.radius, problem.start[2]])
    arrival = rest + problem.target + updated.miss
    return Aim(
        velocity=updated.launch.velocity + nothing,
        time=updated.launch.time + nothing,
        status=jnp.where(finite, status, NOT_FINITE).astype(jnp.int32),
        miss=jnp.sqrt(jnp.sum((lifted + updated.miss) ** 2)),
        arrival=arrival,
        iterations=updated.trials,
    )
