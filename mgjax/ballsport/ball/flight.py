"""Free flight, the contact that ends it, and the bounce: q(t) = S(t, u) of eqs 3–6, arc by arc.

An arc is the flight between two contacts. Everything is for one ball, in float32, and
differentiable; ``vmap`` makes it many.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Float

from mgjax.ballsport.ball.physics import BallPhysics, Net, Number
from mgjax.core.arrays import Array
from mgjax.core.ballistics import drag_integrals
from mgjax.core.xla.pytree import register

register("drag_law")(BallPhysics)
register()(Net)

_RK4_STEPS = 48
"""Steps of the integrator in one flight with quadratic drag, whatever its duration."""

_NEWTON_STEPS = 6
"""From the drag-free time of contact; 5 reach float32 up to drag · t = 1.5."""


def traced(physics: BallPhysics) -> BallPhysics:
    """The physics with its numbers as float32 arrays."""
    return jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), physics)


def free_flight(
    velocity: Float[Array, "3"], t: Float[Array, ""], physics: BallPhysics
) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
    """Displacement and velocity after ``t`` seconds without ground (eqs 3–4)."""
    down = jnp.stack([jnp.zeros_like(t), physics.gravity * jnp.ones_like(t), jnp.zeros_like(t)])
    if physics.drag_law == "linear":
        e0, e1, e2 = drag_integrals(t, physics.drag)
        return velocity * e1 - down * e2, velocity * e0 - down * e1
    return _integrate(velocity, t, down, physics.drag)


def _integrate(
    velocity: Array, t: Array, down: Array, drag: Array
) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
    """Quadratic drag: Runge–Kutta of fourth order in a fixed number of steps.

    The steps are shorter at the beginning, where the ball is fast and the drag strong.
    """

    def slope(v: Array) -> Array:
        square = jnp.sum(v * v)
        speed = jnp.where(square > 0, jnp.sqrt(jnp.where(square > 0, square, 1.0)), 0.0)
        return -down - drag * speed * v

    def step(state: tuple[Array, Array], h: Array) -> tuple[tuple[Array, Array], None]:
        x, v = state
        k1 = slope(v)
        k2 = slope(v + 0.5 * h * k1)
        k3 = slope(v + 0.5 * h * k2)
        k4 = slope(v + h * k3)
        x = x + h * (v + h / 6 * (k1 + k2 + k3))
        return (x, v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)), None

    ends = jnp.linspace(0.0, 1.0, _RK4_STEPS + 1) ** 1.5
    state, _ = lax.scan(step, (jnp.zeros_like(velocity), velocity), t * jnp.diff(ends))
    return state


def contact_time(
    height: Float[Array, ""], velocity: Float[Array, "3"], physics: BallPhysics
) -> Float[Array, ""]:
    """Seconds until a ball ``height`` above its rest height touches the ground.

    Newton's iteration from the drag-free time. That lies beyond the highest point, where the
    height is concave in time (convex, where the ball falls faster than its terminal speed): the
    iteration is monotone from the second step on and needs no safeguard. The derivative is that of
    the implicit function theorem; second derivatives are not those of the flight.

    Degenerate: a ball on the ground that does not rise touches at 0.
    """
    start, v = lax.stop_gradient((height, velocity))
    fixed = lax.stop_gradient(physics)
    root = jnp.sqrt(v[1] ** 2 + 2 * fixed.gravity * start)
    falls = v[1] <= 0
    below = jnp.where(falls, jnp.maximum(root - v[1], 1e-30), 1.0)
    t = jnp.where(falls, 2 * start / below, (v[1] + root) / fixed.gravity)
    # Straight code where a flight is a formula, a loop where it is a loop itself.
    unroll = _NEWTON_STEPS if physics.drag_law == "linear" else 1
    t = lax.fori_loop(
        0, _NEWTON_STEPS, lambda _, t: _newton_step(t, start, v, fixed), t, unroll=unroll
    )
    return _newton_step(lax.stop_gradient(t), height, velocity, physics)


def _newton_step(t: Array, height: Array, velocity: Array, physics: BallPhysics) -> Array:
    moved, v = free_flight(velocity, t, physics)
    rate = lax.stop_gradient(v[1])
    return t - (height + moved[1]) / jnp.where(rate < 0, rate, -1.0)


def bounce(velocity: Float[Array, "3"], restitution: Number) -> Float[Array, "3"]:
    """The velocity after a contact (eq. 5): only its vertical part changes."""
    up = jnp.where(velocity[1] < 0, -restitution * velocity[1], 0.0)
    return jnp.stack([velocity[0], up, velocity[2]])


def next_arc(
    position: Float[Array, "3"], velocity: Float[Array, "3"], physics: BallPhysics
) -> tuple[Float[Array, ""], Float[Array, "3"], Float[Array, "3"]]:
    """Flies to the next contact: its time, and position and velocity just after it.

    Args:
        position: y counts from the rest height.
        velocity: m/s.
        physics: with float32 numbers.
    """
    t = contact_time(position[1], velocity, physics)
    moved, v = free_flight(velocity, t, physics)
    place = jnp.stack([position[0] + moved[0], jnp.zeros_like(t), position[2] + moved[2]])
    return t, place, bounce(v, physics.restitution)


def lifted(position: Float[Array, "3"], physics: BallPhysics) -> Float[Array, "3"]:
    """The position with y counted from the rest height; a ball in the ground is lifted onto it."""
    height = position[1] - physics.radius
    return jnp.asarray(position).at[1].set(jnp.where(height >= 0, height, 0.0))
