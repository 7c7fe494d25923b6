"""Windows of motion in float64, as the exact distance of single pairs needs them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float


@dataclass(frozen=True, kw_only=True, eq=False)
class Windows:
    """All windows of a row of frames, each row one; with sqrt(weight / frames) multiplied in.

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


def windows_of(
    positions: Float[np.ndarray, "F J 3"], weights: Float[np.ndarray, " J"], window: int
) -> Windows:
    """All windows of so many frames; about half a kilobyte a frame of 22 joints.

    Args:
        positions: of the joints, m.
        weights: with the sum 1.
        window: frames.
    """
    places, weights = positions.astype(np.float64), weights.astype(np.float64)
    share = np.sqrt(weights / window)
    flat = places[..., 0] + 1j * places[..., 2]
    middle = flat @ weights
    about = (flat - middle[:, None]) * share
    spread = np.vecdot(about, about).real * window
    each = (about, places[..., 1] * share, middle[:, None], spread[:, None])
    names = ("about", "level", "path", "spread")
    return Windows(
        **{name: _rows(values, window) for name, values in zip(names, each, strict=True)}
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
