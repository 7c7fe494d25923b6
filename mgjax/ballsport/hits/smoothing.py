"""A short symmetric low pass that a stream can apply with a fixed delay."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float


def half_width(frame_rate: float, seconds: float) -> int:
    """Frames on either side that the filter sees: three standard deviations."""
    return int(np.ceil(3 * seconds * frame_rate - 1e-9))


def smooth(
    positions: Float[np.ndarray, "F 3"], frame_rate: float, seconds: float
) -> Float[np.ndarray, "F 3"]:
    """Gaussian mean over frames with the standard deviation ``seconds``.

    At the ends the mean is over the frames that there are. 0 s changes nothing.
    """
    half = half_width(frame_rate, seconds)
    if half == 0:
        return positions
    taps = np.exp(-0.5 * (np.arange(-half, half + 1) / (seconds * frame_rate)) ** 2)
    padded = np.pad(positions, [(half, half), (0, 0)])
    weight = np.pad(np.ones(len(positions)), half)
    count = len(positions)
    total = sum(tap * padded[k : k + count] for k, tap in enumerate(taps))
    share = sum(tap * weight[k : k + count] for k, tap in enumerate(taps))
    return np.asarray(total) / np.asarray(share)[:, None]
