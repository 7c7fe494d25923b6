"""Windows of motion in float64, as the exact distance of single pairs needs them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float


@dataclass(frozen=True, kw_only=True, eq=False)
class Windows:
    """All windows of a row of frames, each row one; with sqrt(weight / frames) multiplied in.

    Attributes:
        about: horizontal places of the joints that count about the middle of their frame, x + iz,
            m. [N, W J]
        level: their heights, m. [N, W J]
        path: middles of the frames about that of the window, m, by sqrt(frames). [N, W]
        spread: squared length of ``about`` and ``path``, m². [N]
    """

    about: Complex[np.ndarray, "N V"]
    level: Float[np.ndarray, "N V"]
    path: Complex[np.ndarray, "N W"]
    spread: Float[np.ndarray, " N"]


def windows_of(
    positions: Float[np.ndarray, "F J 3"], weights: Float[np.ndarray, " J"], window: int
) -> Windows:
    """All windows of so many frames; about 0.7 kilobytes a frame of 22 joints.

    Args:
        positions: of the joints, m.
        weights: with the sum 1.
        window: frames.
    """
    places, weights = positions[:, weights > 0].astype(np.float64), weights.astype(np.float64)
    weights = weights[weights > 0]
    share = np.sqrt(weights / window)
    flat = places[..., 0] + 1j * places[..., 2]
    middle = flat @ weights
    about = (flat - middle[:, None]) * share
    each = _rows(np.vecdot(about, about).real[:, None], window).sum(axis=1)
    path = _rows(middle[:, None], window)
    path = (path - path.mean(axis=1, keepdims=True)) / np.sqrt(window)
    return Windows(
        about=_rows(about, window),
        level=_rows(places[..., 1] * share, window),
        path=path,
        spread=each + np.vecdot(path, path).real,
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
