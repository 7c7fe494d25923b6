"""Where to begin: the flight to the target that is nearest to the bone's velocity.

With linear drag the height does not depend on the horizontal velocity, and the way over the floor
not on the bounces. So each vertical velocity leads, by its bounces, to at most two moments at which
the ball is at the target's height, rising and falling, and each moment to the horizontal velocity
that brings it there. Vertical velocities are scanned again and again: over the whole range, densely
about the guess, then between the neighbours of the best one, from where a parabola through the
three is lowest outwards.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Bool, Float

from mgjax.ballsport.aiming.problem import FIRST_CONTACT, SHORTEST, AimProblem, Launch
from mgjax.core.arrays import Array
from mgjax.core.ballistics import drag_integrals

_SCANNED, _ROUNDS = 13, 4
"""Vertical velocities in each scan, and scans: the best is then known to about 0.05 m/s, and much
better where the cost is smooth."""

_NEWTON_STEPS = 4
"""For each contact and crossing; what they leave, the updates take up."""

_DRAG_ROUNDS = 3
"""For the linear drag that stands for a quadratic one."""

_OFF = 1e-3
"""Farthest from the target's height at which a crossing counts as one, m."""

_BELOW = 0.9995
"""Share of the largest speed that the scan allows: the updates may need the rest."""

_ABOVE = 1e-3
"""Height above the net that the scan asks for, m, for the same reason."""

_FAR = 1e12
"""Cost of what is no flight to the target."""

_TOO_FAST = 1e8
"""Cost of exceeding the largest speed or touching the net: larger than that of any deviation."""


class Guess(NamedTuple):
    """What the scan found.

    Attributes:
        launch: to begin with.
        feasible: it is within the largest speed and above the net.
        reached: some flight is within the largest speed, above the net or not.
    """

    launch: Launch
    feasible: Bool[Array, ""]
    reached: Bool[Array, ""]


