"""From a click to a ball: it flies along the ray, to where the body will be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack, ball_from
from mgjax.stage.apps.throw.settings import BallSettings

Vector = Float[np.ndarray, "3"]

BESIDE_M = 0.55
"""A ball that comes from behind the eye passes it to the right and above by so much."""
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

    Raises:
        AttackError: gravity lets it not arrive there.
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
    attack = ball_attack(
        start,
        goal,
        speed=settings.speed,
        arrives=settings.notice,
        gravity=settings.gravity,
        radius=settings.radius,
    )
    return replace(attack, times=attack.times + now)


def thrown_at_random(
    rng: np.random.Generator, centre: Vector, now: float, settings: BallSettings
) -> Attack:
    """A ball from any side, between knee and head."""
    ball = ball_from(
        float(rng.uniform(0, 2 * np.pi)),
        float(rng.uniform(0.5, 1.6)),
        distance=settings.speed * settings.notice,
        at=(float(centre[0]), float(centre[2])),
        speed=settings.speed,
        arrives=settings.notice,
    )
    start, goal = ball.centres[0, 0], np.array([centre[0], ball.centres[0, 0, 1], centre[2]])
    return _attack(start, goal, now, settings)


def passing_point(eye: Vector, through: Vector, axis: Vector) -> Vector:
    """Where a ray passes a body's vertical axis, at a height at which there is a body."""
    way = through - eye
    flat = np.array([way[0], 0.0, way[2]])
    share = float(flat @ (axis - eye)) / max(float(flat @ flat), 1e-9)
    place = eye + max(share, 0.0) * way
    return np.array([place[0], np.clip(place[1], *_REACH_M), place[2]])
