"""Balls: straight, under gravity, and through the air."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import MAX_SECONDS, Attack
from mgjax.avoidance.config import BALL_RADIUS_M
from mgjax.core.ballistics import drag_factors
from mgjax.core.errors import AttackError

GRAVITY_M_S2 = 9.8
MAX_GRAVITY_M_S2 = 100.0
FAR_M = 100.0
"""No place of a throw is farther from the character, in any direction."""
MOST = {"speed": 300.0, "arrival": 1000.0, "radius": 3.0}
"""Faster than any serve, larger than any ball: beyond are other units."""


BEYOND_M = 3.0
"""How far a ball is followed past the place it was aimed at."""


MAX_DRAG = 100.0
"""1/s; a ball under more of it stops within its own width."""


_KNOT_RATE = 240.0


def ball_attack(
    start: Float[np.ndarray, "3"],
    at: Float[np.ndarray, "3"],
    *,
    speed: float,
    arrives: float,
    gravity: bool | float = False,
    radius: float = BALL_RADIUS_M,
    drag: float = 0.0,
) -> Attack:
    """A ball thrown from ``start`` that is at ``at`` in ``arrives`` seconds from now.

    It is launched at ``arrives`` less the time of flight; if that lies in the past it is already
    under way, and its knots begin now. It is followed past ``at`` for 3 m (at
    most half a minute), or until it meets the floor. ``arrives`` is a knot.

    Args:
        start, at: m, in the planar frame of the character's start pose.
        speed: at launch, m/s.
        arrives: s, more than 0; the flight has to be over within a minute.
        gravity: a ballistic throw, the flatter of the two that meet ``at``, under 9.8 m/s² or as
            much as is said; else a straight line.
        radius: m.
        drag: deceleration by the air in proportion to the velocity, a = −drag · v, in 1/s.

    Raises:
        AttackError: a number out of range, or a place that the throw cannot reach.
    """
    a, b = np.asarray(start, dtype=np.float64), np.asarray(at, dtype=np.float64)
    numbers = {"speed": (speed, "m/s"), "arrival": (arrives, "s"), "radius": (radius, "m")}
    for name, (value, unit) in numbers.items():
        if not (np.isfinite(value) and 0 < value <= MOST[name]):
            raise AttackError(
                got=f"{name} {value:g}", expected=f"more than 0 and at most {MOST[name]:g} {unit}"
            )
    if not 0 <= drag <= MAX_DRAG:
        raise AttackError(got=f"drag {drag:g} per second", expected=f"0 … {MAX_DRAG:g}")
    for name, place in (("start", a), ("target", b)):
        if place.shape != (3,) or not np.isfinite(place).all() or np.abs(place).max() > FAR_M:
            raise AttackError(
                got=f"{name} {place.tolist()}", expected=f"three numbers within {FAR_M:g} m"
            )
        if place[1] < 0:
            raise AttackError(got=f"a {name} {-place[1]:g} m under the floor", expected="y ≥ 0")
    if np.linalg.norm(b - a) < 1e-6:
        raise AttackError(got="a throw to the place it starts from", expected="another")
    down = GRAVITY_M_S2 if gravity is True else float(gravity)
    if not 0 <= down <= MAX_GRAVITY_M_S2:
        raise AttackError(got=f"gravity {down:g} m/s²", expected=f"0 … {MAX_GRAVITY_M_S2:g}")
    pull = np.array([0.0, -down, 0.0])
    velocity, flight = _launch(b - a, speed, pull, drag)
    until = flight + _seconds_beyond(velocity, flight, pull, drag)
    until = _until_floor(a[1], velocity[1], pull[1], drag, flight, until)
    launch = arrives - flight
    if launch + until > MAX_SECONDS:
        raise AttackError(
            got=f"a ball that is under way until {launch + until:.4g} s from now",
            expected=f"at most {MAX_SECONDS:g} s",
        )
    known = max(0.0, -launch)  # what was before now does not matter
    rate = _KNOT_RATE if down or drag else 0.0  # a straight line needs none in between
    since = _evenly(known, flight, rate)
    if until - flight > 1e-6:
        since = np.concatenate([since[:-1], _evenly(flight, until, rate)])
    coast, fall = drag_factors(since, drag)
    centres = a + velocity * coast[:, None] + pull * fall[:, None]
    return Attack(
        times=since + launch,
        centres=centres[:, None, :],
        radii=np.array([radius]),
        acceleration=float(np.linalg.norm(pull - drag * velocity) * np.exp(-drag * known)),
    )


def ball_from(
    angle: float,
    height: float,
    *,
    distance: float = 5.0,
    at: tuple[float, float] = (0.0, 0.0),
    speed: float = 10.0,
    arrives: float = 1.2,
    gravity: bool = False,
) -> Attack:
    """A ball thrown from a side, at the height at which it passes a vertical.

    Args:
        angle: where it comes from, rad from ahead (+Z) towards the left (+X).
        height: of the throw and of the place it is aimed at, m.
        distance: from where it is thrown to the vertical, m.
        at: x and z of the vertical, m; default: the body's axis.
        speed, arrives, gravity: see :func:`ball_attack`.

    Raises:
        AttackError: a number out of range.
    """
    target = np.array([at[0], height, at[1]])
    start = target + distance * np.array([np.sin(angle), 0.0, np.cos(angle)])
    return ball_attack(start, target, speed=speed, arrives=arrives, gravity=gravity)


def _evenly(start: float, stop: float, rate: float) -> np.ndarray:
    return np.linspace(start, stop, max(2, int(np.ceil((stop - start) * rate)) + 1))


def _factors_at(t: float, drag: float) -> tuple[float, float]:
    coast, fall = drag_factors(np.array([t]), drag)
    return float(coast[0]), float(fall[0])


def _launch(
    way: np.ndarray, speed: float, pull: np.ndarray, drag: float
) -> tuple[np.ndarray, float]:
    """Launch velocity and time of flight to cover ``way``: the quicker, flatter one of two."""
    if drag > 0:
        flight = _dragged_flight(way, speed, pull, drag)
        coast, fall = _factors_at(flight, drag)
        return (way - pull * fall) / coast, flight
    if not pull.any():
        flight = float(np.linalg.norm(way)) / speed
        return way / flight, flight
    # |way − g t²/2|² = (speed t)²: quadratic in t²; the smaller root is the flatter throw.
    qa, qb, qc = pull @ pull / 4, -(way @ pull) - speed**2, way @ way
    root = qb * qb - 4 * qa * qc
    if qb >= 0 or root < 0:
        least = float(np.sqrt(max(np.sqrt(4 * qa * qc) - way @ pull, 0.0)))
        raise _too_slow(speed, least, "gravity")
    flight = float(np.sqrt(2 * qc / (-qb + np.sqrt(root))))
    return way / flight - 0.5 * pull * flight, flight


def _too_slow(speed: float, least: float, cause: str) -> AttackError:
    least = np.ceil(1000 * least + 1) / 1000  # rounded up: this speed does reach it
    return AttackError(
        f"got a speed of {speed:g} m/s, which cannot reach the target under {cause}, expected"
        f" at least {least:.3f} m/s"
    )


def _dragged_flight(way: np.ndarray, speed: float, pull: np.ndarray, drag: float) -> float:
    """Least time of flight under drag.

    With P and Q the factors of velocity and gravity, it is a root of speed · P − |way − g Q|. As P
    is concave in Q, so is that, which makes two roots at most, on either side of the time T at
    which the launch speed |way − g Q| / P that is needed is least.
    """
    length = float(np.linalg.norm(way))
    if not pull.any():
        if speed <= drag * length:
            raise _too_slow(speed, drag * length, "drag")
        return float(-np.log1p(-drag * length / speed) / drag)

    def excess(t: float) -> float:
        coast, fall = _factors_at(t, drag)
        return float(speed * coast - np.linalg.norm(way - pull * fall))

    def needed(log_t: float) -> float:
        coast, fall = _factors_at(float(np.exp(log_t)), drag)
        return float(np.linalg.norm(way - pull * fall) / coast)

    from scipy.optimize import minimize_scalar  # imported in 0.25 s, which few balls are worth

    log_t = np.log(1e-6)
    while needed(log_t + 0.5) < needed(log_t):
        log_t += 0.5
    found: Any = minimize_scalar(
        needed, bounds=(log_t - 0.5, log_t + 0.5), method="bounded", options={"xatol": 1e-12}
    )
    best = float(np.exp(found.x))
    if excess(best) < 0:
        raise _too_slow(speed, needed(float(found.x)), "gravity and drag")
    # Sooner it cannot be there even if the air did nothing and gravity pulled along.
    g = float(np.linalg.norm(pull))
    soonest = 2 * length / (speed + np.sqrt(speed * speed + 2 * g * length))
    if excess(soonest) >= 0:
        return float(soonest)  # by rounding
    return _root(excess, soonest, best)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function that changes its sign between low and high is 0."""
    from scipy.optimize import root_scalar

    return float(
        root_scalar(function, bracket=(low, high), method="brentq", xtol=1e-15, rtol=1e-15).root
    )


