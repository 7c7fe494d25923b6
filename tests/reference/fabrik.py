"""FABRIK as printed, in plain loops and float64: stages alone, no closed form, no limits."""

from __future__ import annotations

import numpy as np


def solve(joints, target, *, tolerance: float, max_iterations: int) -> tuple[np.ndarray, int]:
    """The joints, and the iterations taken; −1 where the target is out of reach."""
    points = np.array(joints, np.float64)
    target = np.asarray(target, np.float64)
    lengths = [float(np.linalg.norm(b - a)) for a, b in zip(points, points[1:], strict=False)]
    root = points[0].copy()
    distance = float(np.linalg.norm(target - root))
    if distance > sum(lengths):
        for i, length in enumerate(lengths):
            points[i + 1] = points[i] + length * (target - root) / distance
        return points, -1
    for taken in range(max_iterations):
        if np.linalg.norm(points[-1] - target) <= tolerance:
            return points, taken
        points[-1] = target
        for i in range(len(lengths) - 1, -1, -1):
            way = points[i] - points[i + 1]
            points[i] = points[i + 1] + lengths[i] * way / np.linalg.norm(way)
        points[0] = root
        for i, length in enumerate(lengths):
            way = points[i + 1] - points[i]
            points[i + 1] = points[i] + length * way / np.linalg.norm(way)
    return points, max_iterations


def reach(joints) -> tuple[float, float]:
    """Nearest and farthest distance from the root at which the end can be."""
    lengths = np.linalg.norm(np.diff(np.asarray(joints, np.float64), axis=0), axis=-1)
    return max(0.0, 2 * float(lengths.max()) - float(lengths.sum())), float(lengths.sum())
