"""The path of a ball that is let go: arcs between contacts, then rolling."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Float

from mgjax.ballsport.ball.flight import free_flight, lifted, next_arc, traced
from mgjax.ballsport.ball.physics import BallPhysics
from mgjax.core.arrays import Array

BOUNCES = 16
"""Bounces that are computed; at the contact after them the ball begins to roll."""


@jax.jit
def fly(
    position: Float[Array, "3"],
    velocity: Float[Array, "3"],
    times: Float[Array, " T"],
    *,
    physics: BallPhysics,
) -> Float[Array, "T 3"]:
    """Where the ball is at each time after it is let go (Choi et al. 2019, eqs 3–6).

    Up to ``BOUNCES`` bounces, each at its exact time; from the contact after them on the ball rolls
    at rest height: the vertical speed is gone, the horizontal one goes on with air resistance only.
    With restitution 0.7 the seventeenth contact is slower than 0.4 % of the first, so nothing is
    seen of it; with restitution near 1 the end of the bouncing is a cut.

    Derivatives with respect to position, velocity, times and physics go through the bounces. They
    are finite everywhere, and one-sided at a contact. Many balls: ``vmap``.

    Degenerate: a start in the ground is lifted to the rest height; on the ground a ball that moves
    down bounces at once and one without vertical speed rolls. Times before 0 count as 0.

    Args:
        position: of the centre, m; y up, ground at 0.
        velocity: m/s.
        times: s after the start, in any order.
        physics: gravity, drag, restitution, radius.

    Returns:
        Positions of the centre, m.
    """
    return _states(position, velocity, times, physics)[0]


@jax.jit
def ball_states(
    position: Float[Array, "3"],
    velocity: Float[Array, "3"],
    times: Float[Array, " T"],
    *,
    physics: BallPhysics,
) -> tuple[Float[Array, "T 3"], Float[Array, "T 3"]]:
    """Positions and velocities at each time; see :func:`fly`. At a contact: just after it."""
    return _states(position, velocity, times, physics)


@jax.jit
def contact_times(
    position: Float[Array, "3"], velocity: Float[Array, "3"], *, physics: BallPhysics
) -> Float[Array, " N"]:
    """Times of the bounces, s, and last of the contact at which the ball begins to roll.

    A ball at rest on the ground has all its contacts at 0.
    """
    return _arcs(position, velocity, traced(physics))[0][1:]


def _states(
    position: Array, velocity: Array, times: Array, physics: BallPhysics
) -> tuple[Array, Array]:
    physics = traced(physics)
    starts, places, velocities = _arcs(position, velocity, physics)
    last = len(starts) - 1

    def at(t: Array) -> tuple[Array, Array]:
        t = jnp.where(t > 0, t, 0.0)
        arc = jnp.sum(t >= starts[1:])
        pull = jnp.where(arc == last, 0.0, physics.gravity)
        moved, v = free_flight(velocities[arc], t - starts[arc], replace(physics, gravity=pull))
        place = places[arc] + moved
        height = jnp.where(place[1] >= 0, place[1], 0.0)
        return place.at[1].set(height + physics.radius), v

    return jax.vmap(at)(jnp.asarray(times, jnp.float32))


def _arcs(
    position: Array, velocity: Array, physics: BallPhysics
) -> tuple[Float[Array, " A"], Float[Array, "A 3"], Float[Array, "A 3"]]:
    """Beginning of each arc: time, position (y from the rest height), velocity."""
    place = lifted(jnp.asarray(position, jnp.float32), physics)
    start = jnp.zeros((), jnp.float32), place, jnp.asarray(velocity, jnp.float32)

    def arc(state: tuple[Array, Array, Array], _: None) -> tuple[tuple, tuple]:
        t, p, v = state
        duration, p2, v2 = next_arc(p, v, physics)
        return (t + duration, p2, v2), state

    (t, p, v), before = lax.scan(arc, start, None, length=BOUNCES + 1)
    rolling = t, p, v.at[1].set(0.0)
    return jax.tree.map(lambda a, b: jnp.concatenate([a, b[None]]), before, rolling)
