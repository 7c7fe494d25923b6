"""Passes that take just so long: with the time given, the velocity is what is left to find."""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.ballsport.aiming.passes import aim_batch
from mgjax.ballsport.aiming.problem import Launch, arrive, clears_net, make_problem
from mgjax.ballsport.ball.physics import BallPhysics, Net
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import bucket_size, pad_axis

_WEIGHT = 300.0
"""What a second of flight time counts beside a m/s where the first launch is looked for."""
SIZE = 256
"""Least number of passes in a call, so that one compiled program serves them all."""
_STEPS = 6
_CLOSE = 2e-4
"""Largest miss of a launch, m."""


def aim_timed(
    starts: Float[np.ndarray, "N 3"],
    targets: Float[np.ndarray, "N 3"],
    times: Float[np.ndarray, " N"],
    *,
    bounces: int,
    guesses: Float[np.ndarray, "N 3"],
    physics: BallPhysics,
    max_speed: float,
    net: Net | None,
) -> tuple[Float[np.ndarray, "N 3"], Bool[np.ndarray, " N"]]:
    """Launches that meet the targets after just these times and bounces, and which of them do.

    :func:`mgjax.ballsport.aiming.passes.aim_batch` with a strong wish for the time, then Newton's
    iteration on the three components of the velocity. A pass in a scene arrives when the receiver's
    foot is there, on a frame of the motion; 10 m/s times half a frame would be 8 cm beside it.

    Degenerate: a launch that does not meet its target is as ``aim_batch`` left it.
    """
    count, size = len(starts), bucket_size(len(starts), SIZE)
    passes = starts, targets, times, guesses
    items = [pad_axis(np.asarray(x, np.float32), size) for x in passes]
    aims = aim_batch(
        items[0],
        items[1],
        bounces=bounces,
        guesses=items[3],
        physics=physics,
        max_speed=max_speed,
        net=net,
        flight_times=items[2],
        time_weight=_WEIGHT,
    )
    items = (*items[:3], np.asarray(aims.velocity))
    velocity, met = _pinned(*items, (max_speed, net, physics), int(bounces))
    met = np.asarray(met)[:count]
    return np.where(met[:, None], np.asarray(velocity)[:count], aims.velocity[:count]), met


@partial(jax.jit, static_argnames="bounces")
def _pinned(
    starts: Array, targets: Array, times: Array, velocities: Array, shared: Any, bounces: int
) -> tuple[Array, Array]:
    def one(start: Array, target: Array, time: Array, guess: Array) -> tuple[Array, Array]:
        max_speed, net, physics = shared
        problem = make_problem(start, target, guess, time, _WEIGHT, max_speed, net, physics)

        def miss(velocity: Array) -> tuple[Array, tuple[Array, Array]]:
            return arrive(problem, Launch(velocity, time), bounces)

        def step(_: Array, velocity: Array) -> Array:
            slope, (off, _) = jax.jacfwd(miss, has_aux=True)(velocity)
            return velocity - jnp.linalg.solve(slope, off)

        velocity = jax.lax.fori_loop(0, _STEPS, step, guess)
        _, (off, kept) = miss(velocity)
        speed = jnp.sqrt(jnp.sum(velocity**2))
        met = kept & (jnp.sum(off**2) <= _CLOSE**2) & (speed <= max_speed)
        return velocity, met & clears_net(problem, Launch(velocity, time), bounces)

    return jax.vmap(one)(starts, targets, times, velocities)
