"""Fixed shapes: sizes from a few buckets, and arrays padded to them.

A jitted function is compiled once for each shape it meets. Host code therefore rounds sizes up to
a bucket and pads; the jitted code gets a count or a mask and never lets the padding matter.
"""

from __future__ import annotations

import numpy as np


def bucket_size(count: int, minimum: int = 16, factor: int = 2) -> int:
    """The smallest ``minimum * factor**k`` that holds ``count`` items."""
    size = minimum
    while size < count:
        size *= factor
    return size


def pad_axis(
    array: np.ndarray, size: int, *, axis: int = 0, value: float | None = None
) -> np.ndarray:
    """Pads ``array`` to ``size`` along ``axis``: with ``value``, or by repeating the last item."""
    missing = size - array.shape[axis]
    if missing < 0:
        raise ValueError(f"cannot pad {array.shape[axis]} items into {size}")
    if not missing:
        return array
    width = [(0, 0)] * array.ndim
    width[axis] = (0, missing)
    if value is None and array.shape[axis] > 0:
        return np.pad(array, width, mode="edge")
    return np.pad(array, width, constant_values=0 if value is None else value)
