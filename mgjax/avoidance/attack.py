"""Attacks: spheres whose places over time are known, and what part of them matters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import AttackError

GRAVITY_M_S2 = 9.8
BALL_RADIUS_M = 0.12
BEYOND_M = 3.0
"""How far a ball is followed past the place it was aimed at."""
MAX_SECONDS = 60.0
"""An attack that lasts longer is no throw at a character, and its motion would be endless."""
_KNOT_RATE = 240.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Attack:
    """Spheres that move linearly between knots, there from the first knot to the last.

    Attributes:
        times: seconds from now, ascending. [K]
        centres: in the planar frame of the character's start pose, m. [K, I, 3]
        radii: m. [I]
        acceleration: largest acceleration of a centre, m/s²: between knots dt apart a centre is off
            the straight line by at most acceleration · dt²/8.
    """

    times: Float[np.ndarray, " K"]
    centres: Float[np.ndarray, "K I 3"]
    radii: Float[np.ndarray, " I"]
    acceleration: float = 0.0

    @property
    def start(self) -> float:
        return float(self.times[0])

    @property
    def end(self) -> float:
        return float(self.times[-1])

    def at(self, times: Float[np.ndarray, " T"]) -> Float[np.ndarray, "T I 3"]:
        """Centres at any time; before the first and after the last knot those are held."""
        flat = self.centres.reshape(len(self.times), -1)
        out = np.stack([np.interp(times, self.times, column) for column in flat.T], axis=1)
        return out.reshape(len(times), *self.centres.shape[1:])

    def largest_speed(self) -> float:
        """m/s, over all spheres and knots."""
        steps = np.linalg.norm(np.diff(self.centres, axis=0), axis=-1)
        if not steps.size:
            return 0.0
        return float((steps / np.diff(self.times)[:, None]).max())


def validate_attack(attack: Attack) -> None:
    """Raises :class:`AttackError` unless the attack is finite, ordered and has spheres."""
    if attack.centres.shape != (len(attack.times), len(attack.radii), 3) or not attack.centres.size:
        raise AttackError(
            f"got centres of shape {attack.centres.shape}, expected"
            f" {(len(attack.times), len(attack.radii), 3)}, not empty"
        )
    for name in ("times", "centres", "radii"):
        if not np.isfinite(getattr(attack, name)).all():
            raise AttackError(f"got attack {name} that are not finite, expected numbers")
    if not 0 <= attack.acceleration < np.inf:
        raise AttackError(
            f"got an acceleration of {attack.acceleration:g} m/s², expected 0 or more"
        )
    if (np.diff(attack.times) <= 0).any():
        raise AttackError("got attack times that do not ascend, expected ascending times")
    if (attack.radii <= 0).any():
        raise AttackError(f"got a radius of {attack.radii.min():g} m, expected more than 0")
    if attack.end > MAX_SECONDS:
        raise AttackError(
            f"got an attack that lasts until {attack.end:g} s from now, expected at most"
            f" {MAX_SECONDS:g} s"
        )


def ball_attack(
    start: Float[np.ndarray, "3"],
    at: Float[np.ndarray, "3"],
    *,
    speed: float,
    arrives: float,
    gravity: bool = False,
    radius: float = BALL_RADIUS_M,
) -> Attack:
    """A ball thrown from ``start`` that is at ``at`` in ``arrives`` seconds from now.

    It is launched at ``arrives`` less the time of flight; if that lies in the past it is already
    under way, and its knots begin now. It is followed past ``at`` for 3 m (at
    most half a minute), or until it meets the floor.

    Args:
        start, at: m, in the planar frame of the character's start pose.
        speed: at launch, m/s.
        arrives: s, more than 0; the flight has to be over within a minute.
        gravity: a ballistic throw, the flatter of the two that meet ``at``; else a straight line.
        radius: m.

    Raises:
        AttackError: a number out of range, or a place that the throw cannot reach.
    """
    a, b = np.asarray(start, dtype=np.float64), np.asarray(at, dtype=np.float64)
    numbers = {"speed": speed, "arrival": arrives, "radius": radius}
    for name, value in numbers.items():
        if not (np.isfinite(value) and 0 < value <= 1000):
            raise AttackError(f"got {name} {value:g}, expected more than 0 and at most 1000")
    for name, place in (("start", a), ("target", b)):
        if place.shape != (3,) or not np.isfinite(place).all() or np.abs(place).max() > 1000:
            raise AttackError(f"got {name} {place.tolist()}, expected three numbers within 1000 m")
        if place[1] < 0:
            raise AttackError(f"got a {name} {-place[1]:g} m under the floor, expected y ≥ 0")
    if np.linalg.norm(b - a) < 1e-6:
        raise AttackError("got a throw to the place it starts from, expected another")
    velocity, flight = _launch(a, b, speed, gravity)
    pull = np.array([0.0, -GRAVITY_M_S2 if gravity else 0.0, 0.0])
    until = flight + BEYOND_M / max(float(np.linalg.norm(velocity + pull * flight)), 0.1)
    floor = _time_at_floor(a[1], velocity[1], pull[1])
    until = max(min(until, floor), flight)
    launch = arrives - flight
    if launch + until > MAX_SECONDS:
        raise AttackError(
            f"got a ball that is under way until {launch + until:.4g} s from now, expected at most"
            f" {MAX_SECONDS:g} s"
        )
    known = max(0.0, -launch)  # what was before now does not matter
    count = max(2, int(np.ceil((until - known) * _KNOT_RATE)) + 1)
    since = np.linspace(known, until, count)
    centres = a + velocity * since[:, None] + 0.5 * pull * since[:, None] ** 2
    return Attack(
        times=since + launch,
        centres=centres[:, None, :],
        radii=np.array([radius]),
        acceleration=GRAVITY_M_S2 if gravity else 0.0,
    )


def _launch(a: np.ndarray, b: np.ndarray, speed: float, gravity: bool) -> tuple[np.ndarray, float]:
    """Launch velocity and time of flight from a to b."""
    way = b - a
    if not gravity:
        flight = float(np.linalg.norm(way)) / speed
        return way / flight, flight
    # |way − g t²/2|² = (speed t)²: quadratic in t²; the smaller root is the flatter throw.
    g = np.array([0.0, -GRAVITY_M_S2, 0.0])
    qa, qb, qc = g @ g / 4, -(way @ g) - speed**2, way @ way
    root = qb * qb - 4 * qa * qc
    if qb >= 0 or root < 0:
        least = np.sqrt(max(np.sqrt(4 * qa * qc) - way @ g, 0.0))
        least = np.ceil(1000 * least + 1) / 1000  # rounded up: this speed does reach it
        raise AttackError(
            f"got a speed of {speed:g} m/s, which cannot reach the target under gravity, expected"
            f" at least {least:.3f} m/s"
        )
    flight = float(np.sqrt(2 * qc / (-qb + np.sqrt(root))))
    return way / flight - 0.5 * g * flight, flight


def _time_at_floor(height: float, rise: float, pull: float) -> float:
    if pull == 0:
        return -height / rise if rise < 0 else np.inf
    return float((-rise - np.sqrt(rise * rise - 2 * pull * height)) / pull)


@dataclass(frozen=True, kw_only=True)
class Crop:
    """The part of an attack that is close to the character, seconds from now."""

    start: float
    end: float

    @property
    def middle(self) -> float:
        """The time of the attack, t_attack."""
        return 0.5 * (self.start + self.end)


def crop_attack(attack: Attack, *, radius: float, height: float, start: float = 0.0) -> Crop | None:
    """When a centre is within ``radius`` of the root's vertical and below ``height``, or None.

    Args:
        attack: in the planar frame of the body at the beginning of the path, whose root is above
            the origin.
        radius, height: of the cylinder, m.
        start: nothing before this counts, s from now.
    """
    count = int(np.ceil(max(attack.end - max(attack.start, start), 0.0) * 1000)) + 2
    times = np.linspace(max(attack.start, start), attack.end, count)
    if times[-1] < times[0]:
        return None
    centres = attack.at(times)
    near = (np.hypot(centres[..., 0], centres[..., 2]) <= radius) & (centres[..., 1] <= height)
    near &= centres[..., 1] >= 0
    inside = np.flatnonzero(near.any(axis=1))
    if not inside.size:
        return None
    return Crop(start=float(times[inside[0]]), end=float(times[inside[-1]]))
