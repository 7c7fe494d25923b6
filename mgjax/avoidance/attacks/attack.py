"""Attacks: spheres whose places over time are known, and what part of them matters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.errors import AttackError

MAX_SECONDS = 60.0
"""An attack that lasts longer is no throw at a character, and its motion would be endless."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Attack:
    """Spheres that move linearly between knots, there from the first knot to the last.

    Where ``starts`` and ``stops`` are given, each sphere is there only from its own start to its
    own stop, both included. :meth:`active` and :meth:`lives` say when a sphere is there; while it
    is not, :meth:`at` holds it at the place where it appears or vanishes.

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

    @property
    def lifetimes(self) -> tuple[Float[np.ndarray, " I"], Float[np.ndarray, " I"]]:
        """First and last moment of each sphere."""
        count = len(self.radii)
        starts = np.full(count, self.start) if self.starts is None else self.starts
        stops = np.full(count, self.end) if self.stops is None else self.stops
        return starts, stops

    def at(self, times: Float[np.ndarray, " T"]) -> Float[np.ndarray, "T I 3"]:
        """Centres at any time; each sphere is held before its first and after its last moment."""
        flat = self.centres.reshape(len(self.times), -1)
        out = np.empty((len(times), flat.shape[1]))
        if self.starts is None and self.stops is None:
            for column in range(flat.shape[1]):
                out[:, column] = np.interp(times, self.times, flat[:, column])
        else:
            starts, stops = (np.repeat(moments, 3) for moments in self.lifetimes)
            for column in range(flat.shape[1]):
                held = np.clip(times, starts[column], stops[column])
                out[:, column] = np.interp(held, self.times, flat[:, column])
        return out.reshape(len(times), *self.centres.shape[1:])

    def sampled(
        self, times: Float[np.ndarray, " T"]
    ) -> tuple[Float[np.ndarray, "T I 3"], Bool[np.ndarray, "T I"]]:
        """Centres at any time, and whether each sphere is there."""
        return self.at(times), self.active(times)

    def lives(self, times: Float[np.ndarray, " T"]) -> Bool[np.ndarray, "V I"]:
        """Whether each sphere is there at any moment between two times."""
        starts, stops = self.lifetimes
        return (times[1:, None] >= starts) & (times[:-1, None] <= stops)

    def active(self, times: Float[np.ndarray, " T"]) -> Bool[np.ndarray, "T I"]:
        """Whether each sphere is there; between two moments if it is at both."""
        starts, stops = self.lifetimes
        return (times[:, None] >= starts) & (times[:, None] <= stops)

    def only(self, spheres: Sequence[int]) -> Attack:
        """Some of its spheres."""
        rows = list(spheres)
        return replace(
            self,
            centres=self.centres[:, rows],
            radii=self.radii[rows],
            starts=None if self.starts is None else self.starts[rows],
            stops=None if self.stops is None else self.stops[rows],
        )

    def ended(self, sphere: int, time: float) -> Attack:
        """The same with one sphere that ends at a moment within its life."""
        starts, stops = (np.array(moments, np.float64) for moments in self.lifetimes)
        times = np.unique(np.append(self.times, time))
        centres = self.at(times)
        stops[sphere] = time
        return replace(self, times=times, centres=centres, starts=starts, stops=stops)

    @cached_property
    def largest_speed(self) -> float:
        """m/s, over all spheres and knots at which they are there."""
        if len(self.times) < 2:
            return 0.0
        displacements = self.centres[1:] - self.centres[:-1]
        speeds = np.sqrt(np.einsum("kix,kix->ki", displacements, displacements))
        speeds /= (self.times[1:] - self.times[:-1])[:, None]
        if self.starts is not None or self.stops is not None:
            active = self.active(self.times)
            speeds = np.where(active[1:] & active[:-1], speeds, 0.0)
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
