"""An arm that hangs from a moving shoulder, step by step."""

from __future__ import annotations

import numpy as np


def hanging_arm(
    push: np.ndarray, rate: float, *, rad_s: float = 7.5, damping: float = 0.5, metres: float = 0.6
) -> np.ndarray:
    """θ″ = −a / L − 2 ζ ω θ′ − ω² θ from rest, the velocity first, then the angle. [F]"""
    angle, speed = 0.0, 0.0
    found = []
    for a in push:
        speed += (-a / metres - 2 * damping * rad_s * speed - rad_s**2 * angle) / rate
        angle += speed / rate
        found.append(angle)
    return np.array(found)
