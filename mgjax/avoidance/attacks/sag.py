"""How far the spheres of an attack stray from straight lines between two moments."""

from __future__ import annotations

import numpy as np

from mgjax.avoidance.attacks.attack import Attack


def sag_of(attack: Attack, step: float) -> float:
    """How far spheres stray from straight lines over ``step`` s, m."""
    sag = (attack.acceleration + _kinks(attack, step)) * step**2 / 8
    if attack.acceleration and len(attack.times) > 1:
        interval = float((attack.times[1:] - attack.times[:-1]).max())
        sag += attack.acceleration * interval**2 / 8 if interval > step else 0.0
    return sag


def _kinks(attack: Attack, step: float) -> float:
    """Acceleration whose bend over ``step`` covers the corners at an attack's knots, m/s².

    Cutting a corner of Δv costs Δv · step/4 at most, several within a step the sum of theirs. The
    knots of a smooth flight bend by no more than its acceleration says.
    """
    if len(attack.times) < 3:
        return 0.0
    times = attack.times
    span = times[1:] - times[:-1]
    velocity = (attack.centres[1:] - attack.centres[:-1]) / span[:, None, None]
    turns = velocity[1:] - velocity[:-1]
    near = np.minimum(span, step)
    smooth = (1.01 * 0.5 * attack.acceleration) * (near[1:] + near[:-1]) + 1e-6
    excess = np.sqrt(np.einsum("tik,tik->ti", turns, turns)) - smooth[:, None]
    if excess.max() <= 0:
        return 0.0
    excess = np.maximum(excess, 0.0)
    # Where a sphere comes or goes it has no motion on the other side.
    inner = attack.times[1:-1, None]
    if attack.starts is not None:
        excess = np.where(inner > attack.starts, excess, 0.0)
    if attack.stops is not None:
        excess = np.where(inner < attack.stops, excess, 0.0)
    total = np.concatenate([[0.0], np.cumsum(excess.max(axis=1))])
    knots = attack.times[1:-1]
    upto = np.searchsorted(knots, knots + step, side="right")
    return float((total[upto] - total[:-1]).max()) * 2 / step
