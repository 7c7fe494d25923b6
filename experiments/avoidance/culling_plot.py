"""Figures of the experiment on culling."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mgjax.avoidance.culling.pictures import Slices, unpack
from mgjax.avoidance.culling.rasterise import LAYER_M, LAYERS, PIXEL_M

COLOURS = {"paper": "#c0392b", "binned": "#2a7f4f", "none": "#9aa0a6"}
NAMES = {"paper": "whole edges (paper)", "binned": "0.1 s of motion", "none": "no culling"}


def errors_figure(errors: dict[str, list[dict[str, Any]]], thresholds: dict[Any, int]) -> Figure:
    """False culls and false keeps over the threshold, and one over the other."""
    figure = Figure(figsize=(11, 4.5), layout="constrained")
    over, against = figure.subplots(1, 2)
    for form, rows in errors.items():
        culls, keeps = (
            np.array([np.nan if row[key] is None else 100 * row[key] for row in rows])
            for key in ("false_culls", "false_keeps")
        )
        x = [row["threshold"] for row in rows]
        colour, name = COLOURS[form], NAMES[form]
        over.plot(x, culls, marker="o", markersize=4, color=colour, label=f"{name}: false culls")
        over.plot(
            x, keeps, "--", marker="s", markersize=4, color=colour, label=f"{name}: false keeps"
        )
        against.plot(keeps, culls, marker="o", markersize=4, color=colour, label=name)
        for row, keep, lost in zip(rows, keeps, culls, strict=True):
            if row["threshold"] == thresholds[form]:
                against.annotate(
                    f"{row['threshold']} pixels",
                    (keep, lost),
                    textcoords="offset points",
                    xytext=(8, 6),
                    color=colour,
                )
                against.plot(keep, lost, "o", markersize=9, fillstyle="none", color=colour)
    over.set_xscale("symlog", linthresh=4)
    over.set_xticks(ticks := [0, 2, 4, 8, 16, 32, 64, 128, 256], [str(t) for t in ticks])
    over.set(xlabel="kept up to, pixels of 4 cm in layers of 25 cm", ylabel="%", ylim=(0, 100))
    against.set(
        xlabel="false keeps, % of those hit",
        ylabel="false culls, % of those clear",
        xlim=(0, 100),
        ylim=(0, 100),
    )
    for axes in (over, against):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    return figure


def times_figure(rows: list[dict[str, Any]]) -> Figure:
    """Culling and searching with each form, by number of candidates."""
    figure = Figure(figsize=(2.5 + 2.2 * len(rows), 4.5), layout="constrained")
    for axes, row in zip(figure.subplots(1, len(rows), squeeze=False)[0], rows, strict=True):
        names = list(NAMES)[::-1]
        timing = np.array([0.0 if name == "none" else row["timing_ms"] for name in names])
        culls = np.array([0.0 if name == "none" else row[name]["cull_ms"] for name in names])
        after = [row["search_ms"] if name == "none" else row[name]["search_ms"] for name in names]
        colours = [COLOURS[name] for name in names]
        axes.bar(names, timing, color=colours, alpha=0.25)
        axes.bar(names, culls, bottom=timing, color=colours, alpha=0.45, hatch="//")
        axes.bar(names, after, bottom=timing + culls, color=colours)
        count = f"{row['balls']} ball{'s' if row['balls'] > 1 else ''}"
        axes.set_title(f"{row['least']} … {row['most']} candidates\n({count})", fontsize=9)
        axes.grid(axis="y", alpha=0.3)
    figure.supylabel("ms per ball, median (from below: timing, culling, search)", fontsize=9)
    return figure


def slices_figure(slices: Slices, edge: int) -> Figure:
    """The nine layers of one edge from above: the whole edge, and on top one of its bins."""
    columns, rows = (int(n) for n in slices.paper.size[edge])
    figure = Figure(figsize=(9, 1.5 + 8.5 * rows / columns), layout="constrained")
    shown = int(slices.first_bin[edge]) + int(slices.bins[edge]) // 2
    whole, part = unpack(slices.paper, edge), unpack(slices.binned, shown)
    offset = np.asarray(slices.binned.corner[shown]) - np.asarray(slices.paper.corner[edge])
    picture = whole.astype(np.int8)
    inner = [slice(o, o + n) for o, n in zip(offset[::-1], part.shape[1:], strict=True)]
    picture[:, inner[0], inner[1]] += part
    corner = np.asarray(slices.paper.corner[edge]) * PIXEL_M
    left, right = corner[0], corner[0] + PIXEL_M * whole.shape[2]
    low, high = corner[1], corner[1] + PIXEL_M * whole.shape[1]
    for layer, axes in zip(range(LAYERS)[::-1], figure.subplots(3, 3).flat, strict=True):
        axes.imshow(
            picture[layer],
            origin="lower",
            extent=(left, right, low, high),
            cmap="Blues",
            vmin=0,
            vmax=2,
            interpolation="nearest",
        )
        axes.set_title(f"{layer * LAYER_M:.2f} … {(layer + 1) * LAYER_M:.2f} m", fontsize=9)
        axes.tick_params(labelsize=7)
    seconds = float(slices.seconds[edge])
    figure.suptitle(
        f"Edge {edge}, {seconds:.2f} s: where the body is at any time, and (dark) in 0.1 s of it;"
        " x and z in m from the node it leaves",
        fontsize=10,
    )
    return figure
