"""Attacks: spheres whose places over time are known, and what part of them matters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.errors import AttackError

MAX_SECONDS = 60.0
"""An attack that lasts longer is no throw at a character, and its motion would be endless."""
AWAY_M = 2000.0
"""How far above or below the scene a sphere is while it is not there."""
LOW_M = 0.6
"""A sphere that appears or vanishes lower than this is put below the scene, else above it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Attack:
    """Spheres that move linearly between knots, there from the first knot to the last.

    Where ``starts`` and ``stops`` are given, each sphere is there only from its own start to its
    own stop, both included. For the rest of the attack :meth:`at` puts it 2 km above the place
    where it appears or vanishes, or below it where that is lower than 0.6 m. A reader that joins
    the moments it asks for by straight lines then sees it come and go along a vertical, within one
    step: a body beside that place, bent down under it or in the air over it is not swept, and the
    motion of its life is never cut short. Whoever wants to leave that step out asks :meth:`active`.

    Attributes:
        times: seconds from now, ascending. [K]
        centres: in the planar frame of the character's start pose, m. [K, I, 3]
        radii: m. [I]
        acceleration: largest acceleration of a centre, m/s²: between knots dt apart a centre is off
            the straight line by at most acceleration · dt²/8.
        starts, stops: first and last moment of each sphere, each of them a knot; None where all
            are there from the first knot to the last. [I]
    """

    times: Float[np.ndarray, " K"]
    centres: Float[np.ndarray, "K I 3"]
    radii: Float[np.ndarray, " I"]
    acceleration: float = 0.0
    starts: Float[np.ndarray, " I"] | None = None
    stops: Float[np.ndarray, " I"] | None = None

    @property
    def start(self) -> float:
        return float(self.times[0])

    @property
    def end(self) -> float:
        return float(self.times[-1])

    def at(self, times: Float[np.ndarray, " T"]) -> Float[np.ndarray, "T I 3"]:
        """Centres at any time; before the first and after the last knot those are held."""
        flat = self.centres.reshape(len(self.times), -1)
        out = np.empty((len(times), flat.shape[1]))
        for column in range(flat.shape[1]):
            out[:, column] = np.interp(times, self.times, flat[:, column])
        out = out.reshape(len(times), *self.centres.shape[1:])
        if self.starts is None and self.stops is None:
            return out
        held = np.clip(times, self.start, self.end)[:, None]
        for moment, gone in (
            (self.starts, None if self.starts is None else held < self.starts),
            (self.stops, None if self.stops is None else held > self.stops),
        ):
            if moment is None or gone is None:
                continue
            knot = np.searchsorted(self.times, moment)
            away = self.centres[knot, np.arange(len(moment))].copy()
            away[:, 1] += np.where(away[:, 1] < LOW_M, -AWAY_M, AWAY_M)
            out = np.where(gone[..., None], away, out)
        return out

    def held(self, times: Float[np.ndarray, " T"]) -> Float[np.ndarray, "T I 3"]:
        """Centres as :meth:`at` has them, but each sphere held where it appears and vanishes."""
        if self.starts is None and self.stops is None:
            return self.at(times)
        low = np.full(len(self.radii), self.start) if self.starts is None else self.starts
        high = np.full(len(self.radii), self.end) if self.stops is None else self.stops
        out = np.empty((len(times), len(self.radii), 3))
        for k in range(len(self.radii)):
            alive = np.clip(times, low[k], high[k])
            for axis in range(3):
                out[:, k, axis] = np.interp(alive, self.times, self.centres[:, k, axis])
        return out

    def lives(self, times: Float[np.ndarray, " T"]) -> Bool[np.ndarray, "V I"]:
        """Whether each sphere is there at any moment between two times."""
        starts = np.full(len(self.radii), self.start) if self.starts is None else self.starts
        stops = np.full(len(self.radii), self.end) if self.stops is None else self.stops
        return (times[1:, None] >= starts) & (times[:-1, None] <= stops)

    def active(self, times: Float[np.ndarray, " T"]) -> Bool[np.ndarray, "T I"]:
        """Whether each sphere is there; between two moments if it is at both."""
        starts = np.full(len(self.radii), self.start) if self.starts is None else self.starts
        stops = np.full(len(self.radii), self.end) if self.stops is None else self.stops
        return (times[:, None] >= starts) & (times[:, None] <= stops)

    @cached_property
    def largest_speed(self) -> float:
        """m/s, over all spheres and knots at which they are there."""
        if len(self.times) < 2:
            return 0.0
        ways = self.centres[1:] - self.centres[:-1]
        speeds = np.sqrt(np.einsum("kix,kix->ki", ways, ways))
        speeds /= (self.times[1:] - self.times[:-1])[:, None]
        if self.starts is not None or self.stops is not None:
            there = self.active(self.times)
            speeds = np.where(there[1:] & there[:-1], speeds, 0.0)
        return float(speeds.max())


def validate_attack(attack: Attack) -> None:
    """Raises :class:`AttackError` unless the attack is finite, ordered and has spheres."""
    if attack.centres.shape != (len(attack.times), len(attack.radii), 3) or not attack.centres.size:
        raise AttackError(
            got=f"centres of shape {attack.centres.shape}",
            expected=f"{(len(attack.times), len(attack.radii), 3)}, not empty",
        )
    for name in ("times", "centres", "radii"):
        if not _all_finite(getattr(attack, name)):
            raise AttackError(got=f"attack {name} that are not finite", expected="numbers")
    if not 0 <= attack.acceleration < np.inf:
        raise AttackError(
            got=f"an acceleration of {attack.acceleration:g} m/s²", expected="0 or more"
        )
    if not (attack.times[1:] > attack.times[:-1]).all():
        raise AttackError(got="attack times that do not ascend", expected="ascending times")
    for name in ("starts", "stops"):
        moments = getattr(attack, name)
        if moments is None:
            continue
        if moments.shape != attack.radii.shape or not np.isin(moments, attack.times).all():
            raise AttackError(got=f"{name} that are no knots", expected="a knot for each sphere")
    come_and_go = attack.starts is not None or attack.stops is not None
    if come_and_go and not attack.active(attack.times).any(axis=0).all():
        raise AttackError(got="a sphere that stops before it starts", expected="start ≤ stop")
    if min(attack.radii.tolist()) <= 0:
        raise AttackError(got=f"a radius of {attack.radii.min():g} m", expected="more than 0")
    if attack.end > MAX_SECONDS:
        raise AttackError(
            got=f"an attack that lasts until {attack.end:g} s from now",
            expected=f"at most {MAX_SECONDS:g} s",
        )


def _all_finite(values: np.ndarray) -> bool:
    """Whether all are numbers: if their sum of squares is, which a single call says."""
    return math.isfinite(np.vdot(values, values)) or bool(np.isfinite(values).all())
