"""Figures of the sweep over settings."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

COLOURS = ("#2a7f4f", "#5b8db8")
SATURATED = {
    "avoidance_0": ("e_avoidance = 0", "#2a7f4f"),
    "avoidance_1": ("e_avoidance = 1", "#c0392b"),
    "body_1": ("e_body = 1", "#d8a31a"),
}
LINES = {
    "E_avoidance": ("E_avoidance, m·s\n(overlap)", {"E_avoidance": ""}),
    "E_paper": (
        "E_avoidance, m·s\n(paper's form)",
        {
            "E_avoidance, paper form": "clamped d0",
            "E_avoidance, paper form and d0": "literal d0",
        },
    ),
    "D_body": ("D_body, m", {"D_body": "clamped d0", "D_body, literal d0": "literal d0"}),
    "w_a": ("w_a", {"w_a": ""}),
    "w_b": ("w_b", {"w_b": ""}),
    "w_m": ("w_m", {"w_m": ""}),
    "w_t": ("w_t", {"w_t": ""}),
    "w_speed_up": ("w_speed_up", {"w_speed_up": ""}),
    "E_time": ("E_time", {"E_time": "limits", "E_time, no limit": "does not limit"}),
    "T_window": ("T_window, s", {"T_window": ""}),
    "crop_radius_m": ("radius of the crop, m", {"crop_radius_m": ""}),
    "speed": ("V thresholds", {"speed": ""}),
    "forms": ("form of the energies", {"forms": ""}),
}
"""Rows of the figure: what is varied, and the series that are drawn in it."""
TITLES = (
    "avoided, % (band: 95 % interval)",
    "clearance, cm (p5, median, p95)",
    "time scale, larger of s and 1/s (median, p95)",
    "another walk than the default's, %",
    "saturated: chosen (●), candidates (×), %",
)


def sweep_figure(metrics: dict[str, Any]) -> Figure:
    """Each setting's effect on success, clearance, time scale, choice and saturation.

    Dotted verticals are the defaults.
    """
    figure = Figure(figsize=(17, 2.0 * len(LINES)), layout="constrained")
    grid = figure.subplots(len(LINES), len(TITLES), sharey="col")
    for line, (label, series) in zip(grid, LINES.values(), strict=True):
        for (name, kind), colour in zip(series.items(), COLOURS, strict=False):
            _series(line, metrics[name], kind, colour, first=colour == COLOURS[0])
        values = [row["value"] for row in metrics[next(iter(series))]]
        for axes in line:
            words = isinstance(values[0], str)
            ticks = [x.replace(", ", ",\n") if words else f"{x:g}" for x in values]
            axes.set_xticks(range(len(values)), ticks, fontsize=7 if words else 8)
            axes.set_xlim(-0.4, len(values) - 0.6)
            axes.grid(alpha=0.3)
            if (usual := metrics["default_values"].get(next(iter(series)))) in values:
                axes.axvline(values.index(usual), color="#333333", linewidth=0.8, linestyle=":")
        line[0].set_ylabel(label, fontweight="bold")
        if len(series) > 1:
            line[0].legend(fontsize=7, frameon=False)
    for axes, title in zip(grid[0], TITLES, strict=True):
        axes.set_title(title, fontsize=10)
    for column in (0, 3, 4):
        grid[0, column].set_ylim(0, 100)
    grid[0, 1].set_yscale("log")
    grid[0, 1].set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    grid[0, 2].set_ylim(1, None)
    handles = [grid[0, 4].plot([], [], color=c, label=label)[0] for label, c in SATURATED.values()]
    grid[0, 4].legend(handles=handles, fontsize=7, frameon=False)
    return figure


def _series(line: Any, rows: list[dict[str, Any]], kind: str, colour: str, *, first: bool) -> None:
    """One series in the five columns; saturation only of the first."""
    success, clearance, scale, choice, saturation = line
    x = np.arange(len(rows))
    words = isinstance(rows[0]["value"], str)
    style = {"color": colour, "marker": "o", "markersize": 4, "linestyle": "none" if words else "-"}
    low, high = 100 * np.transpose([row["avoided_interval"] for row in rows])
    avoided = 100 * np.array([row["avoided"] for row in rows])
    _band(success, x, low, high, colour, words)
    success.plot(x, avoided, label=kind, **style)
    for axes, key, factor in (
        (clearance, "clearance_m_p5_p50_p95", 100),
        (scale, "scaling_p50_p95", 1),
    ):
        blank = [np.nan] * (3 if factor == 100 else 2)
        values = factor * np.array([row[key] or blank for row in rows], dtype=np.float64).T
        middle = values[1] if factor == 100 else values[0]
        _band(axes, x, values[0], values[-1], colour, words)
        axes.plot(x, middle, **style)
    choice.plot(x, [100 * row["changed"] for row in rows], **style)
    if not first:
        return
    for which, dots in (("saturated_chosen", "-"), ("saturated_candidates", ":")):
        for key, (_, shade) in SATURATED.items():
            shares = [100 * row[which][key] if row[which] else np.nan for row in rows]
            more = {"marker": "o" if dots == "-" else "x", "markersize": 4}
            saturation.plot(x, shares, linestyle="none" if words else dots, color=shade, **more)


def _band(
    axes: Axes, x: np.ndarray, low: np.ndarray, high: np.ndarray, colour: str, words: bool
) -> None:
    """A range: a band along a line, a bar at a word."""
    if words:
        axes.vlines(x, low, high, color=colour, alpha=0.3, linewidth=5)
    else:
        axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0)


def maps_figure(maps: dict[str, Any]) -> Figure:
    """Choice and clearance where two settings are varied together."""
    figure = Figure(figsize=(5.5 * len(maps), 8.5), layout="constrained")
    grid = figure.subplots(2, len(maps), squeeze=False)
    for column, tables in zip(grid.T, maps.values(), strict=True):
        (a, first), (b, second) = list(tables.items())[:2]
        for axes, key, digits, title in (
            (column[0], "changed", 0, "another walk than the default's, %"),
            (column[1], "clearance_m_p50", 1, "median clearance, cm"),
        ):
            values = 100 * np.array(tables[key], dtype=np.float64)
            image = axes.imshow(values, origin="lower", aspect="auto", cmap="viridis")
            axes.set_xticks(range(len(second)), [f"{x:g}" for x in second])
            axes.set_yticks(range(len(first)), [f"{x:g}" for x in first])
            axes.set(xlabel=b, ylabel=a, title=title)
            middle = (np.nanmin(values) + np.nanmax(values)) / 2
            for (i, j), value in np.ndenumerate(values):
                shade = "black" if value > middle else "white"
                axes.text(
                    j, i, f"{value:.{digits}f}", ha="center", va="center", color=shade, fontsize=8
                )
            figure.colorbar(image, ax=axes)
    return figure
