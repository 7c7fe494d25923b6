"""Where feet and root should be, point by point and frame by frame, from the definition."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mgjax.graph.feet import course as settings


def nothing() -> dict[str, Any]:
    """The state of a motion that is as it is."""
    return {
        "offset": np.zeros((2, 2, 2)),
        "drift": np.zeros((2, 2, 2)),
        "lead": np.zeros(2),
        "leading": np.zeros(2),
        "lift": np.zeros(2),
        "drop": 0.0,
        "anchor": np.ones(2),
    }


def followed(
    points: np.ndarray,
    hips: np.ndarray,
    reach: np.ndarray,
    stands: np.ndarray,
    *,
    rate: float,
    scale: float,
) -> list[dict[str, Any]]:
    """The state at every frame, of points [T, 2, 2, 3], hips [T, 2, 3], reach and stands."""
    states = [nothing()]
    dt = 1 / rate
    for t in range(1, len(points)):
        old, new = states[-1], nothing()
        for foot in range(2):
            for point in range(2):
                own = points[:, foot, point][:, [0, 2]]
                speed = (own[t] - own[t - 1]) / dt
                before = (own[t - 1] - own[t - 2]) / dt if t > 1 else speed
                off, drift = old["offset"][foot, point], old["drift"][foot, point]
                if stands[t, foot, point]:
                    rest = (before + drift) * math.exp(-dt / settings.STOP_S)
                    away = off - old["lead"]
                    easy, most = settings.EASY_M * scale, settings.MOST_M * scale
                    excess = max(float(np.linalg.norm(away)) - easy, 0.0) / (most - easy)
                    slip = settings.SLIP_PER_S * excess**2 * min(excess, 1.0)
                    moved = off + dt * (rest - speed - slip * away)
                else:
                    goal = settings.KEPT * old["lead"]
                    moved = spring(off, goal, drift, settings.SWING_S, dt)
                moved = within(moved, old["lead"], settings.MOST_M * scale)
                new["offset"][foot, point] = moved
                new["drift"][foot, point] = (moved - off) / dt
        weights = stands[t].astype(float) + 1e-3
        goal = (weights[..., None] * new["offset"]).sum(axis=(0, 1)) / weights.sum()
        goal = within(goal, np.zeros(2), settings.MOST_LEAD_M * scale)
        new["lead"] = spring(old["lead"], goal, old["leading"], settings.LEAD_S, dt)
        new["leading"] = (new["lead"] - old["lead"]) / dt
        least, needed = settings.RISE_M_S * scale * dt, 0.0
        for foot in range(2):
            heights = points[:, foot, :, 1]
            sunk = max(-float(heights[t].min()), 0.0)
            fastest = max(float((heights[t - 1] - heights[t]).max()), least)
            new["lift"][foot] = after(old["lift"][foot], sunk, fastest, dt)
            if stands[t, foot].any():
                x, z = new["lead"] - new["offset"][foot, 1]
                gap = hips[t, foot] - points[t, foot, 1] + np.array([x, -new["lift"][foot], z])
                room = max(reach[t, foot] ** 2 - gap[0] ** 2 - gap[2] ** 2, 1e-8)
                needed = max(needed, gap[1] - math.sqrt(room))
            held = 1.0 if stands[t, foot, 0] else 0.0 if stands[t, foot, 1] else None
            anchor = old["anchor"][foot]
            towards = anchor if held is None else held
            change = 1 - math.exp(-dt / settings.ANCHOR_S)
            new["anchor"][foot] = anchor + (towards - anchor) * change
        new["drop"] = after(old["drop"], needed, least, dt)
        states.append(new)
    return states


def spring(
    value: np.ndarray, goal: np.ndarray, speed: np.ndarray, constant: float, dt: float
) -> np.ndarray:
    """Where a critically damped spring is after ``dt``."""
    off = value - goal
    return goal + (off + (speed + off / constant) * dt) * math.exp(-dt / constant)


def within(value: np.ndarray, middle: np.ndarray, most: float) -> np.ndarray:
    """A place at most so far from the middle."""
    far = float(np.linalg.norm(value - middle))
    return value if far <= most else middle + (value - middle) * most / far


def after(value: float, needed: float, rise: float, dt: float) -> float:
    """What is needed, reached at most so fast, or what is left of what was."""
    return max(min(needed, value + rise), value * math.exp(-dt / settings.FALL_S))
