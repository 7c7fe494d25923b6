"""Pictures of throws: where the ball came from, when, and what the body did."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mgjax.graph.types import MotionGraph
from mgjax.pictures.throw_scene import (
    Scene,
    Throw,
    balls_at,
    passing_ball,
    pose_at,
    throw_scene,
    track_of,
)

NOW, BEGIN, PASS, BALL = "#9aa0a6", "#1f6fb4", "#c0392b", "#e67e22"


def scene_picture(path: str | Path, graph: MotionGraph, throws: list[Throw]) -> None:
    """Draws each throw in a row: from the side, as the ball sees it, from above, and over time."""
    mpl.use("Agg")
    rows = len(throws)
    figure = Figure(figsize=(15, 5.1 * rows + 0.3), dpi=80, layout="constrained")
    parts = figure.subfigures(rows, 1, squeeze=False)
    for number, (part, throw) in enumerate(zip(parts[:, 0], throws, strict=True), 1):
        scene = throw_scene(graph, throw)
        grid = part.add_gridspec(2, 3, height_ratios=(6, 1), width_ratios=(1.5, 1, 1))
        part.suptitle(_headline(scene, number, rows), fontsize=12, fontweight="bold")
        _side_view(part.add_subplot(grid[0, 0]), scene)
        _ball_view(part.add_subplot(grid[0, 1]), scene)
        _top_view(part.add_subplot(grid[0, 2]), scene)
        _time_line(part.add_subplot(grid[1, :]), scene)
    figure.savefig(path)


def _headline(scene: Scene, number: int, total: int) -> str:
    attack, chosen = scene.throw.attack, scene.throw.selection
    first = track_of(attack, scene.ball)[0]
    # The start frame has +Z ahead and +X to the left.
    angle = np.degrees(np.arctan2(first[0], first[2])) % 360
    words = ("ahead", "ahead left", "the left", "behind left")
    words += ("behind", "behind right", "the right", "ahead right")
    origin = words[int(((angle + 22.5) % 360) // 45)]
    prefix = f"Ball {number}: " if total > 1 else "Ball "
    text = (
        f"{prefix}from {origin}, {attack.largest_speed:.0f} m/s, passing at"
        f" {scene.t_pass:.2f} s at a height of {passing_ball(scene)[1]:.2f} m"
    )
    if chosen.status == "no_candidate":
        return f"{text}\nno candidate: no avoidance part comes at the right time"
    if chosen.parry is not None:
        limb, at = chosen.parry.limb.replace("_", " "), chosen.parry.time
        led = f"led by {chosen.parry.largest_m:.2f} m"
        return f"{text}\nPARRIED with the {limb} at {at:.2f} s, {led}"
    result = "avoided" if chosen.status == "avoided" else "HIT"
    stretch = f", played × {1 / (chosen.time_scale or 1):.2f} speed"
    distance = chosen.clearance_m or 0.0
    gap = f"{abs(distance):.2f} m {'clear' if distance > 0 else 'deep'}"
    return f"{text}\n{result} by: {scene.kind}{stretch}, {gap}"


def _moments(scene: Scene) -> list[tuple[float, str, str]]:
    moments = [(0.0, NOW, "now")]
    if scene.t_begin is not None:
        moments.append((scene.t_begin, BEGIN, f"{scene.kind} begins, {scene.t_begin:.2f} s"))
    moments.append((scene.t_pass, PASS, f"ball passes, {scene.t_pass:.2f} s"))
    return moments


def _stick(axes: Axes, scene: Scene, places: np.ndarray, colour: str, width: float) -> None:
    axes.add_collection(
        LineCollection(
            places[scene.bones].tolist(), colors=colour, linewidths=width, capstyle="round"
        )
    )


def _side_view(axes: Axes, scene: Scene) -> None:
    axes.set_title("from the side of the flight (ball flies to the right)", fontsize=9)
    attack = scene.throw.attack

    def flat(points: np.ndarray) -> np.ndarray:
        return np.stack([points @ scene.side, points[..., 1]], axis=-1)

    axes.axhline(0, color="#555", linewidth=1)
    _body(axes, scene, scene.t_pass, flat, PASS, 0.18)
    for time, colour, label in _moments(scene):
        _stick(axes, scene, flat(pose_at(scene, time)), colour, 2.2 if colour == PASS else 1.6)
        axes.plot([], [], color=colour, linewidth=2, label=label)
    _tracks(axes, scene, flat)
    first = max(attack.start, 0.0)
    times = np.unique([*np.arange(first, scene.t_pass, 0.1), scene.t_pass])
    for time in times:
        passing = time == scene.t_pass
        for centre, radius in balls_at(scene, time):
            place = flat(centre)
            axes.add_patch(
                Circle(
                    tuple(place),
                    radius,
                    facecolor=BALL,
                    edgecolor="k" if passing else BALL,
                    alpha=1.0 if passing else 0.45,
                )
            )
            if place[0] > -2.4 * scene.scale:
                axes.annotate(
                    f"{time:.1f} s",
                    (place[0], place[1]),
                    (0, 12),
                    textcoords="offset points",
                    fontsize=7,
                    ha="center",
                    color="#8a4b08",
                )
    axes.set_xlim(-2.6 * scene.scale, 1.4 * scene.scale)
    axes.set_ylim(-0.05 * scene.scale, 2.3 * scene.scale)
    axes.set_aspect("equal")
    axes.set_xlabel("along the flight, m", fontsize=8)
    axes.set_ylabel("height, m", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.legend(loc="upper right", fontsize=7, framealpha=0.9)


def _tracks(axes: Axes, scene: Scene, flat: Any) -> None:
    """Dots along the flight of each sphere."""
    for ball in range(len(scene.throw.attack.radii)):
        track = flat(track_of(scene.throw.attack, ball))
        axes.plot(track[:, 0], track[:, 1], color=BALL, linewidth=1, linestyle=":")


def _body(axes: Axes, scene: Scene, time: float, flat: Any, colour: str, alpha: float) -> None:
    trace = scene.throw.selection.trace
    index = min(int(np.searchsorted(trace.times, time)), len(trace.times) - 1)
    sizes = 2 * scene.radii
    axes.add_collection(
        EllipseCollection(
            sizes,
            sizes,
            np.zeros_like(sizes),
            units="xy",
            offsets=flat(trace.centres[index]),
            offset_transform=axes.transData,
            facecolors=colour,
            alpha=alpha,
        )
    )


def _ball_view(axes: Axes, scene: Scene) -> None:
    axes.set_title(f"as the ball sees the body, at {scene.t_pass:.2f} s", fontsize=9)
    across = np.array([-scene.side[2], 0.0, scene.side[0]])

    def flat(points: np.ndarray) -> np.ndarray:
        return np.stack([points @ across, points[..., 1]], axis=-1)

    axes.axhline(0, color="#555", linewidth=1)
    if scene.t_begin is not None:
        _body(axes, scene, scene.t_begin, flat, BEGIN, 0.15)
        _stick(axes, scene, flat(pose_at(scene, scene.t_begin)), BEGIN, 1.2)
    _body(axes, scene, scene.t_pass, flat, PASS, 0.35)
    _stick(axes, scene, flat(pose_at(scene, scene.t_pass)), PASS, 1.8)
    ball = flat(passing_ball(scene))
    for centre, radius in balls_at(scene, scene.t_pass):
        axes.add_patch(Circle(tuple(flat(centre)), radius, facecolor=BALL, edgecolor="k"))
    axes.set_xlim(ball[0] - 1.15 * scene.scale, ball[0] + 1.15 * scene.scale)
    axes.set_ylim(-0.05 * scene.scale, 2.3 * scene.scale)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)
    axes.set_xlabel("across the flight, m", fontsize=8)


def _top_view(axes: Axes, scene: Scene) -> None:
    axes.set_title("from above (the character faces up at the start)", fontsize=9)

    def flat(points: np.ndarray) -> np.ndarray:
        return np.stack([-points[..., 0], points[..., 2]], axis=-1)  # +X is to the left

    attack = scene.throw.attack
    _tracks(axes, scene, flat)
    middle = flat(passing_ball(scene))
    for time in np.arange(max(attack.start, 0.0), attack.end, 0.1):
        for centre, radius in balls_at(scene, time):
            axes.add_patch(Circle(tuple(flat(centre)), radius, facecolor=BALL, alpha=0.5))
    direction = flat(scene.side)
    axes.annotate(
        "",
        tuple(middle - 0.5 * direction),
        tuple(middle - 1.3 * direction),
        arrowprops={"arrowstyle": "-|>", "color": BALL, "linewidth": 2},
    )
    for time, colour, _ in _moments(scene):
        _stick(axes, scene, flat(pose_at(scene, time)), colour, 1.8 if colour == PASS else 1.2)
    root = flat(scene.positions[:, 0])
    axes.plot(root[:, 0], root[:, 1], color="#444", linewidth=0.8)
    axes.annotate(
        "", (0, 0.55 * scene.scale), (0, 0.0), arrowprops={"arrowstyle": "->", "color": NOW}
    )
    axes.set_xlim(-1.7 * scene.scale, 1.7 * scene.scale)
    axes.set_ylim(-1.7 * scene.scale, 1.7 * scene.scale)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)
    axes.set_xlabel("to the right, m", fontsize=8)


def _time_line(axes: Axes, scene: Scene) -> None:
    trace, attack = scene.throw.selection.trace, scene.throw.attack
    shown = np.minimum(scene.gaps, 2.0)
    axes.plot(trace.times[1:], shown, color=PASS, linewidth=1.2)
    axes.axhline(0, color="k", linewidth=0.6)
    axes.axvspan(max(attack.start, 0), attack.end, color=BALL, alpha=0.15, label="ball in the air")
    if scene.t_begin is not None and scene.t_end is not None:
        axes.axvspan(
            scene.t_begin, scene.t_end, ymax=0.3, color=BEGIN, alpha=0.35, label=scene.kind
        )
    axes.axvline(scene.t_pass, color=PASS, linewidth=0.8, linestyle="--")
    axes.set_xlim(0, trace.times[-1])
    axes.set_ylim(-0.4, 2.05)
    axes.set_ylabel("clearance, m", fontsize=8)
    axes.set_xlabel("seconds from now", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.legend(loc="upper right", fontsize=7, ncols=2)
