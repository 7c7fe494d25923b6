"""Figures of the experiment on aiming."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

CHOSEN, ADJUSTED, BONE, CANDIDATE = "#1f6fb4", "#c0392b", "#17a2a2", "#9aa0a6"


def success_figure(
    rows: dict[int, dict[str, Any]], distances: Sequence[float], heights: Sequence[float]
) -> Figure:
    """Share met and the median kick speed, over distance and height, for each number of bounces."""
    figure = Figure(figsize=(13, 6.4), layout="constrained")
    figure.suptitle(
        "Passes met within 0.1 mm with just the wanted bounces, %; below: median kick speed, m/s"
    )
    grid = figure.subplots(2, len(rows), squeeze=False)
    top = max(float(row["median_speed_m_s"].max()) for row in rows.values())
    for column, (bounces, row) in enumerate(rows.items()):
        panels = (
            (grid[0, column], 100 * row["share_met"], 100.0, "Greens", "{:.0f}"),
            (grid[1, column], row["median_speed_m_s"], top, "viridis", "{:.1f}"),
        )
        for axes, values, most, colours, form in panels:
            axes.imshow(values, vmin=0, vmax=most, cmap=colours, aspect="auto", origin="lower")
            for (i, j), value in np.ndenumerate(values):
                dark = value < 0.7 * most or colours == "Greens"
                text = {"ha": "center", "va": "center", "color": "white" if dark else "black"}
                axes.text(j, i, form.format(value), fontsize=9, **text)
            axes.set_xticks(range(len(distances)), [f"{d:g}" for d in distances])
            axes.set_yticks(range(len(heights)), [f"{h:g}" for h in heights])
            axes.set(title=f"{bounces} bounces", xlabel="distance, m", ylabel="target's height, m")
    return figure


def convergence_figure(curves: dict[int, dict[str, np.ndarray]]) -> Figure:
    """Miss over the differential updates, from the scanned guess and from the bone's velocity."""
    figure = Figure(figsize=(13, 4.6), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(curves), sharey=True))
    for axes, (bounces, row) in zip(panels, curves.items(), strict=True):
        for name, colour in (("bone", CANDIDATE), ("scan", ADJUSTED)):
            _curves(axes, row[name], colour, name)
        axes.axhline(0.1, color="black", linewidth=0.8, linestyle=":")
        axes.set(title=f"{bounces} bounces", xlabel="differential updates", yscale="log")
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize=8)
    figure.suptitle("Dotted: met. Flights with other bounces than wanted count as 100 m off.")
    panels[0].set(ylabel="miss, mm (median; band: 5 … 95 %)", ylim=(1e-5, 1e5))
    return figure


def _curves(axes: Axes, misses: np.ndarray, colour: str, name: str) -> None:
    steps = np.arange(misses.shape[1])
    # A flight with other bounces has no miss; it counts as the worst there is.
    low, middle, high = np.percentile(
        np.clip(1e3 * misses, 1e-5, 1e5), [5, 50, 95], axis=0, method="nearest"
    )
    met = np.mean(misses[:, -1] < 1e-4)
    label = {"bone": "from the bone's velocity", "scan": "from the scan"}[name]
    axes.fill_between(steps, low, high, color=colour, alpha=0.2, linewidth=0)
    axes.plot(steps, middle, marker="o", color=colour, label=f"{label}: {met:.1%} met")


def frames_figure(found: dict[str, Any]) -> Figure:
    """The curves of all frames of a hit motion, the chosen one and the adjusted one (Fig. 6)."""
    figure = Figure(figsize=(12, 7), layout="constrained")
    side, above = figure.subplots(2, 1, height_ratios=(3, 2))
    for axes, (i, j) in ((side, (2, 1)), (above, (2, 0))):
        for curve in found["curves"]:
            axes.plot(curve[:, i], curve[:, j], color=CANDIDATE, linewidth=0.6)
        feet, speeds = found["feet"], found["speeds"]
        ends = feet + 0.06 * speeds
        for foot, end in zip(feet, ends, strict=True):
            axes.plot([foot[i], end[i]], [foot[j], end[j]], color=BONE, linewidth=0.8)
        axes.scatter(feet[:, i], feet[:, j], s=10, color=BONE, zorder=3, label="hit bone")
        for name, colour in (("chosen", CHOSEN), ("adjusted", ADJUSTED)):
            curve = found[f"{name}_curve"]
            axes.plot(curve[:, i], curve[:, j], color=colour, linewidth=2, label=name)
        target = found["target"]
        axes.scatter(target[i], target[j], marker="x", color="black", zorder=4, label="target")
        axes.set(xlim=(-1, 1.3 * target[2]), xlabel="z, m")
        axes.grid(alpha=0.3)
    side.axhline(0.0, color="black", linewidth=1)
    side.set(ylabel="height, m", ylim=(0, None))
    above.set(ylabel="x, m")
    side.legend(frameon=False, ncols=4)
    side.set_title(
        f"Frame {found['chosen']} of {len(feet)}: its own flight passes"
        f" {100 * found['distance_before_m']:.1f} cm from the target, adjusted"
        f" {found['miss_after_mm']:.3f} mm; one bounce, {found['flight_s']:.2f} s"
    )
    return figure
