"""Squared distances of single pairs of windows in float64, where float32 cannot tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float, Int

from mgjax.graph.distances.axis import Axis

_CHUNK = 512
"""Pairs whose windows are copied at a time: what they take stays in the cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Windows:
    """All windows of an axis, each row one; with sqrt(weight / frames) multiplied in.

    Attributes:
        about: horizontal places about the middle of their frame, x + iz, m. [N, W J]
        level: heights, m. [N, W J]
        path: middles of the frames, m. [N, W]
        spread: mean square of ``about``, m². [N, W]
    """

    about: Complex[np.ndarray, "N V"]
    level: Float[np.ndarray, "N V"]
    path: Complex[np.ndarray, "N W"]
    spread: Float[np.ndarray, "N W"]


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
    windows = _windows(axis) if len(out) else None
    for first in range(0, len(out), _CHUNK):
        assert windows is not None
        a, b = axis.frames[pairs[:, first : first + _CHUNK]]
        out[first : first + _CHUNK] = _squared(windows, a, b)
    out[rows == columns] = 0.0
    return np.maximum(np.round(out / axis.grain) * axis.grain, 0.0)


def _windows(axis: Axis) -> _Windows:
    places = axis.positions.astype(np.float64)
    share = np.sqrt(axis.weights.astype(np.float64) / axis.window)
    flat = places[..., 0] + 1j * places[..., 2]
    middle = flat @ axis.weights.astype(np.float64)
    about = (flat - middle[:, None]) * share
    spread = np.vecdot(about, about).real * axis.window
    each = (about, places[..., 1] * share, middle[:, None], spread[:, None])
    names = ("about", "level", "path", "spread")
    return _Windows(
        **{name: _rows(values, axis.window) for name, values in zip(names, each, strict=True)}
    )


def _rows(values: np.ndarray, window: int) -> np.ndarray:
    """A view whose rows are all windows of so many frames, one frame after another. [N, W C]"""
    values = np.ascontiguousarray(values)
    return np.lib.stride_tricks.as_strided(
        values,
        (len(values) - window + 1, window * values.shape[1]),
        (values.strides[0], values.itemsize),
        writeable=False,
    )


def _squared(
    windows: _Windows, a: Int[np.ndarray, " N"], b: Int[np.ndarray, " N"]
) -> Float[np.ndarray, " N"]:
    """D² of the windows that begin at some frames, m²."""
    count = windows.path.shape[1]
    paths = [windows.path[each] for each in (a, b)]
    paths = [(path - path.mean(axis=1, keepdims=True)) / np.sqrt(count) for path in paths]
    product = np.vecdot(windows.about[a], windows.about[b]) + np.vecdot(*paths)
    spread = sum(
        windows.spread[each].mean(axis=1) + np.vecdot(path, path).real
        for each, path in zip((a, b), paths, strict=True)
    )
    rise = windows.level[a] - windows.level[b]
    return spread + np.vecdot(rise, rise) - 2 * np.abs(product)
