"""Figures of the experiment on the smooth time warp."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

LINEAR, SMOOTH = "#c0392b", "#2a7f4f"


def profiles_figure(rows: list[dict[str, Any]]) -> Figure:
    """Playback speed over time, of some walks in both forms."""
    columns = min(max(len(rows), 1), 3)
    lines = max(-(-len(rows) // columns), 1)
    figure = Figure(figsize=(3.6 * columns + 0.6, 2.3 * lines + 1.0), layout="constrained")
    grid = figure.subplots(lines, columns, sharex=True, squeeze=False).flat
    for axes, row in zip(grid, rows, strict=False):
        times = np.arange(-0.1, row["until"], 1 / 960)
        for timing, colour, name in zip(
            row["timings"], (LINEAR, SMOOTH), ("one speed per edge", "smooth"), strict=True
        ):
            axes.plot(times, timing.speed(times), color=colour, label=name, linewidth=1.6)
        axes.axvline(row["t_avoid"], color="#9aa0a6", linestyle=":", label="middle of the part")
        axes.set_title(
            f"at most {row['linear_change']:.0f}/s, smooth {row['smooth_change']:.2f}/s", fontsize=9
        )
        axes.set_ylim(bottom=0)
        axes.grid(alpha=0.3)
    for axes in list(grid)[len(rows) :]:
        axes.set_visible(False)
    if rows:
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3, fontsize=9)
    figure.supxlabel("s from now", fontsize=9)
    figure.supylabel("playback speed", fontsize=9)
    return figure


def changes_figure(rows: dict[str, list[dict[str, Any]]]) -> Figure:
    """Largest change of speed of each avoided ball, both forms, over what share has less."""
    figure = Figure(figsize=(6.5, 4.2), layout="constrained")
    axes = figure.subplots()
    styles = ("-", "--", ":", "-.", (0, (1, 3)))
    for i, (name, found) in enumerate(rows.items()):
        moved = [row for row in found if row["avoided"] and row["scaled"]]
        share = 100 * np.arange(1, len(moved) + 1) / max(len(moved), 1)
        for form, colour in (("smooth", SMOOTH), ("linear", LINEAR)):
            values = np.sort([max(row[f"{form}_change"], 1e-3) for row in moved])
            axes.plot(
                values,
                share,
                color=colour,
                linestyle=styles[i % len(styles)],
                label=f"{'smooth' if form == 'smooth' else 'one speed per edge'}, {name}",
            )
    axes.set_xscale("log")
    axes.set(
        xlabel="largest change of playback speed, per second",
        ylabel="share of avoided balls with at most that, %",
        ylim=(0, 100),
    )
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=7)
    return figure
