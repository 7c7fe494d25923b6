"""The figures of a motion, their meaning, and what exceeds the capture."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

FIGURES = {
    "skate_ratio": ("share of frames in which a foot skates", ""),
    "contact_speed": ("speed of a toe below 5 cm", "m/s"),
    "contact_fast": ("share of those frames above 0.2 m/s", ""),
    "skate_cm": ("slide of toes and ankles a frame", "cm"),
    "normalised_jerk": ("normalised jerk of 0.4 s, geometric mean", ""),
    "jerky": ("share of windows above the capture's 99.9 %", ""),
    "jerk_ratio": ("largest jerk by that quantile", ""),
    "velocity_jump": ("largest jump of a joint's velocity", "m/s"),
    "sink": ("largest depth of toe or ankle under the floor", "m"),
    "floating": ("height of the standing foot over its rest", "m"),
    "self_penetration": ("limbs deeper in the body than captured", "m"),
    "limits": ("joints beyond their captured range", "°"),
    "speed_distance": ("Hellinger distance of joint speeds", ""),
}
"""What each figure is, and its unit."""
NEEDS_CAPTURE = ("jerky", "jerk_ratio", "limits", "speed_distance")
"""Figures that say something only of the same joints in capture."""
FLOORS = {
    "skate_ratio": 0.005,
    "jerky": 0.005,
    "sink": 0.005,
    "self_penetration": 0.01,
    "limits": 5.0,
    "speed_distance": 0.05,
}
"""Below these nothing is at fault; lengths of an adult."""
LENIENCE = 1.1
"""A figure may be so many times that of the capture."""


@dataclass(frozen=True, kw_only=True)
class Quality:
    """How good a motion is.

    Attributes:
        seconds: its length.
        figures: by the names of :data:`FIGURES`; NaN where it shows nothing of the kind, or where
            there is no capture of these joints.
        at_seams: the same of frames and windows in seams alone; empty without seams.
        beside: median and 95th percentile of the same figures of the capture's own pieces of this
            length; empty without capture.
        faults: figures that are above what is never a fault and above 1.1 × the capture's 95th
            percentile.
        notes: what could not be measured.
    """

    seconds: float
    figures: Mapping[str, float]
    at_seams: Mapping[str, float]
    beside: Mapping[str, tuple[float, float]]
    faults: tuple[str, ...]
    notes: tuple[str, ...]


def percentiles(values: np.ndarray) -> tuple[float, float]:
    """Median and 95th percentile of the numbers among the values; NaN where there is none."""
    known = values[np.isfinite(values)]
    if not len(known):
        return math.nan, math.nan
    middle, high = np.percentile(known, [50, 95])
    return float(middle), float(high)


def faults_of(
    figures: Mapping[str, float], beside: Mapping[str, tuple[float, float]], scale: float
) -> tuple[str, ...]:
    """The figures that a viewer would call faults."""
    found: list[str] = []
    for name, value in figures.items():
        floor = FLOORS.get(name, 0.0) * (scale if FIGURES[name][1] == "m" else 1.0)
        usual = beside.get(name, (math.nan, math.nan))[1]
        if math.isnan(usual):
            usual = 0.0 if name in FLOORS else math.inf
        if value > floor and value > LENIENCE * usual:
            found.append(name)
    return tuple(found)
