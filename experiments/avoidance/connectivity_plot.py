"""Pictures of what connects a graph better: what is avoided over what feet do for it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

SKATES, SPEED = 0.005, 1.1
"""Goals of G1: share of frames that skate, and speed of toes in contact beside uncut motion."""
ALONE, DEFAULT = "#0072B2", "#D55E00"
"""Options by themselves, and with the defaults; told apart by people who see colours differently,
and by their markers."""
_AWAY = 9, 13, 20, 28, 38, 50
"""How far from its point a label may be, in points of the page."""
_WAYS = 24


def figure(rows: list[dict[str, Any]]) -> Figure:
    """Avoidable cells (C2), and balls avoided, over what feet slide in seams (G1), by option.

    The points of an option are its thresholds; the dotted line is uncut motion at the same places.
    """
    drawn = Figure(figsize=(11, 4.8), layout="constrained")
    left, right = drawn.subplots(1, 2)
    for number, name in enumerate(dict.fromkeys(row["option"] for row in rows)):
        own = [row for row in rows if row["option"] == name]
        slides = [row["seams"]["skate_cm"] for row in own]
        cells = [100 * row["connectivity"]["avoidable_cells"] for row in own]
        soonest = [100 * next(iter(row["avoided"].values()))["share"] for row in own]
        style: dict[str, Any] = {"marker": "o", "color": f"C{number % 10}", "label": name}
        left.plot(slides, cells, **style)
        right.plot(slides, soonest, **style)
        for x, y, row in zip(slides, cells, own, strict=True):
            left.annotate(f"{row['built_below_m']:.2f}", (x, y), fontsize=7)
    left.set(ylabel="cells avoided from 90 % of the nodes, %", ylim=(0, 100))
    right.set(ylabel="standard balls avoided, %", ylim=(0, 100))
    for axes in (left, right):
        axes.set_xlabel("feet slide in seams (skate_cm), cm a frame")
        axes.axvline(min(row["seams"]["skate_cm_uncut"] for row in rows), color="k", ls=":")
        axes.grid(alpha=0.3)
    right.legend(frameon=False, fontsize=8)
    return drawn


def price_figure(rows: list[dict[str, Any]]) -> Figure:
    """Avoidable cells (C2) over the speed of toes in contact and over skating (G1), each labelled.

    A line goes from the lowest threshold of an option, which is filled and labelled, to its others.
    What is left of the dotted line is within the goal.
    """
    drawn = Figure(figsize=(13, 6.4), layout="constrained")
    left, right = drawn.subplots(1, 2, sharey=True)
    speeds = [x["seams"]["contact_speed"] / x["seams"]["contact_speed_uncut"] for x in rows]
    skates = [100 * row["seams"]["skate_ratio"] for row in rows]
    cells = [100 * row["connectivity"]["avoidable_cells"] for row in rows]
    left.axvline(SPEED, color="0.3", ls=":")
    right.axvline(100 * SKATES, color="0.3", ls=":")
    left.set(
        xlabel="speed of toes in contact at seams, times that of uncut motion",
        ylabel="C2: cells avoided from 90 % of the nodes, %",
    )
    right.set_xlabel("frames of seams in which feet skate, %")
    for axes, places in ((left, speeds), (right, skates)):
        _points(axes, rows, np.array(places), np.array(cells))
        axes.grid(alpha=0.25)
        axes.margins(0.08)
    first = [rows[own[0]]["built_below_m"] for own in _firsts(rows).values()]
    drawn.suptitle(
        f"Filled and named: the lowest threshold of each option ({min(first):.2f}–{max(first):.2f}"
        " m); open: its others. Dotted: the goal is to the left of it",
        fontsize=10,
    )
    drawn.draw_without_rendering()  # puts the axes in place; labels need to know where points are
    for axes, places in ((left, speeds), (right, skates)):
        _labels(axes, rows, np.array(places), np.array(cells))
    return drawn


def _firsts(rows: list[dict[str, Any]]) -> dict[str, list[int]]:
    """Rows of each option, that of its lowest threshold first."""
    found: dict[str, list[int]] = {}
    for number, row in enumerate(rows):
        found.setdefault(row["option"], []).append(number)
    return {
        name: sorted(own, key=lambda i: rows[i]["built_below_m"]) for name, own in found.items()
    }


def _colour(name: str) -> str:
    return DEFAULT if name.startswith("default") else ALONE


def _points(axes: Axes, rows: list[dict[str, Any]], x: np.ndarray, y: np.ndarray) -> None:
    for name, own in _firsts(rows).items():
        colour, marker = _colour(name), "s" if name.startswith("default") else "o"
        axes.plot(x[own], y[own], color=colour, lw=0.8, alpha=0.35)
        axes.plot(x[own[1:]], y[own[1:]], marker, color=colour, mfc="white", ms=5)
        axes.plot(x[own[:1]], y[own[:1]], marker, color=colour, ms=7)


def _labels(axes: Axes, rows: list[dict[str, Any]], x: np.ndarray, y: np.ndarray) -> None:
    """Names beside the first point of each option, where they cover no point and no other name."""
    points = axes.transData.transform(np.stack([x, y], axis=1))
    taken = [Bbox.from_bounds(px - 6, py - 6, 12, 12) for px, py in points.tolist()]
    inside = axes.get_window_extent()
    scale = axes.figure.dpi / 72
    for name, own in _firsts(rows).items():
        text = axes.annotate(
            name,
            (float(x[own[0]]), float(y[own[0]])),
            xytext=(0, 0),
            textcoords="offset points",
            fontsize=8,
            color=_colour(name),
            ha="center",
            va="center",
            bbox={"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.75},
            arrowprops={"arrowstyle": "-", "color": "0.6", "lw": 0.6, "shrinkB": 4},
        )
        text.set_in_layout(False)
        size = text.get_window_extent()
        width, height = size.width + 2 * scale, size.height
        best: tuple[float, tuple[float, float], Bbox] | None = None
        for away in _AWAY:
            for way in np.linspace(0, 2 * np.pi, _WAYS, endpoint=False).tolist():
                dx = float(np.cos(way)) * (away * scale + 0.5 * width)
                dy = float(np.sin(way)) * (away * scale + 0.5 * height)
                px, py = (points[own[0]] + [dx, dy]).tolist()
                box = Bbox.from_bounds(px - 0.5 * width, py - 0.5 * height, width, height)
                cover = sum(_shared(box, other) for other in taken)
                cover += width * height - _shared(box, inside) + 0.05 * away
                if best is None or cover < best[0]:
                    best = cover, (dx / scale, dy / scale), box
        assert best is not None
        text.set_position(best[1])
        taken.append(best[2])


def _shared(one: Bbox, other: Bbox) -> float:
    """Area that two boxes share."""
    both = Bbox.intersection(one, other)
    return 0.0 if both is None else float(both.width * both.height)
