"""Squared distances of single pairs of windows in float64, where float32 cannot tell."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.windows import Windows

_CHUNK = 128
"""Pairs whose windows are copied at a time: what they take stays in the cache."""


def exact_squared(
    axis: Axis, rows: Int[np.ndarray, " N"], columns: Int[np.ndarray, " N"]
) -> Float[np.ndarray, " N"]:
    """D² of pairs of windows, hybrid paper eq. 1, in float64, m²; the same both ways round.

    Values are multiples of the axis's grain, so that equal windows are as far from all others.
    Places count from the middle of their frame and middles from that of their window, so nothing
    large cancels.

    Args:
        axis: of all clips.
        rows, columns: entries of the axis that are windows.
    """
    pairs = np.stack([np.minimum(rows, columns), np.maximum(rows, columns)])
    out = np.zeros(pairs.shape[1])
    for first in range(0, len(out), _CHUNK):
        a, b = axis.frames[pairs[:, first : first + _CHUNK]]
        out[first : first + _CHUNK] = _squared(axis.windows, a, b)
    out[rows == columns] = 0.0
    return np.maximum(np.round(out / axis.grain) * axis.grain, 0.0)


def _squared(
    windows: Windows, a: Int[np.ndarray, " N"], b: Int[np.ndarray, " N"]
) -> Float[np.ndarray, " N"]:
    """D² of the windows that begin at some frames, m²."""
    product = np.vecdot(windows.about[a], windows.about[b])
    product += np.vecdot(windows.path[a], windows.path[b])
    rise = windows.level[a] - windows.level[b]
    return windows.spread[a] + windows.spread[b] + np.vecdot(rise, rise) - 2 * np.abs(product)
