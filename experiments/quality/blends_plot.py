"""Figures of the comparison of blends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

MOMENTS = 9


def measures_figure(rows: Sequence[dict[str, Any]], measures: Sequence[str]) -> Figure:
    """Median and 95th percentile of each measure under each blend; dotted: uncut capture."""
    figure = Figure(figsize=(3.4 * len(measures), 0.42 * len(rows) + 1.4), layout="constrained")
    grid = figure.subplots(1, len(measures), sharey=True, squeeze=False)[0]
    names = [row["name"] for row in rows]
    for axes, key in zip(grid, measures, strict=True):
        middle, high = np.array([row[f"{key}_p50_p95"] for row in rows]).T
        axes.barh(names, high, color="#c9d6df")
        axes.barh(names, middle, color="#2a7f4f", height=0.4)
        for value in rows[0][f"{key}_uncut_p50_p95"]:
            axes.axvline(value, color="#c0392b", linestyle=":", linewidth=1)
        axes.set_title(key, fontsize=10)
        axes.grid(alpha=0.3, axis="x")
    grid[0].invert_yaxis()
    return figure


def strips_figure(
    parents: Sequence[int], strips: Sequence[tuple[str, np.ndarray, np.ndarray]]
) -> Figure:
    """Stick figures of seams under two blends, one above the other, and the paths of both toes.

    ``strips``: a title, and the joints of the same seam under both. [F, J, 3]
    """
    figure = Figure(figsize=(16, 2.6 * len(strips)), layout="constrained")
    grid = figure.subplots(len(strips), 2, squeeze=False, sharex="row", sharey="row")
    for line, (title, before, after) in zip(grid, strips, strict=True):
        for axes, places, name in zip(line, (before, after), ("before", "after"), strict=True):
            moments = np.linspace(0, len(places) - 1, MOMENTS).round().astype(int)
            for slot, frame in enumerate(moments):
                pose = places[frame] - places[0, 0] * [1, 0, 1]
                for joint, parent in enumerate(parents):
                    if parent >= 0:
                        ends = pose[[parent, joint]]
                        shade = "#c0392b" if 0 < slot < MOMENTS - 1 else "#555555"
                        axes.plot(ends[:, 0] + 0.9 * slot, ends[:, 1], color=shade, linewidth=1.2)
            axes.axhline(0, color="#999999", linewidth=0.6)
            axes.set_aspect("equal")
            axes.set_title(f"{name}: {title}", fontsize=8)
            axes.set_axis_off()
    return figure