def _seconds_beyond(velocity: np.ndarray, flight: float, pull: np.ndarray, drag: float) -> float:
    """Time in which a ball goes 3 m on, at most half a minute."""
    slowed = np.exp(-drag * flight)
    coast, _ = _factors_at(flight, drag)
    speed = float(np.linalg.norm(velocity * slowed + pull * coast))
    left = 1 - drag * BEYOND_M / max(speed, 1e-9)
    if drag > 0 and left <= np.exp(-drag * BEYOND_M / 0.1):
        return BEYOND_M / 0.1
    seconds = BEYOND_M / max(speed, 0.1) if drag == 0 else -np.log(left) / drag
    return float(min(seconds, BEYOND_M / 0.1))


def _until_floor(
    height: float, rise: float, pull: float, drag: float, flight: float, until: float
) -> float:
    """``until``, or when the ball meets the floor if that is sooner; not before ``flight``."""

    def above(t: float) -> float:
        coast, fall = _factors_at(t, drag)
        return float(height + rise * coast + pull * fall)

    if above(until) >= 0:
        return until
    if drag == 0 and pull == 0:
        return max(-height / rise, flight)
    if drag == 0:
        return max(float((-rise - np.sqrt(rise * rise - 2 * pull * height)) / pull), flight)
    if above(flight) <= 0:
        return flight
    # It rises at most once and then sinks, so it meets the floor once.
    return _root(above, flight, until)
