"""Where the feet of a retargeted body should be: the source's paths, and still while planted."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.timing.easing import smoothstep

_GAP_S = 0.1
"""Feet that leave the floor for no longer do not leave it."""
_HOLD_M = 0.03
"""An adult's planted foot that strays farther from its middle is meant to slide or turn."""


def held_still(
    path: Float[np.ndarray, "F 3"],
    planted: Bool[np.ndarray, " F"],
    frame_rate: float,
    scale: float = 1.0,
) -> Float[np.ndarray, "F 3"]:
    """The path of a foot that stays at the middle of each plant.

    Heights stay. Between plants the shift from the path is eased from that of the one to that of
    the next; before the first and after the last it stays. The foot keeps sliding in a plant in
    which it gets farther from its middle than 3 cm, times the ``scale`` of the body.
    """
    starts, stops = _runs(planted)
    if not starts.size:
        return path
    gaps = starts[1:] - stops[:-1] > _GAP_S * frame_rate
    starts, stops = starts[np.append(True, gaps)], stops[np.append(gaps, True)]
    frames = np.arange(len(path))
    run = np.searchsorted(starts, frames, side="right") - 1
    inside = (run >= 0) & (frames < stops[run])
    floor = path[:, ::2]
    members = run[inside]
    counts = np.bincount(members, minlength=len(starts))
    sums = [np.bincount(members, floor[inside, k], minlength=len(starts)) for k in (0, 1)]
    middle = np.stack(sums, axis=-1) / counts[:, None]
    away = np.linalg.norm(floor[inside] - middle[members], axis=-1)
    farthest = np.zeros(len(starts))
    np.maximum.at(farthest, members, away)
    held = inside & (farthest[run] <= scale * _HOLD_M)
    shift = np.where(held[:, None], middle[run] - floor, 0.0)
    known = np.flatnonzero(inside)
    before = known[np.maximum(np.searchsorted(known, frames, side="right") - 1, 0)]
    after = known[np.minimum(np.searchsorted(known, frames), len(known) - 1)]
    share = np.clip((frames - before) / np.maximum(after - before, 1), 0.0, 1.0)
    eased = np.asarray(smoothstep(share))[:, None]
    result = path.copy()
    result[:, ::2] += shift[before] * (1 - eased) + shift[after] * eased
    return result


def _runs(planted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First frames of the runs of planted ones, and the frames after their last."""
    edges = np.diff(np.concatenate([[False], planted, [False]]).astype(np.int8))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