def guess_launch(problem: AimProblem, bounces: int) -> Guess:
    """The scanned flight nearest to the guess: least |v − guess|² + (weight (T − wanted))².

    With quadratic drag each flight is scanned with the linear drag that is as strong at its mean
    speed, and ends only near the target.
    """
    s = jnp.linspace(-1.0, 1.0, _SCANNED)
    top, middle = (
        problem.max_speed,
        jnp.clip(problem.guess[1], -problem.max_speed, problem.max_speed),
    )
    reach = jnp.where(s > 0, top - middle, top + middle)
    coarse = middle + s * jnp.sqrt(jnp.abs(s)) * reach

    def scan(vertical: Array, _: None) -> tuple[Array, Guess]:
        cost, launch, reached = _flights(problem, vertical, bounces)
        flat = cost.reshape(-1)
        index = jnp.argmin(flat)
        chosen = Launch(launch.velocity.reshape(-1, 3)[index], launch.time.reshape(-1)[index])
        place = index % _SCANNED
        low = vertical[jnp.maximum(place - 1, 0)]
        high = vertical[jnp.minimum(place + 1, _SCANNED - 1)]
        centre = _lowest(vertical, cost[index // _SCANNED], place)
        finer = centre + jnp.abs(s) * (jnp.where(s > 0, high, low) - centre)
        return finer, Guess(chosen, flat[index] < _TOO_FAST, jnp.any(reached))

    _, rounds = lax.scan(scan, coarse, None, length=_ROUNDS)
    return jax.tree.map(lambda a: a[-1], rounds)


def _lowest(vertical: Float[Array, " K"], cost: Float[Array, " K"], place: Array) -> Array:
    """Where the parabola through the best flight and its neighbours is lowest."""
    middle = jnp.clip(place, 1, _SCANNED - 2)
    at = vertical[middle]
    back, ahead = at - vertical[middle - 1], vertical[middle + 1] - at
    fall, rise = cost[middle] - cost[middle - 1], cost[middle + 1] - cost[middle]
    fits = (place == middle) & (fall <= 0) & (rise >= 0) & (rise - fall > 0)
    fits &= cost[middle + 1] - fall < _TOO_FAST  # all three are flights
    weight = fall * ahead * ahead + rise * back * back
    bend = rise * back - fall * ahead
    fits &= bend > 0  # two of them may be one, at the largest speed
    halfway = (
        vertical[jnp.maximum(place - 1, 0)] + vertical[jnp.minimum(place + 1, _SCANNED - 1)]
    ) / 2
    return jnp.where(fits, at - weight / (2 * jnp.where(fits, bend, 1.0)), halfway)


def _flights(
    problem: AimProblem, vertical: Float[Array, " K"], bounces: int
) -> tuple[Float[Array, "2 K"], Launch, Bool[Array, "2 K"]]:
    """The falling and the rising flight of each vertical velocity; see :func:`_flight`."""

    def flight(v: Array, rising: Array) -> tuple[Array, Launch, Array]:
        return _flight(problem, v, rising, bounces)

    # The arcs do not depend on the side, so with linear drag they are computed once for both.
    both = jax.vmap(jax.vmap(flight, (0, None)), (None, 0))
    return both(vertical, jnp.array([False, True]))


def _flight(
    problem: AimProblem, vertical: Array, rising: Array, bounces: int
) -> tuple[Float[Array, ""], Launch, Bool[Array, ""]]:
    """One flight: its cost, its launch, and whether it exists within the largest speed."""
    wx, wz = problem.target[0], problem.target[2]
    drag = problem.physics.drag
    if problem.physics.drag_law == "quadratic":
        drag = _equal_drag(problem, vertical, rising, bounces)
    arcs = _arcs(problem, vertical, drag, bounces)
    time, exists = _crossing(problem, arcs, rising, drag)
    per_metre = 1 / drag_integrals(time, drag)[1]
    x, z = wx * per_metre, wz * per_metre
    dx, dy, dz = x - problem.guess[0], vertical - problem.guess[1], z - problem.guess[2]
    late = jnp.where(jnp.isnan(problem.wanted), 0.0, problem.weight * (time - problem.wanted))
    cost = dx * dx + dy * dy + dz * dz + late * late
    excess = jnp.sqrt(x * x + vertical * vertical + z * z) - _BELOW * problem.max_speed
    slow = excess <= 0
    blocked = ~_above_net(problem, arcs, time, drag)
    cost = jnp.where(blocked, _TOO_FAST, cost) + jnp.where(slow, 0.0, _TOO_FAST + excess * excess)
    cost = jnp.where(exists, jnp.minimum(cost, _FAR), _FAR)
    return cost, Launch(jnp.stack([x, vertical, z]), time), exists & slow


def _equal_drag(problem: AimProblem, vertical: Array, rising: Array, bounces: int) -> Array:
    """The linear drag as strong as the quadratic one at the flight's mean speed."""
    length = jnp.hypot(problem.target[0], problem.target[2])

    def again(_: Array, drag: Array) -> Array:
        arcs = _arcs(problem, vertical, drag, bounces)
        time, _ = _crossing(problem, arcs, rising, drag)
        return problem.physics.drag * jnp.hypot(length / time, vertical / 2)

    first = problem.physics.drag * jnp.hypot(jnp.sqrt(jnp.sum(problem.guess**2)), vertical) / 2
    return lax.fori_loop(0, _DRAG_ROUNDS, again, first)


def _arcs(
    problem: AimProblem, vertical: Array, drag: Array, bounces: int
) -> list[tuple[Array, ...]]:
    """Time, height and vertical velocity at the beginning of each arc."""
    zero = jnp.zeros_like(vertical)
    arcs = [(zero, problem.height, vertical)]
    for _ in range(bounces):
        t, height, v = arcs[-1]
        duration = _fall(problem, height, v, drag)
        e0, e1, _ = drag_integrals(duration, drag)
        up = problem.physics.restitution * (problem.physics.gravity * e1 - v * e0)
        arcs.append((t + duration, zero, jnp.maximum(up, 0.0)))
    return arcs


def _crossing(
    problem: AimProblem, arcs: list[tuple[Array, ...]], rising: Array, drag: Array
) -> tuple[Float[Array, ""], Bool[Array, ""]]:
    """When the last arc crosses the target's height, and whether it does."""
    start, height, v = arcs[-1]
    above, gravity = height - problem.target[1], problem.physics.gravity
    root = jnp.sqrt(jnp.maximum(v * v + 2 * gravity * above, 0.0))
    up = -2 * above / jnp.where(v + root > 0, v + root, jnp.inf)
    local = _newton(jnp.where(rising, up, _drag_free(above, v, gravity)), above, v, drag, gravity)
    _, e1, e2 = drag_integrals(local, drag)
    exists = jnp.abs(above + v * e1 - gravity * e2) < _OFF
    exists &= (local >= 0) & (start + local >= SHORTEST)
    if len(arcs) > 1:
        exists &= arcs[1][0] >= 2 * FIRST_CONTACT
    return jnp.where(exists, start + local, 1.0), exists


def _drag_free(above: Array, v: Array, gravity: Array) -> Array:
    """Time of falling ``above`` metres; where the ball never is so high, that of turning back."""
    root = jnp.sqrt(jnp.maximum(v * v + 2 * gravity * above, 0.0))
    falls = v <= 0
    below = jnp.where(falls, jnp.maximum(root - v, 1e-30), 1.0)
    return jnp.where(falls, 2 * above / below, (v + root) / gravity)


def _fall(problem: AimProblem, above: Array, v: Array, drag: Array) -> Array:
    """Time until contact; see :func:`mgjax.ballsport.ball.flight.contact_time`."""
    gravity = problem.physics.gravity
    return _newton(_drag_free(above, v, gravity), above, v, drag, gravity)


def _newton(t: Array, above: Array, v: Array, drag: Array, gravity: Array) -> Array:
    for _ in range(_NEWTON_STEPS):
        e0, e1, e2 = drag_integrals(t, drag)
        rate = v * e0 - gravity * e1
        t = t - (above + v * e1 - gravity * e2) / jnp.where(rate != 0, rate, -1.0)
    return t


def _above_net(
    problem: AimProblem, arcs: list[tuple[Array, ...]], time: Array, drag: Array
) -> Array:
    """Whether the flight clears the net, by ``_ABOVE``."""
    if problem.net is None:
        return jnp.ones_like(time, bool)
    fraction, height = problem.net
    _, total, _ = drag_integrals(time, drag)
    t = fraction * total
    for _ in range(_NEWTON_STEPS):
        e0, e1, _ = drag_integrals(t, drag)
        t = t - (e1 - fraction * total) / e0
    height_there = jnp.zeros_like(time)
    for start, begin, v in arcs:
        _, e1, e2 = drag_integrals(t - start, drag)
        height_there = jnp.where(
            t >= start, begin + v * e1 - problem.physics.gravity * e2, height_there
        )
    return (fraction < 0) | (height_there >= height + _ABOVE)
