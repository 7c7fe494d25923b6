"""Distances of hits and of poses, and transition sections, in plain float64 loops."""

from __future__ import annotations

import math

import numpy as np


def hit_distance(a, b, weights) -> float:
    """D_m (eq. 2) of two motion vectors: (displacements [4,3], seconds [4], v_max)."""
    total = weights[0] * abs(float(a[2]) - float(b[2]))
    for i in range(4):
        total += weights[1] * math.dist([float(x) for x in a[0][i]], [float(x) for x in b[0][i]])
        total += weights[2] * abs(float(a[1][i]) - float(b[1][i]))
    return total


def pose_feature(positions, f: int, first: int, stop: int, joints, hips, rate: float) -> list:
    """Places and velocities of the joints in frame ``f`` in the body's planar frame."""

    def turned(x: float, y: float, z: float) -> tuple[float, float, float]:
        # Components along the body's left, up and ahead.
        return x * left[0] + z * left[1], y, x * ahead[0] + z * ahead[1]

    across = positions[f, hips[0]].astype(float) - positions[f, hips[1]]
    size = math.hypot(across[0], across[2])
    # (left − right) × up, on the floor
    ahead = (-across[2] / size, across[0] / size)
    left = (ahead[1], -ahead[0])
    root = positions[f, 0].astype(float)
    a, b = max(f - 1, first), min(f + 1, stop - 1)
    places, velocities = [], []
    for j in joints:
        x, y, z = positions[f, j].astype(float)
        places.append(turned(x - root[0], y, z - root[2]))
        step = (positions[b, j].astype(float) - positions[a, j]) * rate / (b - a)
        velocities.append(turned(*step))
    return places + velocities


def section(a: np.ndarray, b: np.ndarray, weights, window: int, loop: int | None):
    """Least sum of D_p (eq. 1) over two windows of poses [F,10,3], and where; None if too short."""
    best = None
    for r in range(len(a) - window + 1):
        for c in range(len(b) - window + 1):
            if loop is not None and c > r - loop:
                continue
            total = 0.0
            for k in range(window):
                for i in range(10):
                    total += weights[i] * math.dist(a[r + k][i], b[c + k][i])
            if best is None or total < best[0]:
                best = total, r, c
    return best
