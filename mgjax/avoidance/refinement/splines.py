"""Cubic B-splines over a window of time, which vanish at both of its ends."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

SPLINES = 5
"""Of each channel: a way out, a place to be, and a way back."""


def basis(
    times: Float[np.ndarray, " T"], start: float, stop: float, count: int = SPLINES
) -> Float[np.ndarray, "T K"]:
    """Uniform cubic B-splines that lie wholly within a window, at some times.

    The window is divided into ``count`` + 3 equal pieces. Each spline spans four of them, so value,
    first and second derivative are 0 at both ends, and outside.

    Args:
        times: s.
        start, stop: of the window, s.
        count: splines.
    """
    position = (np.asarray(times, np.float64) - start) / (stop - start) * (count + 3)
    away = np.abs(position[:, None] - (np.arange(count) + 2))  # from the middle of each
    inner = 2 / 3 - away**2 + 0.5 * away**3
    outer = np.maximum(2 - away, 0.0) ** 3 / 6
    return np.where(away < 1, inner, outer)


def size_matrix(count: int = SPLINES, bend: float = 0.02) -> Float[np.ndarray, "K K"]:
    """Q such that xᵀ Q x says how large the curve with coefficients x is.

    The mean over the window of its square, and of the square of its second derivative by the
    window's pieces, times ``bend``.
    """
    fine = np.linspace(0.0, 1.0, 64 * (count + 3) + 1)
    values = basis(fine, 0.0, 1.0, count)
    step = 1 / 64
    curve = np.diff(values, n=2, axis=0) / step**2
    return values.T @ values / len(fine) + bend * (curve.T @ curve) / len(curve)
