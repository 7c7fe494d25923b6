"""Timing on a machine that others use too: medians, quartiles, ratios within one run."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import jax
import numpy as np


def seconds_of(work: Callable[[], Any]) -> float:
    """Wall seconds of one call, its arrays included."""
    start = time.perf_counter()
    jax.block_until_ready(work())
    return time.perf_counter() - start


def interleaved(
    work: Callable[[], Any], bare: Callable[[], Any] | None, repeats: int
) -> dict[str, Any]:
    """Times ``work`` and ``bare`` in turns, after a first call of each that compiles.

    Returns:
        ``median_s``, ``quartiles_s`` and ``first_call_s`` of ``work`` (the first call compiles or
        loads the program; ``compile_s`` is what it took beyond the median), and with ``bare`` also
        ``bare_median_s``, ``ratios`` of neighbouring pairs, and ``time_ratio``, their median.
    """
    first = seconds_of(work)
    if bare is not None:
        seconds_of(bare)
    pairs = [
        (seconds_of(work), seconds_of(bare) if bare is not None else np.nan) for _ in range(repeats)
    ]
    times, others = np.array(pairs).T
    row: dict[str, Any] = {
        "median_s": float(np.median(times)),
        "quartiles_s": [float(q) for q in np.percentile(times, [25, 75])],
        "first_call_s": first,
        "compile_s": max(first - float(np.median(times)), 0.0),
        "repeats": repeats,
    }
    if bare is not None:
        row["bare_median_s"] = float(np.median(others))
        row["ratios"] = [float(ratio) for ratio in times / others]
        row["time_ratio"] = float(np.median(times / others))
    return row
