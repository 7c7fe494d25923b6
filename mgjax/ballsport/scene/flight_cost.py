"""When a ball shall arrive: flight times and link paths to the hit, weighed against each other."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.ballsport.ball.physics import BallPhysics
from mgjax.ballsport.ball.trajectory import fly
from mgjax.ballsport.scene.kick import kick_change
from mgjax.ballsport.scene.link_paths import LinkPaths
from mgjax.ballsport.scene.player import MOST_WARP
from mgjax.ballsport.scene.types import BallStart
from mgjax.core.arrays import Array

_THROW_M_S = 10.0
"""Speed of a throw that is as unwelcome as a ball twice as fast as the bone that kicks it."""
_SECTION_COST, _WARP_COST, _BODY_COST = 2.0, 3.0, 5.0
"""What a metre of D_p, a doubling of the pace and a metre of a body in the way count beside a
change of the kick by the bone's own speed."""
_BODY_M, _BODY_TOP_M = 0.45, 2.0
"""Half width and height of the space of a player who does not take part."""
_SAMPLES = 32


def flight_cost(
    start: BallStart,
    velocities: Float[np.ndarray, "N 3"],
    met: Bool[np.ndarray, " N"],
    seconds: Float[np.ndarray, " N"],
    others: Sequence[np.ndarray],
    physics: BallPhysics,
) -> Float[np.ndarray, " N"]:
    """How unwelcome each flight is: the change of the kick, and bodies in its way.

    Args:
        start: where the ball starts, and the bone that hits it.
        velocities: of the ball, m/s.
        met: whether it arrives; infinite where not.
        seconds: flight times.
        others: where players stand who do not take part, m.
        physics: of the ball.
    """
    if start.bone is None:
        cost = np.linalg.norm(velocities, axis=1) / _THROW_M_S
    else:
        cost = kick_change(velocities, start.bone[None])
    cost = np.where(met, cost, np.inf)
    if not others:
        return cost
    paths = np.asarray(
        _paths(
            start.place.astype(np.float32),
            velocities.astype(np.float32),
            seconds.astype(np.float32),
            physics,
        )
    )
    away = paths[:, :, None, [0, 2]] - np.array(others)[None, None][..., [0, 2]]
    gap = np.linalg.norm(away, axis=-1) - physics.radius
    low = paths[:, :, None, 1] < _BODY_TOP_M
    deep = np.where(low, np.maximum(_BODY_M - gap, 0.0), 0.0).max(axis=(1, 2))
    return cost + _BODY_COST * deep


def cheapest(
    paths: LinkPaths,
    free: np.ndarray,
    fixed: int,
    begin: int,
    times: np.ndarray,
    flight: np.ndarray,
) -> list[tuple[int, int]]:
    """Pairs of a link path and an arrival, the best path for each arrival, cheapest first."""
    usable = np.flatnonzero(free > 0)
    # Of the paths that take as long, the one with the smoothest sections.
    usable = usable[np.lexsort((paths.cost[usable], free[usable]))]
    _, first = np.unique(free[usable], return_index=True)
    usable = usable[first]
    have = (times - fixed - begin)[None].astype(np.float64)
    pace = free[usable][:, None] / np.where(have > 0, have, np.nan)
    fits = (pace <= MOST_WARP) & (pace >= 1 / MOST_WARP)
    cost = flight[None] + _SECTION_COST * paths.cost[usable][:, None]
    cost = np.where(fits, cost + _WARP_COST * np.abs(np.nan_to_num(pace) - 1), np.inf)
    if not cost.size:
        return []
    best = np.argmin(cost, axis=0)
    value = cost[best, np.arange(len(times))]
    columns = np.argsort(value)
    return [(int(usable[best[c]]), int(c)) for c in columns if np.isfinite(value[c])]


@jax.jit
def _paths(place: Array, velocities: Array, times: Array, physics: BallPhysics) -> Array:
    """[N, S, 3] where balls are at even moments up to the given times."""
    shares = jnp.linspace(0.0, 1.0, _SAMPLES, dtype=jnp.float32)
    return jax.vmap(lambda v, t: fly(place, v, shares * t, physics=physics))(velocities, times)
