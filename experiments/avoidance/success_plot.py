"""Figures of the experiment on success."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.avoidance.throws import OUTCOMES

LABELS = {
    "speed": "speed of the ball, m/s",
    "height": "height at the body's axis, m",
    "arrival": "arrives in, s",
    "direction": "comes from, degrees from ahead towards the left",
}
COLOURS = ("#2a7f4f", "#c0392b", "#9aa0a6", "#d8a31a", "#5b8db8", "#333333", "#8e44ad")


def _share(axes: Axes, x: Any, rows: list[dict[str, Any]], colour: str, **more: Any) -> None:
    """Share avoided with its 95 % interval."""
    known = [(at, row) for at, row in zip(x, rows, strict=True) if row["avoided"] is not None]
    if not known:
        return
    places = [at for at, _ in known]
    low, high = np.transpose([row["avoided_interval"] for _, row in known])
    axes.fill_between(places, 100 * low, 100 * high, color=colour, alpha=0.15, linewidth=0)
    axes.plot(places, [100 * row["avoided"] for _, row in known], marker="o", color=colour, **more)


def conditions_figure(metrics: dict[str, Any]) -> Figure:
    """Share avoided over each condition, the others standard."""
    figure = Figure(figsize=(10, 7), layout="constrained")
    figure.suptitle("Balls avoided, % (band: 95 % interval)")
    for axes, (name, label) in zip(figure.subplots(2, 2).flat, LABELS.items(), strict=True):
        rows = metrics[name]
        _share(axes, [row[name] for row in rows], rows, COLOURS[0])
        axes.set(xlabel=label, ylim=(0, 100))
        axes.grid(alpha=0.3)
        if name == "direction":
            axes.set_xticks(np.arange(0, 361, 90))
    return figure


def failures_figure(metrics: dict[str, Any]) -> Figure:
    """What became of the standard balls, by time scaling and by kind of part."""
    rows = dict(metrics["scaling"])
    rows |= {f"only {kind}": row for kind, row in metrics["kinds"].items()}
    if metrics["embedded"]:
        rows["embedded clips"] = metrics["embedded"]["all"]
    rows = {name: row for name, row in rows.items() if row["avoided"] is not None}
    figure = Figure(figsize=(10, 1.5 + 0.35 * len(rows)), layout="constrained")
    axes = figure.subplots()
    left = np.zeros(len(rows))
    names = list(rows)[::-1]
    for outcome, colour in zip(OUTCOMES, COLOURS, strict=True):
        width = np.array([100 * rows[name][outcome] for name in names])
        label = outcome.replace("_", " ")
        axes.barh(names, width, left=left, color=colour, label=label)
        left += width
    axes.set(xlim=(0, 100), xlabel="standard balls, %")
    figure.legend(loc="outside upper center", ncols=len(OUTCOMES), frameon=False)
    return figure


def threshold_figure(rows: list[dict[str, Any]]) -> Figure:
    """Success over the threshold of the graph, with the quality of its transitions beside it."""
    figure = Figure(figsize=(11, 4.5), layout="constrained")
    success, quality = figure.subplots(1, 2)
    for mirrored, line in ((False, "-"), (True, "--")):
        part = [row for row in rows if row["mirrored"] == mirrored]
        if not part:
            continue
        x = [row["threshold_m"] for row in part]
        more = ", mirrored" if mirrored else ""
        for key, colour in (("all", COLOURS[0]), ("genuine", COLOURS[4])):
            shares = [row[key] for row in part]
            _share(success, x, shares, colour, linestyle=line, label=f"{key} parts{more}")
        change = [row["speed_change_m_s_p50_p95_max"][1] for row in part]
        slide = [1000 * row["foot_slide_after"] for row in part]
        quality.plot(x, change, f"o{line}", color=COLOURS[1], label=f"velocity change, p95{more}")
        quality.plot(x, slide, f"s{line}", color=COLOURS[3], label=f"foot slide{more}")
    captured = rows[0]["captured_speed_change_m_s_p50_p95_max"][1]
    quality.axhline(
        captured, color=COLOURS[2], linestyle=":", label="velocity change, captured, p95"
    )
    success.set(xlabel="threshold, m", ylabel="balls avoided, %", ylim=(0, 100))
    quality.set(
        xlabel="threshold, m",
        ylabel="m/s per frame; mm per transition frame",
        ylim=(0, None),
        title="transitions",
    )
    for axes in (success, quality):
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3)
    return figure
