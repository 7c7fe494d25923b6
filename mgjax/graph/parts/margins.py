"""Where transitions may be: not in the midst of a labelled part."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int


def label_margins(
    positions: Float[np.ndarray, "F J 3"],
    frames: Int[np.ndarray, "P 2"],
    *,
    quiet: float,
    overlap: float,
) -> Int[np.ndarray, "P 2"]:
    """How many frames at the two ends of each label blends may overlap.

    Args:
        positions: joints of all clips, m.
        frames: start and stop of each label.
        quiet: share of a label's own peak speed (of any joint); an end at which all joints are
            slower belongs to the margin. 0 for none.
        overlap: share of the label's length that belongs to the margin at either end anyway.

    Returns:
        Frames at the beginning and at the end, always fewer than half the label each.
    """
    margins = np.zeros((len(frames), 2), dtype=np.int64)
    for number, (start, stop) in enumerate(frames.tolist()):
        length = stop - start
        ends = np.full(2, int(overlap * length + 1e-9))
        steps = np.diff(positions[start:stop], axis=0)
        speed = np.linalg.norm(steps, axis=-1).max(axis=-1, initial=0.0)
        moving = np.flatnonzero(speed >= quiet * speed.max(initial=0.0))
        if quiet > 0 and len(moving):
            ends = np.maximum(ends, [moving[0], len(speed) - 1 - moving[-1]])
        margins[number] = np.minimum(ends, (length - 1) // 2)
    return margins


def allowed_windows(
    starts: Int[np.ndarray, " K"],
    stops: Int[np.ndarray, " K"],
    core_starts: Int[np.ndarray, " P"],
    core_stops: Int[np.ndarray, " P"],
    window: int,
) -> tuple[Bool[np.ndarray, " F"], Bool[np.ndarray, " F"]]:
    """At which frames a window may begin that a transition leaves, and one that it arrives in.

    A window lies in its clip, with a frame before the one and a frame after the other, and has no
    frame of the core of a label.

    Args:
        starts, stops: of the clips, one after another on the axis of frames.
        core_starts, core_stops: of what no blend may touch.
        window: frames in a window.
    """
    total = int(stops.max(initial=0))
    frames = np.arange(total)
    clip = np.searchsorted(starts, frames, side="right") - 1
    change = np.zeros(total + 1, dtype=np.int64)
    np.add.at(change, core_starts, 1)
    np.add.at(change, core_stops, -1)
    taken = np.concatenate([[0], np.cumsum(np.cumsum(change[:-1]) > 0)])
    ends = frames + window
    free = (ends <= stops[clip]) & (taken[np.minimum(ends, total)] == taken[frames])
    return free & (frames > starts[clip]), free & (ends < stops[clip])
