"""One pass to aim, as the solvers see it: seen from the start, heights counted from rest height."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float

from mgjax.ballsport.ball.flight import free_flight, next_arc, traced
from mgjax.ballsport.ball.physics import BallPhysics, Net, Number
from mgjax.core.arrays import Array

MARGIN = 3e-5
"""Least height above rest height at which a pass may end, m. A ball that arrives on the ground
would have its last bounce at the same instant, and rounding would decide whether it counts."""

SHORTEST = 0.01
"""Shortest flight, s. Without it a target at the start is met by not flying at all."""

FIRST_CONTACT = 1e-3
"""Earliest first contact, s: a ball that lies on the ground is not kicked into it."""

_CROSSING_STEPS = 6
"""Newton steps to the crossing of the net."""


class AimProblem(NamedTuple):
    """What is asked.

    Attributes:
        start: as given.
        asked: the target as given.
        height: of the start.
        target: from the start, but y is the height above rest height, ``MARGIN`` at least.
        guess: velocity to stay near, m/s.
        wanted: flight time to stay near, s; NaN: none.
        weight: of a second beside a m/s, m/s².
        max_speed: of the kick, m/s.
        net: distance from the start to the net over that to the target, both along the net's
            normal, and its height; the ball meets the net where the first is within 0 … 1. None:
            no net.
        physics: with float32 numbers.
    """

    start: Float[Array, "3"]
    asked: Float[Array, "3"]
    height: Float[Array, ""]
    target: Float[Array, "3"]
    guess: Float[Array, "3"]
    wanted: Float[Array, ""]
    weight: Float[Array, ""]
    max_speed: Float[Array, ""]
    net: tuple[Float[Array, ""], Float[Array, ""]] | None
    physics: BallPhysics


class Launch(NamedTuple):
    """The unknowns of a pass, four numbers for three equations: velocity, m/s, and time, s."""

    velocity: Float[Array, "3"]
    time: Float[Array, ""]


def make_problem(
    start: Array,
    target: Array,
    guess: Array,
    wanted: Number,
    weight: Number,
    max_speed: Number,
    net: Net | None,
    physics: BallPhysics,
) -> AimProblem:
    """Moves the start to the origin, so that float32 is as fine far from the world's origin."""
    physics = traced(physics)
    begin, end = _float32(start), _float32(target)
    height = jnp.maximum(begin[1] - physics.radius, 0.0)
    displacement = end - begin
    return AimProblem(
        start=begin,
        asked=end,
        height=height,
        target=displacement.at[1].set(jnp.maximum(end[1] - physics.radius, MARGIN)),
        guess=_float32(guess),
        wanted=_float32(wanted),
        weight=_float32(weight),
        max_speed=_float32(max_speed),
        net=None if net is None else _net_ahead(begin, displacement, jax.tree.map(_float32, net)),
        physics=physics,
    )


def _float32(value: Number) -> jax.Array:
    return jnp.asarray(value, jnp.float32)


def _net_ahead(start: Array, displacement: Array, net: Net) -> tuple[Array, Array]:
    across = jnp.sin(net.heading), jnp.cos(net.heading)
    near = across[0] * (net.x - start[0]) + across[1] * (net.z - start[2])
    far = across[0] * displacement[0] + across[1] * displacement[2]
    crosses = near * (far - near) > 0
    return jnp.where(crosses, near / jnp.where(crosses, far, 1.0), -1.0), net.height


def flight_arcs(
    problem: AimProblem, velocity: Array, bounces: int
) -> list[tuple[Array, Array, Array]]:
    """Time, place and velocity at the beginning of each arc up to the one after ``bounces``."""
    zero = jnp.zeros_like(problem.height)
    begin = jnp.stack([zero, problem.height, zero])
    arcs: list[tuple[Array, Array, Array]] = [(zero, begin, velocity)]
    for _ in range(bounces):
        t, place, v = arcs[-1]
        duration, place, v = next_arc(place, v, problem.physics)
        arcs.append((t + duration, place, v))
    return arcs


def arrive(
    problem: AimProblem, launch: Launch, bounces: int
) -> tuple[Float[Array, "3"], tuple[Float[Array, "3"], Bool[Array, ""]]]:
    """S(t, u) of eq. 6 with a fixed number of bounces, minus the target.

    Returns:
        The miss vector, and again with whether the ball really has had just these bounces, in the
        form that ``jax.jacfwd`` takes. Where it has not, the last arc is continued beyond its ends.
    """
    arcs = flight_arcs(problem, launch.velocity, bounces)
    t, place, v = arcs[-1]
    moved, _ = free_flight(v, launch.time - t, problem.physics)
    end = place + moved
    kept = (launch.time >= t) & (end[1] >= 0) & (launch.time >= SHORTEST)
    if bounces > 0:
        kept &= arcs[1][0] >= FIRST_CONTACT
    miss = end - problem.target
    return miss, (miss, kept)


def clears_net(problem: AimProblem, launch: Launch, bounces: int) -> Bool[Array, ""]:
    """Whether the ball's lowest point is above the net where it crosses it, if it does."""
    return net_margin(problem, launch, bounces) >= 0


def net_margin(problem: AimProblem, launch: Launch, bounces: int) -> Float[Array, ""]:
    """How far the ball's lowest point is above the net where it crosses it, m; inf elsewhere."""
    if problem.net is None:
        return jnp.asarray(jnp.inf)
    fraction, height = problem.net
    arcs = flight_arcs(problem, launch.velocity, bounces)

    def at(time: Array) -> tuple[Array, Array]:
        place = speed = jnp.zeros(3, jnp.float32)
        for t, p, v in arcs:
            moved, then = free_flight(v, time - t, problem.physics)
            place = jnp.where(time >= t, p + moved, place)
            speed = jnp.where(time >= t, then, speed)
        return place, speed

    # The way over the floor is straight, and concave in time: from the left Newton is monotone.
    displacement = jnp.stack([problem.target[0], jnp.zeros_like(height), problem.target[2]])
    length = jnp.sqrt(jnp.sum(displacement * displacement))
    ahead, distance = displacement / jnp.maximum(length, 1e-6), fraction * length
    time = distance / jnp.maximum(jnp.sum(ahead * launch.velocity), 1e-6)
    for _ in range(_CROSSING_STEPS):
        place, speed = at(time)
        gap = jnp.sum(place * ahead) - distance
        time = time - gap / jnp.maximum(jnp.sum(speed * ahead), 1e-6)
    short = jnp.sum(at(launch.time)[0] * ahead) < distance
    return jnp.where((fraction < 0) | short, jnp.inf, at(time)[0][1] - height)
