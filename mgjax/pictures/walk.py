"""The picture of a walk along a path: from above, its poses one after another, and its error."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mgjax.core.body.capsules import make_capsules, to_bar
from mgjax.core.contacts import foot_joints
from mgjax.core.kinematics import global_positions, planar_frames
from mgjax.core.motion import Motion
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.hybrid.ik.limbs import LIMB_TYPES, find_limb
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.result import PathResult
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.hybrid.reaching.result import ReachResult

SKETCH, CLIP, BLEND, LEFT, RIGHT = "#f1c40f", "#c0392b", "#1f6fb4", "#2e86c1", "#27ae60"
POSES = 24
"""Most poses in the strip."""


def walk_picture(
    path: str | Path,
    graph: MotionGraph,
    sketch: Sketch,
    walked: PathResult,
    reached: ReachResult | None = None,
) -> None:
    """Draws a walk into a file, with what is reached on it."""
    mpl.use("Agg")
    figure = Figure(figsize=(13, 9.5), dpi=80, layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(2.4, 1), width_ratios=(1.25, 1))
    figure.suptitle(
        f"{walked.status}: {walked.seconds:.1f} s, mean distance"
        f" {100 * walked.mean_distance:.1f} cm, largest {100 * walked.largest_distance:.1f} cm",
        fontweight="bold",
    )
    positions = np.asarray(global_positions(graph.skeleton, walked.motion))
    above = figure.add_subplot(grid[0, 0])
    top_view(above, graph, sketch, walked)
    _feet(figure.add_subplot(grid[0, 1]), graph, walked, positions)
    if reached is None:
        _strip(figure.add_subplot(grid[1, 0]), graph, walked.motion)
        _over_time(figure.add_subplot(grid[1, 1]), walked)
    else:
        hands_above(above, graph, reached)
        _strip(figure.add_subplot(grid[1, 0]), graph, reached.motion)
        distances(figure.add_subplot(grid[1, 1]), graph, reached)
    figure.savefig(path)


def top_view(axes: Axes, graph: MotionGraph, sketch: Sketch, walked: PathResult) -> None:
    """Sketch, root track by edges, headings each second, obstacles, end and place of failure."""
    curve = make_curve(sketch)
    axes.plot(*curve.points.T, color=SKETCH, linewidth=6, alpha=0.6, label="sketch")
    for x, z, radius in sketch.obstacles:
        axes.add_patch(Circle((x, z), radius, facecolor="#bbb", edgecolor="#555"))
    root = np.concatenate([walked.start[None, 1:], walked.track.places])
    blended = played_edges(graph, walked) == NO_CLIP
    lines = np.stack([root[:-1], root[1:]], axis=1)
    colours = [BLEND if b else CLIP for b in blended]
    axes.add_collection(LineCollection(lines.tolist(), colors=colours, linewidths=1.6))
    axes.plot([], [], color=CLIP, label="root, captured")
    axes.plot([], [], color=BLEND, label="root, transitions")
    seams = np.flatnonzero(np.diff(_edge_numbers(graph, walked))) + 1
    axes.plot(*root[seams].T, ".", color="k", markersize=2, label="edges")
    each = np.arange(0, walked.frames, round(graph.frame_rate))
    angle = walked.track.heading[each]
    axes.quiver(*walked.track.places[each].T, np.sin(angle), np.cos(angle), angles="xy",
                scale=28, width=0.004, color="#444")  # fmt: skip
    axes.plot(*root[0], "o", color="k", markersize=6, label="start")
    if sketch.end is not None:
        axes.plot(*sketch.end[:2], "x", color="k", markersize=10, label="wanted end")
    if walked.failed_at is not None:
        axes.plot(*walked.failed_at, "X", color="m", markersize=12, label="not beyond")
    axes.set_aspect("equal", adjustable="datalim")
    axes.invert_xaxis()  # seen from above with +z up, +x is to the left
    axes.set_xlabel("x, m")
    axes.set_ylabel("z, m")
    axes.set_title("from above; arrows: where the body faces, each second", fontsize=9)
    axes.legend(fontsize=7, loc="best")


def _edge_numbers(graph: MotionGraph, walked: PathResult) -> np.ndarray:
    frames = graph.edge_frames[walked.walk.edges]
    return np.repeat(np.arange(len(frames)), frames)[: walked.frames]


def played_edges(graph: MotionGraph, walked: PathResult) -> np.ndarray:
    """The clip of each frame of a walk, ``NO_CLIP`` in transitions."""
    return graph.edge_clip[walked.walk.edges[_edge_numbers(graph, walked)]]


def _feet(axes: Axes, graph: MotionGraph, walked: PathResult, positions: np.ndarray) -> None:
    feet = foot_joints(graph.skeleton)
    for side, colour in enumerate((LEFT, RIGHT)):
        place = positions[:, feet[side]][:, ::2]
        name = ("left", "right")[side]
        axes.plot(*place.T, color=colour, linewidth=0.5, alpha=0.6)
        stands = place[walked.plants[:, side]]
        axes.plot(*stands.T, ".", color=colour, markersize=3, label=f"{name} foot")
    axes.set_aspect("equal", adjustable="datalim")
    axes.invert_xaxis()
    axes.set_title(
        f"balls of the feet, dots: planted; they slide {1000 * walked.slide:.1f} mm a frame",
        fontsize=9,
    )
    axes.legend(fontsize=7)


def _strip(axes: Axes, graph: MotionGraph, motion: Motion) -> None:
    """Poses from the side of where the body faces, along time."""
    positions = np.asarray(global_positions(graph.skeleton, motion))
    headings = np.asarray(planar_frames(graph.skeleton, positions))[:, 0]
    count = min(POSES, len(positions))
    chosen = np.linspace(0, len(positions) - 1, count).round().astype(int)
    bones = [(p, j) for j, p in enumerate(graph.skeleton.parents) if p >= 0]
    scale = graph.body_scale
    apart = 0.9 * scale
    for number, frame in enumerate(chosen.tolist()):
        pose = positions[frame] - positions[frame, 0] * [1, 0, 1]
        ahead = pose[:, 0] * np.sin(headings[frame]) + pose[:, 2] * np.cos(headings[frame])
        flat = np.stack([ahead + apart * number, pose[:, 1]], axis=-1)
        axes.add_collection(
            LineCollection(flat[np.array(bones)].tolist(), colors="#333", linewidths=1)
        )
    axes.axhline(0, color="#999", linewidth=0.8)
    axes.set_xlim(-0.8 * scale, apart * count)
    axes.set_ylim(-0.1 * scale, 2.0 * scale)
    axes.set_aspect("equal")
    axes.set_xticks([apart * i for i in range(0, count, 4)])
    axes.set_xticklabels([f"{chosen[i] / graph.frame_rate:.1f} s" for i in range(0, count, 4)])
    axes.set_title("poses, turned to face right", fontsize=9)


def hands_above(axes: Axes, graph: MotionGraph, reached: ReachResult) -> None:
    """Targets, bars and the tracks of the limbs' ends around the holds, from above."""
    positions = np.asarray(global_positions(graph.skeleton, reached.motion))
    around = round(graph.frame_rate)
    for number, row in enumerate(reached.targets, 1):
        colour = LIMB_TYPES[row.target.limb].colour
        if row.target.bar is not None:
            axes.plot(*row.target.bar.ends[:, ::2].T, color=colour, linewidth=3, alpha=0.7)
            place = row.target.bar.ends.mean(axis=0)
        else:
            place = row.target.places[0]
            axes.plot(*row.target.places[:, ::2].T, "*", color=colour, markersize=11,
                      markeredgecolor="k", markeredgewidth=0.4)  # fmt: skip
        end = find_limb(graph.skeleton, row.target.limb).joints[-1]
        if row.first is not None and row.last is not None:
            track = positions[max(row.first - around, 0) : row.last + around + 1, end]
            axes.plot(*track[:, ::2].T, color=colour, linewidth=1)
        text = f"{number} {row.target.limb.replace('_', ' ')}: {row.status}"
        axes.annotate(
            text, (float(place[0]), float(place[2])), (6, 6), textcoords="offset points", fontsize=7
        )


