"""The part of an attack that is close to the character."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import NamedTuple

import numpy as np

from mgjax.avoidance.attacks.attack import Attack

RATE = 1000.0
"""Moments per second at which an attack is looked at."""
_FEW = 24
"""Most coordinates of knots that are looked at one by one."""
MARGIN_M = 1e-6


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

    The attack is looked at every millisecond at most, at evenly spaced moments.

    Args:
        attack: in the planar frame of the body at the beginning of the path, whose root is above
            the origin.
        radius, height: of the cylinder, m; it is lower than 2 km, where spheres are that are not
            there.
        start: nothing before this counts, s from now.
    """
    begin, end = max(attack.start, float(start)), attack.end
    if end < begin:
        return None
    count = math.ceil((end - begin) * RATE) + 2
    samples = _Samples(begin=begin, end=end, step=(end - begin) / (count - 1), count=count)
    # Lines of few knots are clipped one by one; to look at many knots at once is quicker.
    few = len(attack.times) > 1 and attack.centres.size <= _FEW
    if few and attack.starts is None and attack.stops is None:
        span = _first_and_last(attack, samples, radius, height)
    else:
        span = _of_many(attack, samples, radius, height)
    if span is None:
        return None
    return Crop(start=samples.time(span[0]), end=samples.time(span[1]))


@dataclass(frozen=True, kw_only=True)
class _Samples:
    """Evenly spaced moments, to the last bit those of ``np.linspace``."""

    begin: float
    end: float
    step: float
    count: int

    def time(self, number: int) -> float:
        """One of the moments."""
        return self.end if number == self.count - 1 else number * self.step + self.begin

    def between(self, start: float, stop: float) -> range:
        """Numbers of the moments from start to stop; rounding may add one at either end."""
        if self.step <= 0:
            return range(self.count)
        first = math.ceil((max(start, self.begin) - self.begin) / self.step - 0.01)
        last = math.floor((max(stop, self.begin) - self.begin) / self.step + 0.01)
        return range(max(first, 0), min(last + 1, self.count))


def _of_many(
    attack: Attack, samples: _Samples, radius: float, height: float
) -> tuple[int, int] | None:
    """First and last moment at which a centre is in the cylinder: all moments in question."""
    known = _time_near_vertical(attack, radius)
    if known is None:
        return None
    numbers = samples.between(*known)
    times = np.arange(numbers.start, numbers.stop) * samples.step + samples.begin
    if numbers.stop == samples.count:
        times[-1:] = samples.end
    centres = attack.at(times)
    near = (np.hypot(centres[..., 0], centres[..., 2]) <= radius) & (centres[..., 1] <= height)
    near &= centres[..., 1] >= 0
    if attack.starts is not None or attack.stops is not None:
        near &= attack.active(times)
    inside = near.nonzero()[0]
    if not inside.size:
        return None
    return numbers.start + int(inside[0]), numbers.start + int(inside[-1])


def _time_near_vertical(attack: Attack, radius: float) -> tuple[float, float] | None:
    """A time outside of which no centre is within ``radius`` of the vertical; None if none ever is.

    Every place of a centre is within half a step of one of the two knots around it.
    """
    centres = attack.centres
    x, z = centres[..., 0], centres[..., 2]
    # A horizontal step is at most √2 of the largest of its components.
    largest = np.abs(centres[1:] - centres[:-1]).max(initial=0.0)
    reach = radius + 0.7072 * float(largest) + 1e-9
    near = (x * x + z * z <= reach * reach).nonzero()[0]
    if not near.size:
        return None
    first, last = max(int(near[0]) - 1, 0), min(int(near[-1]) + 1, len(attack.times) - 1)
    return float(attack.times[first]), float(attack.times[last])


def _first_and_last(
    attack: Attack, samples: _Samples, radius: float, height: float
) -> tuple[int, int] | None:
    """First and last moment at which a centre is in the cylinder: from both ends of each line."""
    times = attack.times.tolist()
    span: list[int] = []
    for places in attack.centres.transpose(1, 0, 2).tolist():
        lines = list(pairwise(zip(times, places, strict=True)))
        for order, turn in ((lines, 1), (lines[::-1], -1)):
            inside = (
                number
                for line in (_Line(*start, *stop) for start, stop in order)
                for number in line.about_inside(samples, radius, height)[::turn]
                if line.is_inside(samples.time(number), radius, height)
            )
            span += islice(inside, 1)
    return (min(span), max(span)) if span else None


class _Line(NamedTuple):
    """A centre that moves straight from one place to another."""

    start: float
    a: list[float]
    stop: float
    b: list[float]

    def about_inside(self, samples: _Samples, radius: float, height: float) -> range:
        """The moments at which it is in the cylinder, perhaps some more."""
        shares = self._shares_inside(radius, height)
        if shares is None:
            return range(0)
        start, span = self.start, self.stop - self.start
        return samples.between(start + shares[0] * span, start + shares[1] * span)

    def _shares_inside(self, radius: float, height: float) -> tuple[float, float] | None:
        """From which to which share of its way it is in the cylinder, with a margin."""
        a, b = self.a, self.b
        low, high = 0.0, 1.0
        dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        if abs(dy) > MARGIN_M:
            ends = sorted(((-MARGIN_M - a[1]) / dy, (height + MARGIN_M - a[1]) / dy))
            low, high = max(low, ends[0]), min(high, ends[1])
        squared, along = dx * dx + dz * dz, a[0] * dx + a[2] * dz
        if squared > MARGIN_M**2:
            excess = a[0] * a[0] + a[2] * a[2] - (radius + MARGIN_M) ** 2
            root = along * along - squared * excess
            if root < 0:
                return None
            root = math.sqrt(root)
            low, high = max(low, (-along - root) / squared), min(high, (-along + root) / squared)
        return (low, high) if low <= high else None

    def is_inside(self, time: float, radius: float, height: float) -> bool:
        """Whether it is in the cylinder at a time; its place is to the last bit ``np.interp``'s."""
        if not self.start <= time <= self.stop:
            return False
        x, y, z = self.b
        if time < self.stop:
            since, span = time - self.start, self.stop - self.start
            x, y, z = [(q - p) / span * since + p for p, q in zip(self.a, self.b, strict=True)]
        if not 0 <= y <= height:
            return False
        share = (x * x + z * z) / (radius * radius)
        if abs(share - 1) > 1e-9:
            return bool(share < 1)
        return bool(np.hypot(x, z) <= radius)
