"""Pictures of the matching: confusion matrices, success over disturbances, link transitions."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mgjax.ballsport.config import KINDS

CLASSES = tuple(f"{kind} {side}" for kind in KINDS for side in ("L", "R"))
WAYS = {
    "with_speed_same_foot": "foot from the analysis",
    "with_speed_any_foot": "D_m over all hits",
    "way_only_same_foot": "foot from the analysis, displacements only",
}


def confusion_figure(conditions: dict[str, Any]) -> Figure:
    """Matrices of the undisturbed hits, and what disturbances do."""
    figure = Figure(figsize=(14, 10), layout="constrained")
    upper, lower = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.2, 1))[:, 0]
    plain = conditions["as captured"]
    for axes, (comparison, title) in zip(upper.subplots(1, 3), WAYS.items(), strict=True):
        _matrix(axes, np.asarray(plain[comparison]["confusion"]))
        axes.set_title(
            f"{title}:\nkind right {100 * plain[comparison]['kind_right']:.1f} %", fontsize=9
        )
    axes = lower.subplots()
    place = np.arange(len(conditions))
    colours = ("#2a7f4f", "#1f6fb4", "#d8a31a")
    for number, ((comparison, title), colour) in enumerate(zip(WAYS.items(), colours, strict=True)):
        values = [100 * row[comparison]["kind_right"] for row in conditions.values()]
        axes.bar(place + 0.2 * (number - 1.5), values, 0.2, color=colour, label=f"kind, {title}")
    feet = [100 * row["foot_right_by_analysis"] for row in conditions.values()]
    axes.bar(place + 0.3, feet, 0.2, color="#9aa0a6", label="foot, by the analysis")
    axes.axhline(90, color="#c0392b", linewidth=0.8, linestyle=":")
    axes.set_xticks(place, [re.sub(r", | of ", "\n", name) for name in conditions], fontsize=8)
    axes.set(ylim=(0, 105), ylabel="right, %")
    axes.legend(loc="lower left", fontsize=8, ncols=2)
    return figure


def _matrix(axes: Axes, counts: np.ndarray) -> None:
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axes.imshow(share, cmap="Blues", vmin=0, vmax=1)
    for i, j in np.ndindex(*counts.shape):
        if counts[i, j]:
            colour = "white" if share[i, j] > 0.6 else "black"
            axes.text(j, i, str(counts[i, j]), ha="center", va="center", fontsize=9, color=colour)
    ticks = range(len(CLASSES))
    axes.set_xticks(ticks, list(CLASSES), rotation=40, fontsize=8)
    axes.set_yticks(ticks, list(CLASSES), fontsize=8)
    axes.set_xlabel("stored hit that is nearest", fontsize=8)
    axes.set_ylabel("hit", fontsize=8)


def transition_figure(distance: np.ndarray) -> Figure:
    """D_p per frame at the best section of every pair of link motions."""
    figure = Figure(figsize=(7, 6), layout="constrained")
    axes = figure.subplots()
    shown = np.where(np.isfinite(distance), distance, np.nan)
    image = axes.imshow(shown, cmap="viridis_r", vmin=0)
    figure.colorbar(image, label="D_p per frame at the best section")
    axes.set(xlabel="link motion that is entered", ylabel="link motion that is left")
    return figure
