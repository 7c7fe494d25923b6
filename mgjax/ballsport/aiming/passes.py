"""A ball aimed at a place: the launch nearest to a guess that arrives after the wanted bounces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import jax
import numpy as np
from jax import lax
from jaxtyping import Float

from mgjax.ballsport.aiming.problem import make_problem
from mgjax.ballsport.aiming.slopes import with_slopes
from mgjax.ballsport.aiming.solve import (
    TOO_FAR,
    UNDER_NET,
    Aim,
    solve,
    solve_feasible,
    solve_nearest,
)
from mgjax.ballsport.aiming.updates import SECOND
from mgjax.ballsport.ball.physics import BallPhysics, Net, Number
from mgjax.ballsport.config import MAX_SPEED_M_S, MOST_BOUNCES
from mgjax.core.arrays import Array
from mgjax.core.calls.door import takes_not_finite
from mgjax.core.errors import ConfigError
from mgjax.core.ranges import check_range
from mgjax.core.xla.padding import bucket_size, pad_axis

PAPER = BallPhysics()
"""The paper's ball."""


@takes_not_finite
def aim(
    start: Float[Array, "3"],
    target: Float[Array, "3"],
    *,
    bounces: int,
    guess: Float[Array, "3"],
    physics: BallPhysics = PAPER,
    max_speed: Number = MAX_SPEED_M_S,
    net: Net | None = None,
    flight_time: Number | None = None,
    time_weight: Number = SECOND,
) -> Aim:
    """The launch near ``guess`` from which the ball meets ``target`` after just these bounces.

    The algorithm of Choi et al. 2019, §4: a first guess, then differential updates (eqs 7–8) until
    the ball passes within 0.1 mm of the target, less than the paper's 1 mm. The
    guess is scanned (:mod:`mgjax.ballsport.aiming.scan`): of the flights to the target the one with
    the least |v − guess|² + (time_weight (T − flight_time))². Where none is feasible, the nearest
    approach is searched (:mod:`mgjax.ballsport.aiming.nearest`).

    Compiled once for each number of bounces, drag law, and with or without net. May be called under
    ``jit`` and ``vmap``; under ``vmap`` each item also pays for the search of the nearest approach.
    For many passes :func:`aim_batch` is the entry point.

    Deviation:
        The paper begins at the bone's own velocity. From there the updates fail for most passes
        with two bounces (``experiments/ballsport/aim.py``).

    Gradients (forward and reverse mode) with respect to start, target, guess, flight time, its
    weight, the largest speed and the physics are those of the launch of least cost
    (:mod:`mgjax.ballsport.aiming.slopes`); where a pass cannot be they are 0.

    Degenerate: a start in the ground is lifted to rest height; a target on the ground is met 0.03
    mm above it, so that the arrival is no bounce; a target at the start is met by a ball that
    leaves and comes back.

    Args:
        start: the ball's centre when it is hit, m; y up, ground at 0.
        target: where its centre shall be, m. Below rest height nothing can be: status
            ``IN_GROUND``, and the place above it is met if it can.
        bounces: wanted, 0 … ``MOST_BOUNCES``; exact.
        guess: velocity to stay near, of the hit bone, m/s.
        physics: of the ball; default: the paper's.
        max_speed: largest kick speed, m/s.
        net: crossed only above its height, where it lies between start and target.
        flight_time: to stay near, s; default: any.
        time_weight: what a second of flight time counts beside a m/s, m/s².

    Raises:
        ConfigError: bounces, speed, weight or time out of range.
    """
    check_asked(bounces, max_speed, time_weight, flight_time)
    wanted = np.nan if flight_time is None else flight_time
    shared = time_weight, max_speed, net, physics
    return _aim(start, target, guess, wanted, shared, int(bounces))


@takes_not_finite
def aim_batch(
    starts: Float[Array, "N 3"],
    targets: Float[Array, "N 3"],
    *,
    bounces: int,
    guesses: Float[Array, "N 3"],
    physics: BallPhysics = PAPER,
    max_speed: Number = MAX_SPEED_M_S,
    net: Net | None = None,
    flight_times: Float[Array, " N"] | None = None,
    time_weight: Number = SECOND,
) -> Aim:
    """Many passes with as many bounces each; see :func:`aim`. Host code, NumPy arrays out.

    Passes are padded to a few sizes; only those that cannot be are searched for the nearest
    approach.

    Raises:
        ConfigError: bounces, speed, weight or time out of range.
    """
    check_asked(bounces, max_speed, time_weight)
    wanted = np.full(len(starts), np.nan) if flight_times is None else flight_times
    passes: tuple[Any, ...] = starts, targets, guesses, wanted
    items = [np.asarray(a, np.float32) for a in passes]
    shared = time_weight, max_speed, net, physics
    aims = _over(_feasible, items, shared, bounces)
    failed = np.flatnonzero((aims.status == TOO_FAR) | (aims.status == UNDER_NET))
    if len(failed):
        rest = [a[failed] for a in (*items, np.asarray(aims.status))]
        nearest = _over(_nearest, rest, shared, bounces)
        for old, new in zip(jax.tree.leaves(aims), jax.tree.leaves(nearest), strict=True):
            old[failed] = new
    return aims


def _over(
    solver: Callable[..., Aim], items: Sequence[np.ndarray], shared: Any, bounces: int
) -> Aim:
    """Runs a batched solver on padded items; writable NumPy arrays."""
    count = len(items[0])
    size = bucket_size(count)
    padded = (pad_axis(a, size, value=None if count else 0.0) for a in items)
    aims = solver(*padded, shared, bounces)
    return jax.tree.map(lambda a: np.array(a)[:count], aims)


@partial(jax.jit, static_argnames="bounces")
def _aim(
    start: Array, target: Array, guess: Array, wanted: Number, shared: Any, bounces: int
) -> Aim:
    problem = make_problem(start, target, guess, wanted, *shared)
    found = solve(lax.stop_gradient(problem), bounces)
    return with_slopes(problem, lax.stop_gradient(found), bounces)


@partial(jax.jit, static_argnames="bounces")
def _feasible(
    starts: Array, targets: Array, guesses: Array, wanted: Array, shared: Any, bounces: int
) -> Aim:
    def one(start: Array, target: Array, guess: Array, time: Array) -> Aim:
        return solve_feasible(make_problem(start, target, guess, time, *shared), bounces)

    return jax.vmap(one)(starts, targets, guesses, wanted)


@partial(jax.jit, static_argnames="bounces")
def _nearest(
    starts: Array,
    targets: Array,
    guesses: Array,
    wanted: Array,
    reasons: Array,
    shared: Any,
    bounces: int,
) -> Aim:
    def one(start: Array, target: Array, guess: Array, time: Array, reason: Array) -> Aim:
        return solve_nearest(make_problem(start, target, guess, time, *shared), reason, bounces)

    return jax.vmap(one)(starts, targets, guesses, wanted, reasons)


def check_asked(
    bounces: int, max_speed: Number, time_weight: Number, flight_time: Number | None = None
) -> None:
    """Raises :class:`ConfigError` unless a pass can be asked for so."""
    check_range("max_speed", max_speed, 0.0, 1000.0)
    check_range("time_weight", time_weight, 0.0, 1e6)
    if flight_time is not None:
        check_range("flight_time", flight_time, 0.0, 1000.0)
    is_whole = isinstance(bounces, int | np.integer) and not isinstance(bounces, bool)
    if not (is_whole and 0 <= bounces <= MOST_BOUNCES):
        raise ConfigError(f"got bounces = {bounces!r}, expected 0 … {MOST_BOUNCES}")
