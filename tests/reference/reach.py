"""Reaching, in plain loops and float64: distances of capsules, range on the floor, weights."""

from __future__ import annotations

import math

import numpy as np


def segment_distance(a, b, c, d, samples: int = 401) -> float:
    """Least distance of two segments, by trying points of the one against the other."""
    a, b, c, d = (np.asarray(x, np.float64) for x in (a, b, c, d))
    least = math.inf
    for share in np.linspace(0, 1, samples):
        point = a + share * (b - a)
        along = float(np.dot(point - c, d - c) / np.dot(d - c, d - c))
        near = c + min(max(along, 0.0), 1.0) * (d - c)
        least = min(least, float(np.linalg.norm(point - near)))
    return least


def radius(lengths, height: float, base: float) -> float:
    """√((0.95 Σd)² − Δy²); NaN where Δy > 0.95 Σd."""
    whole = 0.95 * sum(lengths)
    above = height - base
    return math.sqrt(whole**2 - above**2) if abs(above) <= whole else math.nan


def weight(frame: int, first: int, last: int, blend: int) -> float:
    """1 over the hold, a cubic of slope 0 at both ends before and after it."""
    away = max(first - frame, frame - last, 0)
    share = max(1 - away / blend, 0.0)
    return 3 * share**2 - 2 * share**3
