"""Several attacks as one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mgjax.avoidance.attacks.attack import (
    Attack,
    validate_attack,
)
from mgjax.core.errors import AttackError


def merge_attacks(attacks: Sequence[Attack]) -> Attack:
    """One attack with the spheres of all, in order, each there exactly while its own attack lasts.

    The knots are those of all attacks, and more where nothing is known for long, so that what one
    attack bends between its knots does not count for more than it did.

    Raises:
        AttackError: no attacks, or one that is not valid.
    """
    if not attacks:
        raise AttackError("got no attacks to merge, expected at least one")
    for attack in attacks:
        validate_attack(attack)
    if len(attacks) == 1:
        return attacks[0]
    starts, stops = zip(*(attack.lifetimes for attack in attacks), strict=True)
    times = np.unique(np.concatenate([attack.times for attack in attacks]))
    acceleration = max(attack.acceleration for attack in attacks)
    if acceleration > 0:
        times = _filled(times, _widest(attacks, acceleration))
    merged = Attack(
        times=times,
        centres=np.concatenate([attack.at(times) for attack in attacks], axis=1),
        radii=np.concatenate([attack.radii for attack in attacks]),
        acceleration=acceleration,
        starts=np.concatenate(starts),
        stops=np.concatenate(stops),
    )
    first, last = merged.lifetimes
    if (first == merged.start).all() and (last == merged.end).all():
        return replace(merged, starts=None, stops=None)
    return merged


def _widest(attacks: Sequence[Attack], acceleration: float) -> float:
    """Knots this far apart bend no more under ``acceleration`` than the attacks do by themselves.

    Not finer than 1/480 s: straight attacks beside a bent one would need endless knots.
    """
    bends = [a.acceleration * np.diff(a.times).max(initial=0.0) ** 2 for a in attacks]
    return max(math.sqrt(max(bends) / acceleration), 1 / 480)


def _filled(times: np.ndarray, widest: float) -> np.ndarray:
    """The times, and evenly spaced ones where two are farther apart than ``widest``."""
    pieces = np.maximum(np.ceil(np.diff(times) / widest - 1e-6).astype(np.int64), 1)
    which = np.repeat(np.arange(len(pieces)), pieces)
    number = np.arange(len(which)) - (np.cumsum(pieces) - pieces)[which]
    filled = times[which] + np.diff(times)[which] * (number / pieces[which])
    return np.append(filled, times[-1])