def distances(axes: Axes, graph: MotionGraph, reached: ReachResult) -> None:
    """Distance of each limb's end to its target, or of the body to a bar, over time."""
    positions = np.asarray(global_positions(graph.skeleton, reached.motion))
    seconds = np.arange(len(positions)) / graph.frame_rate
    for number, row in enumerate(reached.targets, 1):
        target, colour = row.target, LIMB_TYPES[row.target.limb].colour
        if target.bar is not None:
            body = make_capsules(graph.skeleton)
            away = to_bar(body, positions.astype(float), target.bar.ends, target.bar.radius)
            name = "body to bar"
        else:
            end = find_limb(graph.skeleton, target.limb).joints[-1]
            place = target.at(seconds - (row.first or 0) / graph.frame_rate)
            away = np.linalg.norm(positions[:, end] - place, axis=-1)
            name = target.limb.replace("_", " ")
        axes.plot(seconds, away, color=colour, label=f"{number} {name}",
                  linestyle="-" if number % 2 else "--")  # fmt: skip
        if row.first is not None and row.last is not None:
            axes.axvspan(row.first / graph.frame_rate, row.last / graph.frame_rate, alpha=0.15,
                         color=colour)  # fmt: skip
    axes.set_ylim(0, 2 * graph.body_scale)
    axes.set_xlabel("s")
    axes.set_ylabel("m")
    axes.set_title("distance to the targets; shaded: held", fontsize=9)
    axes.legend(fontsize=7)


def _over_time(axes: Axes, walked: PathResult) -> None:
    seconds = (np.arange(walked.frames) + 1) * walked.seconds / walked.frames
    axes.plot(seconds, 100 * walked.distance, color=CLIP, label="distance to the path, cm")
    axes.set_ylabel("cm")
    axes.set_xlabel("s")
    axes.set_ylim(bottom=0)
    other = axes.twinx()
    other.plot(seconds, walked.track.speed, color="#888", linewidth=0.8)
    other.set_ylabel("speed of the root, m/s", color="#666")
    other.set_ylim(bottom=0)
    axes.legend(fontsize=7, loc="upper left")
