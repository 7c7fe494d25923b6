"""The ball in float64: arcs in closed form or by an adaptive integrator, contacts by bracketing."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Arc = tuple[float, np.ndarray, np.ndarray]


def free_flight(x: np.ndarray, v: np.ndarray, t: float, physics) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity after t seconds of linear drag, or none, without ground."""
    down, c = np.array([0.0, physics.gravity, 0.0]), physics.drag
    if c * t < 1e-6:
        return x + v * t - down * t * t / 2, v - down * t - c * v * t
    gain = -math.expm1(-c * t) / c
    return x + (v + down / c) * gain - down * t / c, (v + down / c) * math.exp(-c * t) - down / c


def _slope(state: np.ndarray, physics, gravity: float) -> np.ndarray:
    v = state[3:]
    factor = np.linalg.norm(v) if physics.drag_law == "quadratic" else 1.0
    return np.concatenate([v, -physics.drag * factor * v - np.array([0.0, gravity, 0.0])])


def integrated(x, v, t: float, physics, *, until_ground: bool = False, gravity=None) -> tuple:
    """Adaptive integration up to t, or to the contact: (time, position, velocity)."""
    pull = physics.gravity if gravity is None else gravity

    def height(_: float, state: np.ndarray) -> float:
        return state[1] - physics.radius

    height.terminal, height.direction = True, -1
    # Steps a fraction of the arc, so that a short one is not stepped over.
    size = max(abs(v[1]), math.sqrt(2 * physics.gravity * max(x[1] - physics.radius, 0.0)))
    found = solve_ivp(
        lambda _, state: _slope(state, physics, pull),
        (0.0, t),
        np.concatenate([x, v]),
        method="DOP853",
        rtol=1e-11,
        atol=1e-12,
        max_step=max(size / physics.gravity / 8, 1e-9) if until_ground else math.inf,
        events=height if until_ground else None,
    )
    if until_ground:
        state = found.y_events[0][0]
        return float(found.t_events[0][0]), state[:3], state[3:]
    return t, found.y[:3, -1], found.y[3:, -1]


def contact(x: np.ndarray, v: np.ndarray, physics) -> tuple[float, np.ndarray, np.ndarray]:
    """Time of the contact that ends an arc, position and velocity there."""
    if x[1] <= physics.radius and v[1] <= 0:
        return 0.0, x, v
    if physics.drag_law == "quadratic":
        return integrated(x, v, 1e3, physics, until_ground=True)
    c, g = physics.drag, physics.gravity
    top = 0.0 if v[1] <= 0 else (math.log1p(c * v[1] / g) / c if c > 0 else v[1] / g)
    end = top + 1e-3
    while free_flight(x, v, end, physics)[0][1] > physics.radius:
        end = top + 2 * (end - top)
    t = brentq(lambda t: free_flight(x, v, t, physics)[0][1] - physics.radius, top, end, xtol=1e-15)
    return (t, *free_flight(x, v, t, physics))


def arcs(position, velocity, physics, *, end: float, most: int = 10_000) -> list[Arc]:
    """Time, position and velocity at the beginning of each arc that begins before ``end``.

    Where the bounces pile up, the last arc has no vertical speed: there the ball rolls.
    """
    t, x, v = 0.0, np.array(position, np.float64), np.array(velocity, np.float64)
    x[1] = max(x[1], physics.radius)
    found = [(t, x, v)]
    while len(found) <= most:
        lasts, x, v = contact(x, v, physics)
        t += lasts
        if t >= end:
            break
        x = np.array([x[0], physics.radius, x[2]])
        v = np.array([v[0], -physics.restitution * v[1], v[2]])
        found.append((t, x, v * (1, v[1] > 1e-7, 1)))
        if v[1] <= 1e-7:
            break
    return found


def on_arc(arc: Arc, time: float, physics) -> np.ndarray:
    """Position at ``time`` on the arc, or rolling."""
    begin, x, v = arc
    rolls = x[1] <= physics.radius and v[1] == 0
    if physics.drag_law == "linear":
        place, _ = free_flight(x, v, time - begin, physics)
        return np.array([place[0], x[1], place[2]]) if rolls else place
    if time <= begin:
        return x
    return integrated(x, v, time - begin, physics, gravity=0.0 if rolls else None)[1]


def fly(position, velocity, times, physics) -> np.ndarray:
    """[T,3] positions, with as many bounces as there are."""
    found = arcs(position, velocity, physics, end=max(times))
    starts = np.array([t for t, _, _ in found])
    last = np.searchsorted(starts, times, side="right") - 1
    return np.array([on_arc(found[k], t, physics) for k, t in zip(last, times, strict=True)])


def arrival(start, velocity, time: float, physics) -> tuple[np.ndarray, int]:
    """Where the ball is at ``time``, and how many bounces it has had before."""
    found = arcs(start, velocity, physics, end=time)
    return on_arc(found[-1], time, physics), len(found) - 1
