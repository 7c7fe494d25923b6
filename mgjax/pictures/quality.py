"""The measures of a motion over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mgjax.core.arrays import Array
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.quality.feet import CONTACT_M, SKATE_M_S
from mgjax.quality.kernel import Curves
from mgjax.quality.known import Captured
from mgjax.quality.measuring import beside_capture, curves_of
from mgjax.quality.smoothness import window_frames
from mgjax.quality.subject import subject_of
from mgjax.quality.tracks import RATE, SKATE_RATE

_LEFT, _RIGHT, _SEAM, _OTHER = "#2563eb", "#d97706", "#c0392b", "#111827"


def quality_picture(
    path: str | Path,
    skeleton: Skeleton,
    motion: Motion,
    *,
    against: Captured | None = None,
    seams: Sequence[tuple[float, float]] = (),
    title: str = "",
) -> None:
    """Draws feet, jerk, jumps and limits over time into a file; seams are red bands.

    Args:
        path: of the picture.
        skeleton: of the motion.
        motion: the motion.
        against: what capture does.
        seams: first and last second of each.
        title: over the picture.
    """
    found = curves_of(skeleton, motion, against)
    known = beside_capture(skeleton, motion, against)[2]
    scale = float(subject_of(skeleton)[0].scale)
    figure = Figure(figsize=(max(9.0, min(0.6 * motion.seconds, 24.0)), 10), layout="constrained")
    rows = figure.subplots(5, 1, sharex=True)
    figure.suptitle(title)
    _heights(rows[0], found.height, scale)
    _speeds(rows[1], found, scale)
    _line(rows[2], found.jump.max(axis=-1), 1 / RATE, _OTHER)
    rows[2].set_ylabel("velocity jump, m/s")
    jerk = found.jerk if known is None else found.jerk / known.extremes.jerk
    if jerk.size:
        _line(rows[3], jerk.max(axis=-1), window_frames(RATE) / 2 / RATE, _OTHER)
        rows[3].set_yscale("log")
    rows[3].set_ylabel("jerk of 0.4 s" if known is None else "jerk by the\ncapture's 99.9 %")
    if known is not None:
        rows[3].axhline(1.0, color=_SEAM, linestyle=":", linewidth=1)
    _line(rows[4], 100 * found.depth, 0.0, _OTHER, "limb in the body, cm")
    _line(
        rows[4], 100 * np.max(found.sink, axis=-1, initial=0.0), 0.0, _LEFT, "foot in the floor, cm"
    )
    if known is not None:
        outside = found.outside.max(axis=(-2, -1))
        _line(rows[4], outside, 0.0, _RIGHT, "beyond captured angles, °")
    rows[4].set_ylim(-0.1, max(1.0, rows[4].get_ylim()[1]))
    rows[4].legend(fontsize=7, loc="upper right")
    rows[4].set_xlabel("s")
    for axes in rows:
        axes.grid(alpha=0.3)
        axes.set_xlim(0, motion.seconds)
        for start, end in seams:
            axes.axvspan(start, end, color=_SEAM, alpha=0.12, linewidth=0)
    figure.savefig(path, dpi=90)


def _heights(axes: Axes, heights: Array, scale: float) -> None:
    """Of both toes, and of both ankles, thin."""
    for number in range(heights.shape[1]):
        side = ("left", "right")[number % 2]
        joint = "toe" if number < 2 else "ankle"
        _line(
            axes,
            100 * heights[:, number],
            0.0,
            (_LEFT, _RIGHT)[number % 2],
            f"{side} {joint}",
            1.4 if number < 2 else 0.7,
        )
    axes.axhline(100 * CONTACT_M * scale, color=_OTHER, linestyle=":", linewidth=1)
    axes.axhline(0, color=_OTHER, linewidth=0.8)
    axes.set_ylim(-3, 30)
    axes.set_ylabel("height, cm")
    if heights.shape[1]:
        axes.legend(fontsize=7, loc="upper right", ncols=2)


def _speeds(axes: Axes, found: Curves, scale: float) -> None:
    """Of toes in contact, and when a foot skates."""
    for side in range(found.toe_speed.shape[1]):
        speed = np.where(found.contact[:, side], found.toe_speed[:, side], np.nan)
        _line(axes, speed, 0.5 / RATE, (_LEFT, _RIGHT)[side])
    skates = np.flatnonzero(found.skates)
    axes.plot((skates + 0.5) / SKATE_RATE, np.zeros(len(skates)), "|", color=_SEAM, markersize=12)
    axes.axhline(SKATE_M_S * scale, color=_OTHER, linestyle=":", linewidth=1)
    axes.set_ylim(0, 2 * scale)
    axes.set_ylabel("toe in contact, m/s\n(red: skates)")


def _line(
    axes: Axes, values: Array, start: float, colour: str, label: str = "", width: float = 1.2
) -> None:
    axes.plot(start + np.arange(len(values)) / RATE, values, color=colour, linewidth=width,
              label=label or None)  # fmt: skip
