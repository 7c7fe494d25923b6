"""Gestures: channels of the body leave neutral quickly and come back at leisure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mgjax.core.arrays import Array

_TRUNK_S = {"bend": 0.03, "lean": 0.03, "twist": 0.035, "look": 0.06, "nod": 0.06, "tilt": 0.06}
_LIMBS_S = {"flex": 0.06, "open": 0.05, "turn": 0.06, "elbow": 0.08, "heel": 0.03}
LAG_S = _TRUNK_S | _LIMBS_S
"""By how much channels follow the pelvis: the hips lead, chest, head and arms come after."""
_QUICK, _SLOW = 0.85, 1.25
"""A gesture is ahead of a minimum jerk on its way out, and settles longer on its way back."""


@dataclass(frozen=True, kw_only=True)
class Gesture:
    """Channels leave neutral, hold and return.

    ``moves`` are the largest deviations by channel (or, without its ``_l`` or ``_r``, both), m
    and degrees.
    """

    start_s: float
    rise_s: float
    hold_s: float
    fall_s: float
    moves: Mapping[str, float]

    def envelope(self, t: Array) -> Array:
        """From 0 to 1 and back."""
        back = self.start_s + self.rise_s + self.hold_s
        out = np.clip((t - self.start_s) / self.rise_s, 0.0, 1.0) ** _QUICK
        home = 1 - (1 - np.clip((t - back) / self.fall_s, 0.0, 1.0)) ** _SLOW
        return ease(out) - ease(home)


def ease(x: Array) -> Array:
    """From 0 to 1 with two zero derivatives at both ends (minimum jerk)."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * x * (10 + x * (6 * x - 15))
