"""How the launch of a pass changes with what is asked: slopes of the solution, not of the search.

A pass has four unknowns x = (v, T) and three equations, S(x) = target (eq. 6). Of the curve of
launches that meet the target, the one of least cost is wanted, |v − guess|² + (weight (T − T₀))²;
where the largest speed or the net stops it, the last one that is allowed. As what is asked changes,
x follows by

- the smallest change that keeps the target met, and
- so much along the curve that the cost stays least (or the speed the largest, or the ball above the
  net).

The search knows the least cost to about 0.05 m/s only. Its result is left as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float

from mgjax.ballsport.aiming.problem import AimProblem, Launch, arrive, net_margin
from mgjax.ballsport.aiming.solve import IN_GROUND, OK, Aim
from mgjax.core.arrays import Array

_Of = Callable[[Array, AimProblem], Array]
"""A function of the unknowns and the problem."""

_TOOTH = 0.1
"""How far the search may be from the least cost, m/s; what is farther is stopped by something."""

_AT_NET_M = 0.2
"""Height above the net up to which the net is what stops a launch; else it is the speed."""

_FLAT = 0.05
"""Where the cost bends less than this share of what it would with a straight curve, nothing
says how far to go along it."""


def with_slopes(problem: AimProblem, aimed: Aim, bounces: int) -> Aim:
    """The same pass, differentiable with respect to the problem in both modes.

    A pass that is not met has slope 0, and so have ``miss`` and ``iterations`` of any.
    """
    met = (aimed.status == OK) | (aimed.status == IN_GROUND)
    launch, target = _follow(problem, Launch(aimed.velocity, aimed.time), met, bounces)
    return replace(
        aimed, velocity=launch.velocity, time=launch.time, arrival=aimed.arrival + target
    )


@partial(jax.custom_jvp, nondiff_argnums=(3,))
def _follow(
    problem: AimProblem, launch: Launch, met: Bool[Array, ""], bounces: int
) -> tuple[Launch, Float[Array, "3"]]:
    """The launch as it is, and nothing, whose slope is that of the place that is met."""
    return launch, jnp.zeros(3, jnp.float32)


@_follow.defjvp
def _follow_slopes(bounces: int, primals: tuple, tangents: tuple) -> tuple:
    problem, launch, met = primals
    turned: AimProblem = tangents[0]
    x = jnp.concatenate([launch.velocity, launch.time[None]])
    change = _change(problem, turned, x, bounces)
    change = jnp.where(met, change, 0.0)
    lift = jnp.asarray(turned.start).at[1].set(turned.physics.radius)
    place = jnp.where(met, lift + turned.target, 0.0)
    return _follow(problem, launch, met, bounces), (Launch(change[:3], change[3]), place)


def _change(
    problem: AimProblem, turned: AimProblem, x: Float[Array, "4"], bounces: int
) -> Float[Array, "4"]:
    """How x changes with a problem that changes by ``turned``."""

    def missed(x: Array, problem: AimProblem) -> Array:
        return arrive(problem, Launch(x[:3], x[3]), bounces)[0]

    def along_problem(function: _Of) -> Array:
        return jax.jvp(partial(function, x), (problem,), (turned,))[1]

    jacobian = jax.jacfwd(missed)(x, problem)
    tangent = _null(jacobian)
    # To what is nearly singular nothing is owed: slopes stay finite there.
    square = jacobian @ jacobian.T
    inverse = jnp.linalg.inv(square + 1e-6 * jnp.trace(square) * jnp.eye(3, dtype=square.dtype))
    inverse = jnp.where(jnp.all(jnp.isfinite(inverse)), inverse, 0.0)
    multipliers = -inverse @ (jacobian @ _cost_slope(x, problem))

    def stationary(x: Array, problem: AimProblem) -> Array:
        """Along the curve the slope of cost and constraints; zero at the least cost."""
        pulled = jax.jacfwd(missed)(x, problem).T @ multipliers
        return tangent @ (_cost_slope(x, problem) + pulled)

    def speed(x: Array, problem: AimProblem) -> Array:
        return jnp.sqrt(jnp.sum(x[:3] ** 2) + 1e-12) - problem.max_speed

    def height(x: Array, problem: AimProblem) -> Array:
        return net_margin(problem, Launch(x[:3], x[3]), bounces)

    kept = -jacobian.T @ (inverse @ along_problem(missed))

    def further(function: _Of, least: Array) -> Array:
        """How far along the curve a function stays what it is."""
        row = jax.jacfwd(function)(x, problem)
        bends = row @ tangent
        owed = row @ kept + along_problem(function)
        return jnp.where(jnp.abs(bends) > least, -owed / jnp.where(bends != 0, bends, 1.0), 0.0)

    straight = jnp.sum((tangent * _cost_scale(problem)) ** 2)
    least = 2 * _FLAT * straight
    step = further(stationary, least)
    bends = jax.jacfwd(stationary)(x, problem) @ tangent
    stopped = jnp.abs(stationary(x, problem)) > _TOOTH * jnp.maximum(bends, least)
    held = further(speed, jnp.float32(1e-3))
    if problem.net is not None:
        low = height(x, problem) < _AT_NET_M
        held = jnp.where(low, further(height, jnp.float32(1e-4)), held)
    return kept + jnp.where(stopped, held, step) * tangent


def _cost_scale(problem: AimProblem) -> Float[Array, "4"]:
    """What a unit of each unknown counts."""
    timed = jnp.where(jnp.isnan(problem.wanted), 0.0, problem.weight)
    return jnp.concatenate([jnp.ones(3, jnp.float32), timed[None]])


def _cost_slope(x: Float[Array, "4"], problem: AimProblem) -> Float[Array, "4"]:
    """Slope of |v − guess|² + (weight (T − wanted))²."""
    wanted = jnp.where(jnp.isnan(problem.wanted), x[3], problem.wanted)
    nearest = jnp.concatenate([problem.guess, wanted[None]])
    return 2 * _cost_scale(problem) ** 2 * (x - nearest)


def _null(jacobian: Float[Array, "3 4"]) -> Float[Array, "4"]:
    """The direction, of length 1, in which three functions of four unknowns stay what they are."""
    columns = [0, 1, 2, 3]
    parts: list[Array] = []
    for skipped in columns:
        rest = jacobian[:, jnp.array([c for c in columns if c != skipped])]
        parts.append((-1.0) ** skipped * jnp.linalg.det(rest))
    across = jnp.stack(parts)
    return across / jnp.maximum(jnp.sqrt(jnp.sum(across * across)), 1e-12)
