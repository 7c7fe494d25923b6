"""From a click to a ball: it flies along the ray, to where the body will be."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import BEYOND_M
from mgjax.stage.apps.throw.settings import BallSettings

Vector = Float[np.ndarray, "3"]

BESIDE_M = 0.55
"""A ball that comes from behind the eye passes it to the right and above by so much."""
KNOT_RATE = 120.0
"""Knots a second of a flight that is bent."""
_SHORTEST_BEYOND_S, _LONGEST_BEYOND_S = 1e-4, 2.0
_REACH_M = (0.05, 2.3)
"""Heights at which a ray can pass a body."""


def thrown_along(
    eye: Vector, through: Vector, goal: Vector, now: float, settings: BallSettings
) -> Attack:
    """A ball that arrives at ``goal`` in the direction in which a ray passes it.

    It starts as far away as it flies in the notice that is given. Where that is behind the eye, it
    comes over the right shoulder.

    Args:
        eye, through: of the ray, m.
        goal: where the ball is to be, m.
        now: s.
        settings: of the ball.

    Returns:
        In the world, its times on the clock of ``now``.
    """
    goal = np.array([goal[0], max(goal[1], settings.radius), goal[2]])
    way = through - eye
    way = way / np.linalg.norm(way)
    length = settings.speed * settings.notice
    start = goal - way * length
    to_eye = float(np.linalg.norm(goal - eye))
    if length > to_eye:
        right = np.cross(way, [0.0, 1.0, 0.0])
        size = float(np.linalg.norm(right))
        right = right / size if size > 1e-6 else np.array([1.0, 0.0, 0.0])
        # So far beside the line that it passes the eye at the wanted distance.
        beside = BESIDE_M * length / max(to_eye, 0.5)
        start = start + beside * right + np.array([0.0, 0.4 * beside, 0.0])
    start[1] = max(start[1], settings.radius)
    return _attack(start, goal, now, settings)


def _attack(start: Vector, goal: Vector, now: float, settings: BallSettings) -> Attack:
    """A ball that is at ``start`` now and at ``goal`` when the notice is over, and flies on.

    It is followed for 3 m, or until it meets the floor; what it does then does not matter.
    """
    flight, pull = settings.notice, np.array([0.0, -settings.gravity, 0.0])
    velocity = (goal - start) / flight - pull * flight / 2
    beyond = BEYOND_M / max(float(np.linalg.norm(velocity + pull * flight)), 0.1)
    until = flight + min(beyond, _LONGEST_BEYOND_S)
    a, b, c = -settings.gravity / 2, velocity[1], start[1] - settings.radius
    roots = np.roots([a, b, c]) if a else np.roots([b, c])
    landings = [float(t.real) for t in roots if abs(t.imag) < 1e-9 and t.real > flight - 1e-6]
    until = max(min([until, *landings]), flight + _SHORTEST_BEYOND_S)
    knots = np.linspace(0.0, flight, round(flight * KNOT_RATE) + 1 if settings.gravity else 2)
    after = np.linspace(flight, until, round((until - flight) * KNOT_RATE) + 2)[1:]
    since = np.concatenate([knots, after if settings.gravity else after[-1:]])
    centres = start + velocity * since[:, None] + pull * since[:, None] ** 2 / 2
    return Attack(
        times=since + now,
        centres=centres[:, None],
        radii=np.array([settings.radius]),
        acceleration=settings.gravity,
    )


def thrown_at_random(
    rng: np.random.Generator, centre: Vector, now: float, settings: BallSettings
) -> Attack:
    """A ball from any side, between knee and head."""
    side, height = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.6)
    goal = np.array([centre[0], max(height, settings.radius), centre[2]])
    way = settings.speed * settings.notice * np.array([np.sin(side), 0.0, np.cos(side)])
    return _attack(goal + way, goal, now, settings)


def passing_point(eye: Vector, through: Vector, axis: Vector) -> Vector:
    """Where a ray passes a body's vertical axis, at a height at which there is a body."""
    way = through - eye
    flat = np.array([way[0], 0.0, way[2]])
    share = float(flat @ (axis - eye)) / max(float(flat @ flat), 1e-9)
    place = eye + max(share, 0.0) * way
    return np.array([place[0], np.clip(place[1], *_REACH_M), place[2]])
