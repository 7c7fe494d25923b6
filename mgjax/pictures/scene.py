"""The picture of a ball sport scene: from above, from the side, and over time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mgjax.ballsport.aiming.solve import OK
from mgjax.ballsport.scene.build import Scene
from mgjax.ballsport.scene.types import THROWN_IN, Touch

COLOURS = ("#1f6fb4", "#d1495b", "#3a8f5c", "#8a5fbf", "#c77d1f", "#3fa7b5", "#7a7a7a", "#b05f8f")
BALL, FLOOR, NET = "#e08a1e", "#d9d4c7", "#555555"
_MARGIN_M = 1.0


def scene_picture(path: str | Path, scene: Scene) -> None:
    """Draws a scene into a PNG file."""
    scene_figure(scene).savefig(path, dpi=120)


def scene_figure(scene: Scene) -> Figure:
    """From above, from the side along the players' longer axis, and the course of time.

    Each player is drawn in the pose of the hit in the middle of the scene; flights of the ball have
    the colour of who kicked them, bounces are small rings, hits dots.
    """
    figure = Figure(figsize=(12.5, 10.0), layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(1.75, 0.6, 0.85), width_ratios=(1, 1.1))
    colours = {p.name: COLOURS[i % len(COLOURS)] for i, p in enumerate(scene.config.players)}
    _above(figure.add_subplot(grid[0, 0]), scene, colours)
    _side(figure.add_subplot(grid[0, 1]), scene, colours)
    _lanes(figure.add_subplot(grid[1, :]), scene, colours)
    _course(figure.add_subplot(grid[2, :]), scene, colours)
    passes = sum(flight.number != THROWN_IN for flight in scene.flights) - 1
    figure.suptitle(
        f"{len(scene.config.players)} players, {passes} passes,"
        f" {len(scene.ball.places) / scene.frame_rate:.0f} s",
        fontsize=13,
    )
    return figure


def _shown_touches(scene: Scene) -> dict[str, Touch]:
    """One hit of each player, the one in the middle of the player's own."""
    shown: dict[str, Touch] = {}
    for player in scene.config.players:
        own = [touch for touch in scene.touches if touch.player == player.name]
        if own:
            shown[player.name] = own[len(own) // 2]
    return shown


def _pose(scene: Scene, name: str, touch: Touch | None) -> np.ndarray:
    places = scene.positions[name]
    return places[touch.time if touch else 0]


def _bones(scene: Scene, flat: np.ndarray) -> list[np.ndarray]:
    pairs = [(j, p) for j, p in enumerate(scene.skeleton.parents) if p >= 0]
    return [flat[list(pair)] for pair in pairs]


def _flights(axes: Axes, scene: Scene, colours: dict[str, str], columns: list[int]) -> None:
    for number, flight in enumerate(scene.flights):
        by = scene.ends[number][0]
        path = scene.ball.places[flight.start : flight.stop + 1][:, columns]
        last = flight.number == len(scene.config.passes)
        thin = flight.number == THROWN_IN or last
        axes.plot(
            *path.T,
            color=colours.get(by, "#999999"),
            linewidth=0.9 if thin else 1.5,
            linestyle=":" if thin or flight.status != OK else "-",
            alpha=0.75,
            zorder=2,
        )
    for event in scene.ball.events:
        place = event.place[columns]
        if event.what == "bounce":
            axes.plot(*place, "o", ms=3.5, mfc="white", mec="#666666", mew=0.8, zorder=3)
        elif event.what == "hit":
            axes.plot(*place, "o", ms=4, color=BALL, mec="white", mew=0.5, zorder=6)
        else:
            axes.plot(*place, "X" if event.what == "miss" else "v", ms=7, color="#222222", zorder=6)


def _above(axes: Axes, scene: Scene, colours: dict[str, str]) -> None:
    axes.set_title("from above (hits: dots, bounces: rings)", fontsize=10)
    _flights(axes, scene, colours, [0, 2])
    shown = _shown_touches(scene)
    for player in scene.config.players:
        colour, touch = colours[player.name], shown.get(player.name)
        pose = _pose(scene, player.name, touch)[:, [0, 2]]
        axes.add_patch(Circle((player.x, player.z), 0.5, color=colour, alpha=0.13, zorder=1))
        axes.add_collection(
            LineCollection(_bones(scene, pose), colors=colour, linewidths=1.7, zorder=5)
        )
        away = np.array([player.x, player.z]) - _middle(scene)
        away = away / max(float(np.linalg.norm(away)), 1e-9)
        axes.annotate(
            player.name,
            (player.x, player.z),
            tuple(np.array([player.x, player.z]) + 0.75 * away),
            color=colour,
            fontsize=11,
            weight="bold",
            ha="center",
            va="center",
        )
    _net_above(axes, scene)
    homes = np.array([[p.x, p.z] for p in scene.config.players])
    low, high = homes.min(axis=0) - _MARGIN_M, homes.max(axis=0) + _MARGIN_M
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_xlabel("x, m", fontsize=9)
    axes.set_ylabel("z, m", fontsize=9)
    _plain(axes)


def _middle(scene: Scene) -> np.ndarray:
    return np.mean([[p.x, p.z] for p in scene.config.players], axis=0)


def _net_above(axes: Axes, scene: Scene) -> None:
    net = scene.config.net
    if net is None:
        return
    along = np.array([np.cos(net.heading), -np.sin(net.heading)])
    ends = np.array([net.x, net.z]) + np.array([[-50.0], [50.0]]) * along
    axes.plot(
        *ends.T, color=NET, linewidth=1.6, dashes=(6, 2), zorder=1, scalex=False, scaley=False
    )


def _side(axes: Axes, scene: Scene, colours: dict[str, str]) -> None:
    homes = np.array([[p.x, p.z] for p in scene.config.players])
    wide = int(np.argmax(np.ptp(homes, axis=0)))
    column, name = (0, "x") if wide == 0 else (2, "z")
    axes.set_title(f"from the side, along {name}", fontsize=10)
    axes.axhspan(-0.2, 0, color=FLOOR, zorder=0)
    _flights(axes, scene, colours, [column, 1])
    shown = _shown_touches(scene)
    for player in scene.config.players:
        pose = _pose(scene, player.name, shown.get(player.name))[:, [column, 1]]
        colour = colours[player.name]
        axes.add_collection(
            LineCollection(_bones(scene, pose), colors=colour, linewidths=1.8, zorder=5)
        )
    net = scene.config.net
    if net is not None:
        across = abs(np.sin(net.heading)) if column == 0 else abs(np.cos(net.heading))
        if across > 0.9:
            at = net.x if column == 0 else net.z
            axes.plot([at, at], [0, net.height], color=NET, linewidth=2.5, zorder=4)
    axes.set_xlim(homes[:, wide].min() - _MARGIN_M, homes[:, wide].max() + _MARGIN_M)
    axes.set_ylim(-0.1, max(2.1, float(scene.ball.places[:, 1].max()) + 0.2))
    axes.set_aspect("equal")
    axes.set_xlabel(f"{name}, m", fontsize=9)
    axes.set_ylabel("height, m", fontsize=9)
    _plain(axes)


def _lanes(axes: Axes, scene: Scene, colours: dict[str, str]) -> None:
    """Who does what when: hits, turns on the spot, and the ball from one to the other."""
    axes.set_title("hits (wide bars), turns (thin bars), passes (lines)", fontsize=10)
    names = [player.name for player in scene.config.players]
    clips, rate = scene.moves.clips, scene.frame_rate
    for lane, name in enumerate(names):
        axes.axhline(lane, color="#eeeeee", linewidth=6, zorder=0)
        for time, angle in scene.turns[name]:
            start, stop = scene.moves.turns[angle]
            length = (stop - start - scene.moves.window) / rate
            axes.plot([time, time + length], [lane] * 2, color=colours[name], lw=2, alpha=0.5)
    for touch in scene.touches:
        hit, lane = touch.kick.hit, names.index(touch.player)
        start = touch.time - (touch.kick.frame - int(clips.hit_starts[hit]))
        stop = start + int(clips.hit_stops[hit] - clips.hit_starts[hit])
        axes.plot(
            [start / rate, stop / rate],
            [lane] * 2,
            color=colours[touch.player],
            lw=6,
            solid_capstyle="butt",
        )
        axes.plot(touch.time / rate, lane, "o", ms=3.5, color=BALL, mec="white", mew=0.5, zorder=5)
    for flight, (by, to) in zip(scene.flights, scene.ends, strict=True):
        if by and to:
            axes.plot(
                [flight.start / rate, flight.stop / rate],
                [names.index(by), names.index(to)],
                color="#777777",
                linewidth=0.8,
                linestyle="-" if flight.status == OK else ":",
                zorder=3,
            )
    axes.set_yticks(range(len(names)), names, fontsize=9)
    axes.set_xlim(0, len(scene.ball.places) / rate)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_xlabel("s", fontsize=9)
    _plain(axes)


def _course(axes: Axes, scene: Scene, colours: dict[str, str]) -> None:
    """The height of the ball over time."""
    axes.set_title("height of the ball over time, with who hits it and how", fontsize=10)
    rate = scene.frame_rate
    top = max(2.0, float(scene.ball.places[:, 1].max()))
    for number, flight in enumerate(scene.flights):
        part = slice(flight.start, flight.stop + 1)
        times = np.arange(flight.start, flight.stop + 1) / rate
        colour = colours.get(scene.ends[number][0], "#999999")
        axes.plot(times, scene.ball.places[part, 1], color=colour, linewidth=1.4)
    for event in scene.ball.events:
        if event.what == "bounce":
            axes.plot(event.time, event.place[1], "o", ms=3.5, mfc="white", mec="#666666", mew=0.8)
    for touch in scene.touches:
        colour = colours[touch.player]
        axes.plot(touch.time / rate, touch.centre[1], "o", ms=5, color=colour, mec="white", mew=0.5)
        kind = scene.moves.clips.hit_kind[touch.kick.hit]
        axes.annotate(
            f"{touch.player} {kind}",
            (touch.time / rate, top * 1.04),
            fontsize=7.5,
            color=colour,
            rotation=40,
            ha="left",
            va="bottom",
            annotation_clip=False,
        )
        axes.axvline(touch.time / rate, color=colour, linewidth=0.5, alpha=0.35, zorder=0)
    axes.axhline(0, color="#999999", linewidth=0.8)
    axes.set_xlim(0, len(scene.ball.places) / rate)
    axes.set_ylim(-0.05, top * 1.25)
    axes.set_xlabel("s", fontsize=9)
    axes.set_ylabel("height, m", fontsize=9)
    _plain(axes)


def _plain(axes: Axes) -> None:
    axes.tick_params(labelsize=8)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
