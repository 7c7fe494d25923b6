"""The frame of a hit motion at which the ball is hit: the one whose own flight ends nearest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.ballsport.aiming.passes import PAPER, check_asked
from mgjax.ballsport.aiming.problem import FIRST_CONTACT, AimProblem, flight_arcs, make_problem
from mgjax.ballsport.aiming.solve import Aim, solve
from mgjax.ballsport.aiming.updates import SECOND
from mgjax.ballsport.ball.flight import contact_time, free_flight
from mgjax.ballsport.ball.physics import BallPhysics, Net, Number
from mgjax.ballsport.config import MAX_SPEED_M_S
from mgjax.core.arrays import Array
from mgjax.core.calls.door import takes_not_finite
from mgjax.core.errors import ConfigError
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.core.xla.pytree import register

SCALES = (0.8, 1.4)
"""Range of the ball's speed over the bone's: a well hit football leaves faster than the foot."""

_SCALED, _MOMENTS = 7, 17
"""Speeds tried per frame; moments of the last arc looked at, twice."""

_NO_FLIGHT = 1e12
"""Cost of a flight that cannot be."""


@register()
@dataclass(frozen=True, kw_only=True)
class HitChoice:
    """The chosen frame, its pass, and what all frames would have led to.

    Attributes:
        frame: chosen, of those in the mask.
        aim: the pass from there, adjusted exactly.
        velocities: of the ball per frame, the bone's with the best factor, m/s. [F,3]
        times: at which these flights are nearest to the target, s. [F]
        distances: how near they come, m; ``inf`` outside the mask and where there is no such
            flight. [F]
    """

    frame: Int[Array, ""]
    aim: Aim
    velocities: Float[Array, "F 3"]
    times: Float[Array, " F"]
    distances: Float[Array, " F"]


@takes_not_finite
def choose_frame(
    positions: Float[Array, "F 3"],
    velocities: Float[Array, "F 3"],
    target: Float[Array, "3"],
    *,
    bounces: int,
    mask: Bool[Array, " F"] | None = None,
    physics: BallPhysics = PAPER,
    scales: tuple[float, float] = SCALES,
    max_speed: Number = MAX_SPEED_M_S,
    net: Net | None = None,
    flight_time: Number | None = None,
    time_weight: Number = SECOND,
) -> HitChoice:
    """Chooses the hit frame in S_B and aims from it (Choi et al. 2019, §4, Table 1 and Fig. 6).

    For each frame the ball starts at the hit bone with the bone's velocity times some factors and
    flies with the wanted bounces; what counts is how near it comes to the target in its last arc.
    The nearest of all is then adjusted exactly, as by :func:`mgjax.ballsport.aiming.passes.aim`.
    Where a flight time is wanted, the square of the distance is increased by that of time_weight ·
    T · (T − flight_time): a distance over the flight time is about the change of velocity that
    closes it.

    Deviation:
        The table is missing in the text; this is its reading. The paper gives no factors.

    Args:
        positions: the ball's centre while it touches the hit bone, per frame, m. Below rest height
            it is lifted.
        velocities: of the hit bone, m/s.
        target: for the ball's centre, m.
        bounces, physics, max_speed, net, flight_time, time_weight: as for ``aim``.
        mask: frames of S_B; default: all.
        scales: smallest and largest speed of the ball over that of the bone.

    Raises:
        ConfigError: no frame, bounces or scales out of range.
    """
    check_asked(bounces, max_speed, time_weight, flight_time)
    count = len(positions)
    chosen = np.ones(count, bool) if mask is None else np.asarray(mask)
    if not chosen.any():
        raise ConfigError("got no frame in which the ball can be hit, expected at least one")
    if not 0 < scales[0] <= scales[1]:
        raise ConfigError(f"got scales {scales}, expected two numbers above 0 in rising order")
    size = bucket_size(count, 32)
    frames = (
        pad_axis(np.asarray(positions, np.float32), size),
        pad_axis(np.asarray(velocities, np.float32), size),
        pad_axis(chosen, size, value=0),
    )
    wanted = np.nan if flight_time is None else flight_time
    shared = wanted, time_weight, max_speed, net, physics
    choice = _choose(*frames, target, np.asarray(scales, np.float32), shared, int(bounces))
    return HitChoice(
        frame=choice.frame,
        aim=choice.aim,
        velocities=np.asarray(choice.velocities)[:count],
        times=np.asarray(choice.times)[:count],
        distances=np.asarray(choice.distances)[:count],
    )


@partial(jax.jit, static_argnames="bounces")
def _choose(
    positions: Array,
    velocities: Array,
    mask: Array,
    target: Array,
    scales: Array,
    shared: Any,
    bounces: int,
) -> HitChoice:
    factors = jnp.linspace(scales[0], scales[1], _SCALED)

    def one(position: Array, velocity: Array) -> tuple[Array, Array, Array, Array]:
        problem = make_problem(position, target, velocity, *shared)
        tried = factors[:, None] * problem.guess[None]
        cost, distance, time = jax.vmap(lambda v: _flight(problem, v, bounces))(tried)
        best = jnp.argmin(cost)
        return cost[best], distance[best], time[best], tried[best]

    cost, distance, time, kicked = jax.vmap(one)(positions, velocities)
    frame = jnp.argmin(jnp.where(mask, cost, jnp.inf))
    problem = make_problem(positions[frame], target, kicked[frame], *shared)
    return HitChoice(
        frame=frame,
        aim=solve(problem, bounces),
        velocities=kicked,
        times=time,
        distances=jnp.where(mask, distance, jnp.inf),
    )


def _flight(
    problem: AimProblem, velocity: Array, bounces: int
) -> tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""]]:
    """Cost, distance and time of the moment in the last arc that suits best."""
    arcs = flight_arcs(problem, velocity, bounces)
    start, place, v = arcs[-1]
    duration = contact_time(place[1], v, problem.physics)

    def at(share: Array) -> tuple[Array, Array, Array]:
        moved, _ = free_flight(v, share * duration, problem.physics)
        time = start + share * duration
        square = jnp.sum((place + moved - problem.target) ** 2)
        late = problem.weight * time * (time - problem.wanted)
        return square + jnp.where(jnp.isnan(late), 0.0, late * late), jnp.sqrt(square), time

    steps = jnp.linspace(0.0, 1.0, _MOMENTS)
    middle = steps[jnp.argmin(jax.vmap(at)(steps)[0])]
    near = jnp.clip(middle + (steps - 0.5) * 2 / (_MOMENTS - 1), 0.0, 1.0)
    costs, distances, times = jax.vmap(at)(near)
    best = jnp.argmin(costs)
    exists = jnp.asarray(True) if bounces == 0 else arcs[1][0] >= 2 * FIRST_CONTACT
    cost = jnp.where(exists, costs[best], _NO_FLIGHT)
    return cost, jnp.where(exists, distances[best], jnp.inf), times[best]
