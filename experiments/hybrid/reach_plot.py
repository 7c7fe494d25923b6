"""Pictures of reaches: where targets are reached, and a character that reaches on its way."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mgjax.core import planar
from mgjax.core.body.capsules import Capsules, make_capsules
from mgjax.core.kinematics import global_positions
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.ik.limbs import find_limb
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.hybrid.reaching.result import ReachResult

DIRECT, EXTENDED, MISSED = "#27ae60", "#2e86c1", "#c0392b"
LEFT, RIGHT, CORE = "#5d8fc4", "#d98a4e", "#8a8f98"
_TURN, _TILT = np.radians(62.0), np.radians(24.0)
"""Where the picture is seen from: to the side of the way, and from above."""


def success_map(
    heights: tuple[float, ...],
    radii: tuple[float, ...],
    angles: np.ndarray,
    reached: dict[str, np.ndarray],
    extended: np.ndarray,
) -> Figure:
    """Where targets were reached.

    Args:
        heights, radii, angles: of the grid, m, m and rad from straight ahead to the left.
        reached: by variant, [heights, radii, angles].
        extended: of the variant with limits and extension, whether the walk was extended.
    """
    figure = Figure(figsize=(max(2.3 * len(heights), 9.0), 6.2), layout="constrained")
    upper, lower = figure.subfigures(2, 1, squeeze=False)[:, 0].tolist()
    best = reached["extended, limits"]
    for i, height in enumerate(heights):
        axes = upper.add_subplot(1, len(heights), i + 1, projection="polar")
        axes.set_theta_zero_location("N")  # pyright: ignore[reportAttributeAccessIssue]
        for j, radius in enumerate(radii):
            colours = [
                MISSED if not ok else EXTENDED if far else DIRECT
                for ok, far in zip(best[i, j], extended[i, j], strict=True)
            ]
            axes.scatter(angles, np.full(len(angles), radius), c=colours, s=26)
        axes.set_xticks([])
        axes.set_yticks([1, 2, 3])
        axes.tick_params(labelsize=6)
        axes.set_title(f"{height:g} m high: {100 * best[i].mean():.0f} %", fontsize=9)
    for number, (name, found) in enumerate(reached.items()):
        axes = lower.add_subplot(1, len(reached), number + 1)
        share = 100 * found.mean(axis=2)
        axes.imshow(share, origin="lower", aspect="auto", vmin=0, vmax=100, cmap="RdYlGn")
        for (i, j), value in np.ndenumerate(share):
            axes.text(j, i, f"{value:.0f}", ha="center", va="center", fontsize=7)
        axes.set_xticks(range(len(radii)), [f"{r:g}" for r in radii], fontsize=7)
        axes.set_yticks(range(len(heights)), [f"{h:g}" for h in heights], fontsize=7)
        axes.set_title(f"{name}: {share.mean():.1f} % reached", fontsize=9)
        axes.set_xlabel("distance, m", fontsize=8)
        axes.set_ylabel("height, m", fontsize=8)
    figure.suptitle(
        "targets around a walking character, seen from above, it faces up: reached from where it is"
        " (green), after the walk was extended (blue), not (red)",
        fontsize=9,
    )
    return figure


def project(points: np.ndarray) -> np.ndarray:
    """[..., 3] right, up and depth of places in the picture."""
    x, y, z = (points[..., i] for i in range(3))
    right = z * np.sin(_TURN) - x * np.cos(_TURN)
    back = z * np.cos(_TURN) + x * np.sin(_TURN)
    up = y * np.cos(_TILT) + back * np.sin(_TILT)
    return np.stack([right, up, back * np.cos(_TILT) - y * np.sin(_TILT)], axis=-1)


def strip(graph: MotionGraph, sketch: Sketch, result: ReachResult, count: int) -> Figure:
    """A character at several times of a walk with a reach: sketch, track, hand, target."""
    row = result.targets[0]
    held = range((row.first or 0), (row.last or 0) + 1)  # the first frame, where it is not reached
    positions = np.asarray(global_positions(graph.skeleton, result.motion), np.float64)
    chosen = moments(positions, held[len(held) // 2], count)
    curve = make_curve(sketch)
    floor = np.insert(curve.points, 1, 0.0, axis=1)
    flat = project(floor)
    figure = Figure(figsize=(12, 5.2), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(*flat[:, :2].T, color="#f4d35e", linewidth=9, alpha=0.8, solid_capstyle="round",
              zorder=1, label="sketch")  # fmt: skip
    track = project(positions[:, 0] * [1, 0, 1])
    axes.plot(*track[:, :2].T, color="#333", linewidth=1.2, zorder=2, label="root")
    hand = find_limb(graph.skeleton, row.target.limb).joints[-1]
    around = round(1.2 * graph.frame_rate)
    path = project(positions[max(held[0] - around, 0) : held[-1] + around + 1, hand])
    axes.plot(*path[:, :2].T, color="#d1495b", linewidth=1.8, zorder=900, label="hand")
    place = row.target.places[0]
    post = project(np.stack([place * [1, 0, 1], place]))
    axes.plot(*post[:, :2].T, color="#d1495b", linewidth=0.8, linestyle=":", zorder=3)
    axes.plot(*post[1, :2], "*", color="#ffb703", markersize=17, markeredgecolor="#7a4b00",
              zorder=950, label=f"target, {place[1]:g} m high")  # fmt: skip
    corner = np.concatenate([flat[:, :2], project(positions[chosen].reshape(-1, 3))[:, :2]])
    low, high = corner.min(axis=0) - 0.25, corner.max(axis=0) + 0.25
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.axis("off")
    # Points per metre, so that limbs are as thick as they are.
    unit = 72 * min(12 / (high[0] - low[0]), 5.2 / (high[1] - low[1])) * 0.95
    capsules = make_capsules(graph.skeleton)
    for frame in sorted(chosen, key=lambda f: -float(project(positions[f, :1])[0, 2])):
        _figure(axes, capsules, positions[frame], unit, 1.0 if frame in held else 0.62)
    axes.legend(fontsize=8, loc="lower right", frameon=False, ncols=4)
    return figure


def moments(positions: np.ndarray, middle: int, count: int) -> list[int]:
    """Frames about equally far along the way, one of them the reach."""
    steps = np.linalg.norm(np.diff(positions[:, 0, ::2], axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(steps)])
    gap = arc[-1] / (count - 1)
    before = np.arange(arc[middle], 0, -gap)[::-1]
    after = np.arange(arc[middle] + gap, arc[-1], gap)
    frames = np.searchsorted(arc, np.concatenate([before[:-1], after]))
    return sorted({*frames.tolist(), middle})


def _figure(axes: Axes, capsules: Capsules, pose: np.ndarray, unit: float, alpha: float) -> None:
    """Capsules, those behind first."""
    ends = project(pose[capsules.joints])
    depth = ends[..., 2].mean(axis=1)
    base = 100 + 40 * float(-project(pose[:1])[0, 2])
    order = np.argsort(-depth)
    shadow = project(pose[:1] * [1, 0, 1])[0]
    axes.plot(*shadow[:2], "o", color="k", markersize=0.3 * unit, alpha=0.07, zorder=2)
    colours = {"left": LEFT, "right": RIGHT}
    for rank, bone in enumerate(order.tolist()):
        arm = capsules.arms[bone]
        colour = colours[arm] if arm else CORE
        width = 1.7 * capsules.radii[bone] * unit
        for grow, shade in ((1.2, "white"), (0.0, colour)):
            above = base + 0.01 * (rank + 0.5 * (grow == 0))
            axes.plot(
                *ends[bone, :, :2].T,
                color=shade,
                linewidth=width + grow,
                alpha=alpha,
                solid_capstyle="round",
                zorder=above,
            )


def grid_place(plane: np.ndarray, radius: float, angle: float, height: float) -> np.ndarray:
    """A place at a distance and in a direction from a body, m."""
    local = np.array([radius * np.sin(angle), height, radius * np.cos(angle)])
    return np.asarray(planar.apply(plane, local))
