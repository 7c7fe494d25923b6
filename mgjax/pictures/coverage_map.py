"""One heat map on the cylinder around the character, cut open behind it."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.patches import Rectangle

from mgjax.avoidance.coverage.throws import Coverage

SIDES = {-180: "behind", -90: "left", 0: "ahead", 90: "right", 180: "behind"}
"""Degrees to the right, as the character sees it."""
MOST_NUMBERS = 12
"""Rows or columns per panel beyond which the cells have no numbers."""


def edges(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Borders of cells half-way between their centres."""
    between = 0.5 * (values[1:] + values[:-1])
    half = 0.5 * float(np.median(np.diff(values))) if len(values) > 1 else 0.2
    return np.concatenate([[max(values[0] - half, low)], between, [min(values[-1] + half, high)]])


def rightwards(result: Coverage) -> np.ndarray:
    """Degrees to the right of each direction, −180 … 180."""
    return (180.0 - np.degrees(result.directions)) % 360.0 - 180.0


def heat_map(
    axes: Axes, result: Coverage, share: np.ndarray, colours: str, most: float, size: float = 7
) -> QuadMesh:
    """One heat map; the cell behind is drawn at both ends, where the cylinder was cut."""
    order = np.argsort(rightwards(result), kind="stable")
    right = rightwards(result)[order]
    width = 360.0 / len(right)
    columns = np.concatenate([right - 360.0, right, right + 360.0])
    borders = np.append(columns - width / 2, columns[-1] + width / 2)
    levels = edges(result.heights, 0.0, np.inf)
    values = np.tile(share[order].T, (1, 3))
    palette = mpl.colormaps[colours].with_extremes(bad="#ffffff")
    mesh = axes.pcolormesh(
        borders, levels, np.ma.masked_invalid(values), cmap=palette, vmin=0, vmax=most,
        edgecolors="white", linewidth=0.5,
    )  # fmt: skip
    if len(result.heights) <= MOST_NUMBERS and len(right) <= 2 * MOST_NUMBERS:
        _numbers(axes, columns, width, result.heights, values, mesh, size)
    axes.set(xlim=(-180, 180), ylim=(levels[0], levels[-1]))
    axes.set_xticks(list(SIDES), labels=list(SIDES.values()))
    axes.set_yticks(result.heights, labels=[f"{h:g}" for h in result.heights])
    axes.tick_params(labelsize=max(size, 8), length=2)
    for border in (-90, 0, 90):
        axes.axvline(border, color="k", linewidth=0.5, alpha=0.25)
    return mesh


def _numbers(
    axes: Axes,
    columns: np.ndarray,
    width: float,
    heights: np.ndarray,
    values: np.ndarray,
    mesh: QuadMesh,
    size: float,
) -> None:
    """The share of each cell in per cent, in the middle of what is seen of it.

    Small maps have none in the halves at both ends, and no zeros.
    """
    small = size < 9
    for column, x in enumerate(columns):
        left, right = max(x - width / 2, -180.0), min(x + width / 2, 180.0)
        if right - left < (0.9 if small else 0.4) * width:
            continue
        for row, height in enumerate(heights):
            value = values[row, column]
            if np.isnan(value) or (small and value < 0.005):
                continue
            red, green, blue, _ = mesh.cmap(mesh.norm(value))
            dark = 0.3 * red + 0.59 * green + 0.11 * blue < 0.5
            axes.text(
                (left + right) / 2, height, f"{100 * value:.0f}", ha="center", va="center",
                fontsize=size, color="white" if dark else "#333",
            )  # fmt: skip


def frame_cell(axes: Axes, result: Coverage, direction: int, height: int) -> None:
    """A frame around one cell, at both ends where it was cut."""
    width = 360.0 / len(result.directions)
    levels = edges(result.heights, 0.0, np.inf)
    middle = rightwards(result)[direction]
    for x in (middle - 360.0, middle, middle + 360.0):
        left, right = max(x - width / 2, -180.0), min(x + width / 2, 180.0)
        if right > left:
            corner, tall = (left, levels[height]), levels[height + 1] - levels[height]
            axes.add_patch(
                Rectangle(corner, right - left, tall, fill=False, edgecolor="k", linewidth=2.5)
            )
