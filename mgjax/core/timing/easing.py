"""Weights that rise smoothly from 0 to 1."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from mgjax.core.arrays import Array, namespace


def smoothstep(share: Float[Array, "*s"]) -> Float[Array, "*s"]:
    """3 s² − 2 s³ with s held between 0 and 1: a weight whose slope is 0 at both ends."""
    inside = namespace(share).clip(share, 0.0, 1.0)
    return 3 * inside**2 - 2 * inside**3


def plateau(
    frames: Int[np.ndarray, " F"], first: int, last: int, rise: int, fall: int
) -> Float[np.ndarray, " F"]:
    """A smooth trapezoid: 1 from frame ``first`` to ``last``, 0 well before and after it.

    Args:
        frames: numbers of the frames.
        first, last: of the top, ends included.
        rise, fall: frames that the weight takes from 0 to 1, and back; 0 for at once.
    """
    up = _ramp(frames - first, rise)
    return np.minimum(up, _ramp(last - frames, fall))


def _ramp(since: Int[np.ndarray, " F"], length: int) -> Float[np.ndarray, " F"]:
    """From 0 at ``−length`` to 1 at 0, smoothly; a step for no length."""
    if length == 0:
        return (since >= 0).astype(np.float64)
    return np.asarray(smoothstep((since + length) / length))
