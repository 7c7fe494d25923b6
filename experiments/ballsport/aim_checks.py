"""Random passes, and an integrator of the ball that knows nothing of the one that is measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from mgjax.ballsport.aiming.solve import Aim
from mgjax.ballsport.ball.physics import BallPhysics


@dataclass(frozen=True, kw_only=True)
class Passes:
    """Starts, targets and guessed velocities, each [N,3]."""

    starts: np.ndarray
    targets: np.ndarray
    guesses: np.ndarray


def random_passes(
    count: int, seed: int, *, distance: float | None = None, height: float | None = None
) -> Passes:
    """Kicks from 0.11 to 1 m high, guessed at 2–14 m/s within about 30° of the target.

    Distances are 0.2 to 20 m, evenly in their logarithm, and target heights the ground to 2.5 m,
    unless they are given.
    """
    rng = np.random.default_rng(seed)
    distances = np.exp(rng.uniform(math.log(0.2), math.log(20.0), count))
    distances = distances if distance is None else np.full(count, distance)
    angle = rng.uniform(0, 2 * np.pi, count)
    starts = rng.uniform(-10, 10, (count, 3))
    starts[:, 1] = rng.choice([0.11, 0.15, 0.3, 1.0], count)
    targets = starts + np.stack(
        [distances * np.sin(angle), 0 * distances, distances * np.cos(angle)], axis=1
    )
    targets[:, 1] = rng.choice([0.11, 0.3, 0.8, 1.7, 2.5], count) if height is None else height
    angle, speed = angle + rng.normal(0, 0.5, count), rng.uniform(2, 14, count)
    up = rng.uniform(-2, 6, count)
    guesses = np.stack([speed * np.sin(angle), up, speed * np.cos(angle)], axis=1)
    starts, targets, guesses = (a.astype(np.float32) for a in (starts, targets, guesses))
    return Passes(starts=starts, targets=targets, guesses=guesses)


def arrival(
    start: np.ndarray, velocity: np.ndarray, time: float, physics: BallPhysics
) -> tuple[np.ndarray, int]:
    """Place at ``time`` and bounces before it: linear drag in float64, contacts bracketed."""
    c, g, r = float(physics.drag), float(physics.gravity), float(physics.radius)
    x, v = start.astype(np.float64), velocity.astype(np.float64)
    x[1], t, bounces = max(x[1], r), 0.0, 0

    def at(s: float) -> tuple[np.ndarray, np.ndarray]:
        gain = -math.expm1(-c * s) / c
        fall = np.array([0.0, g / c, 0.0])
        return x + (v + fall) * gain - fall * s, (v + fall) * math.exp(-c * s) - fall

    while bounces < 100:
        top = max(0.0, math.log1p(c * v[1] / g) / c) if v[1] > 0 else 0.0
        rest = time - t
        if rest <= top or at(rest)[0][1] > r:
            return at(rest)[0], bounces
        s: Any = brentq(lambda s: at(s)[0][1] - r, top, rest, xtol=1e-15)
        x, v = at(s)
        x[1], v[1] = r, -float(physics.restitution) * v[1]
        t, bounces = t + s, bounces + 1
    return x, bounces


def checked(aimed: Aim, passes: Passes, physics: BallPhysics) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the target, m, and bounces of each pass, by :func:`arrival`. [N]"""
    velocities, times = np.asarray(aimed.velocity), np.asarray(aimed.time)
    rows = [
        arrival(start, velocity, float(time), physics)
        for start, velocity, time in zip(passes.starts, velocities, times, strict=True)
    ]
    places = np.array([place for place, _ in rows])
    return np.linalg.norm(places - passes.targets, axis=1), np.array([count for _, count in rows])
