"""Where feet and root should be while a motion is played: a filter that runs along its frames.

A point of a foot that stands comes to rest and stays there, whatever the played motion does with
it; when it is lifted, what it is off fades on its way to the next step. The root follows what the
standing feet are off, so that legs keep their shape. Nothing looks ahead: what is added to a
motion later never changes what comes before, and a motion begins as it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

STOP_S = 0.012
"""In which the speed of a point that comes to stand falls to 1/e, s."""
SWING_S = 0.1
"""Time constant at which the offset of a lifted foot fades, s."""
LEAD_S = 0.1
"""Time constant at which the root follows the standing feet, s."""
KEPT = 0.6
"""Share of what the root is off that a lifted foot keeps."""
EASY_M, MOST_M = 0.06, 0.10
"""An adult's foot is led back slowly where it is farther than the first from where the led body has
it, and never farther than the second, m."""
MOST_LEAD_M = 0.10
"""The root of an adult is led at most so far, m."""
SLIP_PER_S = 4.0
"""How fast a foot that is ``MOST_M`` off is led back: the rate of its excess."""
RISE_M_S = 0.25
"""Speed at which a foot, or the pelvis of an adult, may be moved up or down at least, m/s."""
FALL_S = 0.12
"""Time constant at which a lift or drop that is needed no more fades, s."""
ANCHOR_S = 0.06
"""Time constant at which a foot changes from one of its points to the other, s."""


@register()
@dataclass(frozen=True, kw_only=True)
class FeetState:
    """What feet and root are off at a moment of a motion, in the world. All zero: nothing.

    Of several moments, all fields have an axis of them before.

    Attributes:
        offset: of the ball and the ankle of the left and the right foot, over the floor, m.
        drift: how fast it changes, m/s.
        lead: of the root, over the floor, m.
        leading: how fast it changes, m/s.
        lift: of each foot, upwards, m.
        drop: of the pelvis, downwards, m.
        anchor: how much each foot is held by its ball, 0 … 1; the rest by its ankle.
    """

    offset: Float[Array, "*t 2 2 2"]
    drift: Float[Array, "*t 2 2 2"]
    lead: Float[Array, "*t 2"]
    leading: Float[Array, "*t 2"]
    lift: Float[Array, "*t 2"]
    drop: Float[Array, "*t"]
    anchor: Float[Array, "*t 2"]


def at_rest() -> FeetState:
    """The state of a motion that is as it is."""
    pair, feet = np.zeros(2, np.float32), np.zeros((2, 2, 2), np.float32)
    return FeetState(
        offset=feet,
        drift=feet,
        lead=pair,
        leading=pair,
        lift=pair,
        drop=np.zeros((), np.float32),
        anchor=np.ones(2, np.float32),
    )


def turned(state: FeetState, angle: float) -> FeetState:
    """The state in a world that is turned by ``angle`` about +Y, rad (see ``core.planar``)."""
    c, s = np.cos(angle), np.sin(angle)

    def turn(vector: Array) -> Array:
        x, z = vector[..., 0], vector[..., 1]
        return np.stack([x * c + z * s, z * c - x * s], axis=-1).astype(np.float32)

    return replace(
        state,
        offset=turn(state.offset),
        drift=turn(state.drift),
        lead=turn(state.lead),
        leading=turn(state.leading),
    )


def course(
    points: Float[Array, "T 2 2 3"],
    hips: Float[Array, "T 2 3"],
    reach: Float[Array, "T 2"],
    stands: Bool[Array, "T 2 2"],
    begin: FeetState,
    *,
    rate: Array | float,
    scale: Array | float,
    before: Float[Array, "2 2 2"] | None = None,
) -> FeetState:
    """The state at every frame of a motion. All fields of the result have an axis [T] before.

    Args:
        points: ball and ankle of the left and the right foot, m.
        hips: left and right, m.
        reach: farthest that each ankle may be from its hip, m.
        stands: which points stand.
        begin: the state at the first frame.
        rate: frames per second.
        scale: of the body.
        before: how fast the points moved over the floor until the first frame, m/s; None: as fast
            as they then go on.
    """
    dt = 1.0 / jnp.asarray(rate, points.dtype)
    size = jnp.asarray(scale, points.dtype)
    flat = points[..., ::2]
    speed = (flat[1:] - flat[:-1]) / dt
    earlier = jnp.concatenate([speed[:1] if before is None else before[None], speed[:-1]])
    # A foot is lifted at once: as fast as it would go down.
    down = jnp.max((points[:-1, ..., 1] - points[1:, ..., 1]) / dt, axis=-1)
    sunk = jnp.maximum(-jnp.min(points[1:, ..., 1], axis=-1), 0.0)
    rows = (speed, earlier, down, sunk, points[1:, :, 1], hips[1:], reach[1:], stands[1:])

    def step(state: FeetState, row: tuple[Array, ...]) -> tuple[FeetState, FeetState]:
        new = _step(state, row, dt, size)
        return new, new

    begin = jax.tree.map(lambda x: jnp.asarray(x, points.dtype), begin)
    _, later = jax.lax.scan(step, begin, rows)
    return jax.tree.map(lambda a, b: jnp.concatenate([a[None], b]), begin, later)


def _step(state: FeetState, row: tuple[Array, ...], dt: Array, size: Array) -> FeetState:
    speed, before, down, sunk, ankle, hip, reach, stands = row
    drift = jnp.where(
        stands[..., None],
        _standing(state, speed, before, dt, size),
        _swinging(state, dt),
    )
    offset = _within(state.offset + dt * drift, state.lead[None, None], MOST_M * size)
    drift = (offset - state.offset) / dt
    on = stands.astype(offset.dtype)
    # The root: after the mean of the standing points, or of all where none stands.
    weight = on + 1e-3
    share = weight / jnp.sum(weight)
    goal = jnp.sum(share[..., None] * offset, axis=(0, 1))
    goal = _within(goal, jnp.zeros_like(goal), MOST_LEAD_M * size)
    omega = 1.0 / LEAD_S
    leading = _damped(state.lead - goal, state.leading, omega, dt)[1]
    lead = state.lead + dt * leading
    # Up from the floor, and down where a leg is too short.
    least = RISE_M_S * size * dt
    lift = _after(state.lift, sunk, jnp.maximum(down * dt, least), dt)
    ankle = ankle + jnp.stack([offset[:, 1, 0], lift, offset[:, 1, 1]], axis=-1)
    place = hip + jnp.stack([lead[0], jnp.zeros_like(lead[0]), lead[1]])[None]
    gap = place - ankle
    flat = jnp.sum(gap[:, ::2] ** 2, axis=-1)
    short = gap[:, 1] - jnp.sqrt(jnp.maximum(reach**2 - flat, 1e-8))
    needed = jnp.max(jnp.where(jnp.any(stands, axis=-1), jnp.maximum(short, 0.0), 0.0))
    drop = _after(state.drop, needed, least, dt)
    held = jnp.where(stands[:, 0], 1.0, jnp.where(stands[:, 1], 0.0, state.anchor))
    anchor = state.anchor + (held.astype(offset.dtype) - state.anchor) * (
        1 - jnp.exp(-dt / ANCHOR_S)
    )
    return FeetState(
        offset=offset,
        drift=drift,
        lead=lead,
        leading=leading,
        lift=lift,
        drop=drop,
        anchor=anchor,
    )


def _standing(state: FeetState, speed: Array, before: Array, dt: Array, size: Array) -> Array:
    """The drift of points that stand: they come to rest in the world, and slip if far off."""
    rest = (before + state.drift) * jnp.exp(-dt / STOP_S)
    off = state.offset - state.lead[None, None]
    far = jnp.sqrt(jnp.maximum(jnp.sum(off * off, axis=-1, keepdims=True), 1e-12))
    excess = jnp.maximum(far - EASY_M * size, 0.0) / ((MOST_M - EASY_M) * size)
    slip = SLIP_PER_S * excess**2 * jnp.minimum(excess, 1.0)
    return rest - speed - slip * off


def _swinging(state: FeetState, dt: Array) -> Array:
    """The drift of points that are lifted: what they are off fades."""
    off = state.offset - KEPT * state.lead[None, None]
    return _damped(off, state.drift, 1.0 / SWING_S, dt)[1]


def _damped(off: Array, speed: Array, omega: float, dt: Array) -> tuple[Array, Array]:
    """A critically damped spring after ``dt``, exactly: its mean speed is the second."""
    decay = jnp.exp(-omega * dt)
    slope = speed + omega * off
    new = (off + slope * dt) * decay
    return new, (new - off) / dt


def _within(offset: Array, middle: Array, most: Array) -> Array:
    """Offsets at most so far from the middle."""
    off = offset - middle
    far = jnp.sqrt(jnp.maximum(jnp.sum(off * off, axis=-1, keepdims=True), 1e-12))
    return middle + off * jnp.minimum(1.0, most / far)


def _after(value: Array, needed: Array, rise: Array, dt: Array) -> Array:
    """What is needed, reached at most so fast; what is needed no more fades."""
    faded = value * jnp.exp(-dt / FALL_S)
    return jnp.maximum(jnp.minimum(needed, value + rise), faded)
