"""The nearest a kick can come to a target that it cannot reach."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Float

from mgjax.ballsport.aiming.problem import (
    FIRST_CONTACT,
    SHORTEST,
    AimProblem,
    Launch,
    clears_net,
    flight_arcs,
)
from mgjax.ballsport.ball.flight import contact_time, free_flight
from mgjax.core.arrays import Array

_ELEVATIONS, _MOMENTS = 33, 17
_ROUNDS = 9
_ZOOM = 0.3
"""Factor on the window after each round; 0.3 leaves some grid cells about the best."""

_BELOW = 0.9999
"""Share of the largest speed that is used."""

_EDGE = 1e-4
"""Share of the last arc that is left out at both ends, so that rounding makes no other bounces."""

_BLOCKED = 1e12
"""Cost of a flight that meets the net or has other bounces, m²."""


def nearest_launch(problem: AimProblem, bounces: int) -> Launch:
    """The flight with the wanted bounces, above the net, that passes nearest to the target.

    What lies beyond reach is approached best at the largest speed: at a smaller one the launch
    could change in all directions, and some of them leads nearer. And it is approached in the
    upright plane through start and target. So two numbers remain, the elevation of the kick and the
    moment within the last arc; their grid is narrowed about its best point again and again.
    """
    flat = jnp.asarray(problem.target).at[1].set(0.0)
    length = jnp.sqrt(jnp.sum(flat * flat))
    aside = jnp.array([1.0, 0.0, 0.0], jnp.float32)
    ahead = jnp.where(length > 1e-6, flat / jnp.maximum(length, 1e-6), aside)

    def cost(elevation: Array, moments: Array) -> tuple[Float[Array, " M"], Float[Array, " M"]]:
        """Squared distance at some moments, given as shares of the last arc; and the times."""
        velocity = _kick(problem, ahead, elevation)
        arcs = flight_arcs(problem, velocity, bounces)
        t, place, v = arcs[-1]
        duration = contact_time(place[1], v, problem.physics)
        blocked = (arcs[1][0] < 2 * FIRST_CONTACT) if bounces else jnp.asarray(False)

        def at(moment: Array) -> tuple[Array, Array]:
            moved, _ = free_flight(v, moment * duration, problem.physics)
            time = t + moment * duration
            out = (
                ~clears_net(problem, Launch(velocity, time), bounces) | (time < SHORTEST) | blocked
            )
            return jnp.where(out, _BLOCKED, jnp.sum((place + moved - problem.target) ** 2)), time

        return jax.vmap(at)(moments)

    def zoom(_: Array, state: tuple[Array, ...]) -> tuple[Array, ...]:
        angle, moment, size = state
        steps = size * jnp.linspace(-1.0, 1.0, _ELEVATIONS)
        angles = jnp.clip(angle + steps * jnp.pi / 2, -jnp.pi / 2, jnp.pi / 2)
        shares = jnp.clip(moment + size / 2 * jnp.linspace(-1.0, 1.0, _MOMENTS), _EDGE, 1 - _EDGE)
        costs, _ = jax.vmap(cost, (0, None))(angles, shares)
        best = jnp.argmin(costs)
        return angles[best // _MOMENTS], shares[best % _MOMENTS], size * _ZOOM

    middle = jnp.zeros((), jnp.float32), jnp.full((), 0.5, jnp.float32), jnp.ones((), jnp.float32)
    angle, moment, _ = lax.fori_loop(0, _ROUNDS, zoom, middle)
    _, times = cost(angle, moment[None])
    return Launch(_kick(problem, ahead, angle), times[0])


def _kick(problem: AimProblem, ahead: Array, elevation: Array) -> Float[Array, "3"]:
    up = jnp.array([0.0, 1.0, 0.0], jnp.float32)
    return _BELOW * problem.max_speed * (jnp.cos(elevation) * ahead + jnp.sin(elevation) * up)
