"""The choice model of the observer study in plain float64, from its definition."""

from __future__ import annotations

import math
from collections.abc import Sequence


def energy(
    measures: Sequence[float],
    weights: Sequence[float],
    E_avoidance: float,
    D_body: float,
    *,
    D_move: float = 0.3,
    E_time: float = 4.0,
    w_speed_up: float = 4.0,
) -> float:
    """e of a candidate of (e', d, d0, displacement, s); d0 clamped, weights a, b, m, t."""
    moved, d, d0, displacement, s = measures
    avoidance = max(0.0, 1 - moved / E_avoidance)
    excess = d - max(d0, 0.0)
    body = excess / D_body if 0 < excess < D_body else 1.0
    time = s / E_time if s >= 1 else (1 + w_speed_up * (1 / s - 1)) / E_time
    a, b, m, t = weights
    return a * avoidance + b * body + m * displacement / D_move + t * time


def loss(
    trials: Sequence[Sequence[Sequence[float]]],
    counts: Sequence[Sequence[float]],
    parameters: Sequence[float],
) -> float:
    """−log likelihood; parameters are four weights, log E_avoidance and log D_body."""
    total = 0.0
    for candidates, picked in zip(trials, counts, strict=True):
        energies = [
            energy(c, parameters[:4], math.exp(parameters[4]), math.exp(parameters[5]))
            for c in candidates
        ]
        norm = math.log(sum(math.exp(-e) for e in energies))
        for e, count in zip(energies, picked, strict=False):
            total += count * (e + norm)
    return total
