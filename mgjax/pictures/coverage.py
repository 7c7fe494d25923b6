"""The picture of a coverage: heat maps on the unrolled cylinder around the character."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Circle

from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import BALL_RADIUS_M
from mgjax.avoidance.coverage.shares import cells, outcomes, worst_cells
from mgjax.avoidance.coverage.throws import Coverage
from mgjax.core import planar
from mgjax.core.body.roles import require_roles
from mgjax.core.kinematics import forward
from mgjax.graph.types import MotionGraph
from mgjax.pictures.coverage_map import frame_cell, heat_map

COLOURS = {"avoided": "#4575b4", "hit": "#d73027", "no candidate": "#b0b0b0", "parried": "#e69f00"}
COLUMNS = 3
BODY_ASPECT = 0.6
"""Width of the panel with the body, in parts of its height, so that the body keeps its shape."""
LEAST_PLACES = 3
"""Clips in which the character stood less often are not compared."""


def coverage_picture(path: str | Path, graph: MotionGraph, result: Coverage) -> None:
    """Draws a coverage into a file."""
    mpl.use("Agg")
    coverage_figure(graph, result).savefig(path)


def coverage_figure(graph: MotionGraph, result: Coverage) -> Figure:
    """All balls above; below where each kind answers, what is hit, and what time and place do."""
    shares = {name: cells(result, mask) for name, mask in outcomes(result).items()}
    kinds = sorted(result.kinds, key=lambda kind: -float((outcomes(result)[f"kind/{kind}"]).sum()))
    rows = -(-(len(kinds) + 4) // COLUMNS)
    figure = Figure(figsize=(15, 5.2 + 2.5 * rows), dpi=100, layout="constrained")
    parts = figure.subfigures(2, 1, squeeze=False, height_ratios=(5.2, 2.5 * rows))
    top, bottom = parts[:, 0]
    _main(top, graph, result, shares["avoided"])
    panels = list(bottom.subplots(rows, COLUMNS, squeeze=False).flat)
    most = max(0.01, *(float(np.nanmax(shares[f"kind/{kind}"])) for kind in kinds))
    for axes, kind in zip(panels, kinds, strict=False):
        share = float((result.kind == result.kinds.index(kind)).mean())
        heat_map(axes, result, shares[f"kind/{kind}"], "Blues", most)
        axes.set_title(f"avoided by {kind}: {_percent(share)} of all balls", fontsize=10)
    rest = panels[len(kinds) :]
    share = float((result.answers.status == Status.HIT.code).mean())
    heat_map(rest[0], result, shares["hit"], "Reds", 1.0)
    rest[0].set_title(f"hit, though parts come in time: {_percent(share)}", fontsize=10)
    _arrivals(rest[1], result)
    _reach(rest[2], result)
    _clips(rest[3], graph, result)
    for axes in rest[4:]:
        axes.set_axis_off()
    return figure


def _percent(share: float) -> str:
    return f"{share:.1%}" if 0 < share < 0.01 else f"{share:.0%}"


def _main(top: SubFigure, graph: MotionGraph, result: Coverage, share: np.ndarray) -> None:
    """The map of all balls, with the body at its height beside it and the worst cells framed."""
    body, axes = top.subplots(1, 2, sharey=True, width_ratios=(2, 9))
    total = float((result.answers.status == Status.AVOIDED.code).mean())
    top.suptitle(
        f"Which balls the graph avoids: {total:.0%} of {len(result)} balls at {result.speed:g} m/s,"
        f" thrown from {len(result.directions)} directions at {len(np.unique(result.node))} places"
        " in the graph",
        fontsize=13,
        fontweight="bold",
    )
    mesh = heat_map(axes, result, share, "RdYlBu", 1.0, size=11)
    bar = top.colorbar(mesh, ax=axes, pad=0.01, aspect=25, label="balls avoided, %")
    bar.set_ticks([0, 0.25, 0.5, 0.75, 1], labels=["0", "25", "50", "75", "100"])
    worst = worst_cells(result)
    for direction, height in worst:
        frame_cell(axes, result, direction, height)
    marked = "framed: worst served (clearly below the average)" if worst else "evenly served"
    axes.set_title(
        "the cylinder around the character, unrolled, as the character sees it: a cell says how"
        f" many of the balls from there are avoided, %; {marked}",
        fontsize=10,
    )
    axes.set_xlabel("where the ball comes from")
    axes.tick_params(labelsize=11, labelleft=True)
    axes.set_ylabel("height at which it passes the body's axis, m")
    _stick(body, graph, result)


def _stick(axes: Axes, graph: MotionGraph, result: Coverage) -> None:
    """A standing pose of the graph from behind, so that left is left; balls at their heights."""
    frames = graph.node_frame
    world = np.asarray(
        forward(graph.skeleton, graph.root_translation[frames], graph.local_rotations[frames])[0]
    )
    bodies = np.asarray(planar.apply(np.asarray(planar.inverse(graph.node_plane))[:, None], world))
    wrists = list(require_roles(graph.skeleton, ("left_wrist", "right_wrist")))
    # Upright with hanging arms: the head high over both hands.
    body = bodies[np.argmax((bodies[..., 1].max(axis=1)[:, None] - bodies[:, wrists, 1]).min(1))]
    bones = [body[[p, j]][:, :2] for j, p in enumerate(graph.skeleton.parents) if p >= 0]
    axes.add_collection(LineCollection(bones, colors="#444", linewidths=5, capstyle="round"))
    axes.plot(*body[int(np.argmax(body[:, 1])), :2], "o", color="#444", markersize=16)
    low, high = axes.get_ylim()
    half = 0.5 * BODY_ASPECT * (high - low)
    for height in result.heights:
        axes.add_patch(Circle((half - 0.05, height), BALL_RADIUS_M, color="#e67e22", alpha=0.8))
    axes.set_xlim(half + 0.1, -half + 0.1)  # seen from behind, +x is to the left
    axes.set_axis_off()


def _stacked(axes: Axes, result: Coverage, masks: dict[str, np.ndarray]) -> None:
    """What became of the balls of each row; the first row is at the top."""
    left = np.zeros(len(masks))
    status = result.answers.status
    places = np.arange(len(masks))[::-1]
    for (name, colour), outcome in zip(COLOURS.items(), Status, strict=True):
        if outcome == Status.PARRIED and not (status == outcome.code).any():
            continue
        share = np.array([100 * (status[mask] == outcome.code).mean() for mask in masks.values()])
        bars = axes.barh(places, share, left=left, color=colour, label=name)
        texts = [f"{x:.0f}" if x > 4 else "" for x in share]
        axes.bar_label(bars, texts, label_type="center", fontsize=8, color="white")
        left += share
    axes.set(xlim=(0, 100), ylim=(-0.6, len(masks) - 0.4))
    axes.set_yticks(places, labels=list(masks))
    axes.tick_params(labelsize=8)


def _arrivals(axes: Axes, result: Coverage) -> None:
    """What became of the balls, by how long after they are known they arrive."""
    masks = {f"{x:g} s": result.arrival == i for i, x in enumerate(result.arrivals)}
    _stacked(axes, result, masks)
    axes.set_title("balls by the time until they arrive, %", fontsize=10)
    axes.legend(fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.1), frameon=False)


def _clips(axes: Axes, graph: MotionGraph, result: Coverage) -> None:
    """What became of the balls, by the clip in which the character stands: the worst."""
    clip = graph.node_clip[result.node]
    avoided = result.answers.status == Status.AVOIDED.code
    places = {i: len(np.unique(result.node[clip == i])) for i in np.unique(clip).tolist()}
    known = [i for i in places if places[i] >= LEAST_PLACES] or list(places)
    known.sort(key=lambda i: float(avoided[clip == i].mean()))
    masks = {f"{Path(graph.clip_names[i]).stem} ({places[i]})": clip == i for i in known[:8]}
    _stacked(axes, result, masks)
    axes.set_title("worst clips to stand in (places tried), %", fontsize=10)


def _reach(axes: Axes, result: Coverage) -> None:
    """Share of the graph's nodes from which a part has come within a time."""
    times = np.sort(result.nearest_part)
    share = 100 * np.arange(1, len(times) + 1) / len(times)
    known = np.isfinite(times)
    axes.plot(times[known], share[known], color="#333", drawstyle="steps-post")
    for number, arrival in enumerate(result.arrivals[::-1]):
        limit = arrival + result.window / 2
        missing = float((result.nearest_part >= limit).mean())
        axes.axvline(limit, color="#d73027", linewidth=0.8, linestyle="--")
        axes.text(
            limit + 0.03,
            4 + 12 * number,
            f"{_percent(missing)} do not within {limit:g} s",
            fontsize=8,
        )
    right = max(
        float(times[known].max(initial=0)), float(result.arrivals.max()) + result.window / 2
    )
    axes.set(xlim=(0, right + 0.3), ylim=(0, 100), xlabel="seconds to the nearest avoidance part")
    axes.xaxis.label.set_fontsize(8)
    axes.tick_params(labelsize=8)
    axes.grid(alpha=0.3)
    axes.set_title("nodes of the graph that reach a part, %", fontsize=10)
