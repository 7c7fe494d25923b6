"""Pictures of an analysis, after Figs 2 and 3 of the paper."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.ballsport.kicks import Kick
from mgjax.ballsport.config import FEET, AnalysisConfig
from mgjax.ballsport.hits.bones import BoneHit
from mgjax.ballsport.hits.detect import hit_joint, links, mark
from mgjax.clips.types import Clip

HIGH, FAST, BALL, MOTION, LINK, LABEL = (
    *("#c0392b", "#b03fa8", "#c0392b", "#1f6fb4", "#9aa0a6", "#2a7f4f"),
)

Shown = tuple[Clip, np.ndarray, list[BoneHit], list[Kick]]


def curves_figure(shown: list[Shown], config: AnalysisConfig) -> Figure:
    """Height and speed of both feet with F_H, F_S, S_B, S_H and S_L."""
    figure = Figure(figsize=(14, 4.6 * len(shown) + 0.6), layout="constrained")
    rows = figure.subplots(2 * len(shown), 1, squeeze=False)[:, 0]
    for number, (clip, positions, found, kicks) in enumerate(shown):
        for foot, bone in enumerate(FEET):
            hits = [item for item in found if item.bone == bone]
            own = [k for k in kicks if f"{k.foot}_foot" == bone]
            axes = rows[2 * number + foot]
            _curve(axes, clip, positions, bone, hits, own, config)
            axes.set_title(f"{clip.name}, {bone.replace('_', ' ')}", fontsize=9, loc="left")
    handles, names = rows[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=8, frameon=False, fontsize=8)
    return figure


def _curve(
    axes: Axes,
    clip: Clip,
    positions: np.ndarray,
    bone: str,
    found: list[BoneHit],
    kicks: list[Kick],
    config: AnalysisConfig,
) -> None:
    rate = clip.motion.frame_rate
    marks = mark(positions[:, hit_joint(clip.skeleton, bone)].astype(np.float64), rate, config)
    t = np.arange(len(marks.height)) / rate
    speed = axes.twinx()
    speed.plot(t, marks.speed, color="#e0a030", linewidth=0.9)
    speed.set_ylabel("speed, m/s", fontsize=8, color="#b07010")
    speed.set_ylim(-2.0, 14.0)
    axes.plot([], [], color="#e0a030", linewidth=0.9, label="speed")
    axes.plot(t, marks.height, color="#222", linewidth=1.2, label="height")
    axes.axhline(config.height_m, color="#555", linestyle=":", linewidth=0.9, label="threshold")
    axes.vlines(marks.highest / rate, 0, 1.6, color=HIGH, linewidth=1.0, label="F_H")
    chosen = np.array([item.hit.fastest for item in found]) / rate
    axes.vlines(chosen, 0, 1.6, color=FAST, linewidth=1.2, linestyle="--", label="F_S of a hit")
    speed.plot(marks.fastest / rate, marks.speed[marks.fastest], ".", color=FAST, markersize=4)
    axes.plot(
        [k.peak_s for k in kicks], [1.55] * len(kicks), "v", color=LABEL, label="labelled peak"
    )
    bars = [
        ("S_L", LINK, -0.10, links([item.hit for item in found], len(t))),
        ("S_H", MOTION, -0.10, [(item.hit.start, item.hit.stop) for item in found]),
        ("S_B", BALL, -0.18, [(item.hit.hit_start, item.hit.hit_stop) for item in found]),
    ]
    for name, colour, height, spans in bars:
        axes.hlines(
            [height] * len(spans),
            [a / rate for a, _ in spans],
            [b / rate for _, b in spans],
            color=colour,
            linewidth=5,
            label=name,
        )
    axes.set(xlim=(0, t[-1]), ylim=(-0.24, 1.65))
    axes.set_ylabel("height, m", fontsize=8)
    axes.set_xlabel("s", fontsize=8)


def poses_figure(clip: Clip, positions: np.ndarray, found: list[BoneHit]) -> Figure:
    """The five key poses of the first hit and the way of the hit bone between them."""
    item = found[0]
    keys = item.hit.key_frames
    joint = hit_joint(clip.skeleton, item.bone)
    path = positions[item.hit.start : item.hit.stop, joint]
    widest = np.linalg.svd(path[:, [0, 2]] - path[:, [0, 2]].mean(axis=0))[2][0]
    side = np.array([widest[0], 0.0, widest[1]])
    figure = Figure(figsize=(14, 3.0), layout="constrained")
    titles = ("first", "F_S before", "F_H", "F_S after", "last")
    axes_row = figure.subplots(1, 5, sharey=True)
    middle = float(positions[keys[2], 0] @ side)
    for axes, frame, title in zip(axes_row, keys, titles, strict=True):
        places = positions[frame]
        for child, parent in enumerate(clip.skeleton.parents):
            if parent >= 0:
                ends = places[[parent, child]]
                axes.plot(ends @ side - middle, ends[:, 1], color="#333", linewidth=1.6)
        axes.plot(path @ side - middle, path[:, 1], color="#e0a030", linewidth=1)
        ways = positions[list(keys), joint]
        axes.plot(ways @ side - middle, ways[:, 1], "o--", color="#b07010", markersize=4)
        here = places[joint]
        axes.plot([here @ side - middle], [here[1]], "o", color=HIGH, markersize=7)
        axes.axhline(0, color="#777", linewidth=0.8)
        axes.set_title(f"{title}, {frame / clip.motion.frame_rate:.2f} s", fontsize=9)
        axes.set(xlim=(-1.3, 1.3), ylim=(-0.05, 1.8))
        axes.set_aspect("equal")
    figure.suptitle(
        f"{clip.name}, {item.bone.replace('_', ' ')}: key poses and motion vector", fontsize=10
    )
    return figure
