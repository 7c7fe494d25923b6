"""Scenes of three and six players: arrivals, time warps, kicks, seams, and the time to build them.

    python -m experiments.ballsport.scene --config configs/ballsport/scene.toml

Players stand in a ring and pass at random. Every arrival is measured twice: by the flight itself
against the place it was aimed at, and in the finished motion, as the gap between the surfaces of
the ball and of the bone in the frame of the hit.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mgjax.ballsport.scene.build import Scene, build_scene, prepare_scene
from mgjax.ballsport.scene.config import Pass, Player, SceneConfig
from mgjax.ballsport.scene.report import scene_json
from mgjax.pictures.scene import scene_figure
from mgjax.runs.experiment import Results, experiment

NAMES = ("Ana", "Ben", "Cem", "Dia", "Eli", "Fay", "Gus", "Hao")
KEPT = ("time_warp", "kick_change", "speed_ratio", "angle_deg", "flight_s", "link_distance_m")


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is played."""

    players: tuple[int, ...] = (3, 6)
    """Players in the ring, one scene for each number and seed."""
    passes: int = 20
    """Passes in a scene."""
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Each draws who passes to whom, and after how many bounces."""
    neighbour_m: float = 3.8
    """Distance of neighbours in the ring."""
    bounces: tuple[int, ...] = (0, 1, 1, 1, 2)
    """Drawn from."""
    kinds: tuple[str, ...] = ("any", "any", "any", "toss", "pass", "attack")
    """Drawn from."""
    frame_rate: float = 60.0
    """Frames per second."""
    clips: str = ""
    """Folder of captured kicks."""
    exclude: tuple[str, ...] = ("bvh_converted/*", "cmu135_bvh/*")
    """Captured clips that are left out."""
    repeats: int = 3
    """Timed builds of the first scene of each size."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "players": (3,),
            "passes": 3,
            "seeds": (0,),
            "bounces": (1,),
            "kinds": ("any",),
            "frame_rate": 30.0,
            "clips": "",
            "repeats": 1,
        }


def ring(config: Config, count: int, seed: int) -> SceneConfig:
    """Players in a ring and random passes."""
    rng = np.random.default_rng(seed)
    radius = config.neighbour_m / (2 * math.sin(math.pi / count))
    angles = 2 * np.pi * np.arange(count) / count
    players = tuple(
        Player(name=NAMES[i], x=float(radius * np.sin(a)), z=float(radius * np.cos(a)))
        for i, a in enumerate(angles)
    )
    order = [0]
    for _ in range(config.passes):
        order.append(int((order[-1] + rng.integers(1, count)) % count))
    passes = tuple(
        Pass(
            by=NAMES[a],
            to=NAMES[b],
            bounces=int(rng.choice(config.bounces)),
            kind=str(rng.choice(config.kinds)),
        )
        for a, b in zip(order, order[1:], strict=False)
    )
    return SceneConfig(
        players=players,
        passes=passes,
        frame_rate=config.frame_rate,
        clips=config.clips,
        exclude=config.exclude if config.clips else (),
    )


def spread_figure(rows: dict[str, dict[str, Any]]) -> Figure:
    """How the warps, kicks and flights of all scenes are distributed."""
    figure = Figure(figsize=(11, 5.5), layout="constrained")
    titles = (
        "pace of the links before a hit",
        "change of the kick / bone speed",
        "ball speed / bone speed",
        "angle between ball and bone, degrees",
        "flight time, s",
        "D_p of the sections before a hit, m",
    )
    for axes, key, title in zip(figure.subplots(2, 3).flat, KEPT, titles, strict=True):
        values = [row["values"][key] for row in rows.values()]
        axes.hist(values, bins=16, stacked=True, label=list(rows))
        axes.set_title(title, fontsize=9)
        axes.tick_params(labelsize=8)
    figure.axes[0].legend(fontsize=8, title="players", title_fontsize=8)
    return figure


def _values(reports: list[dict[str, Any]], key: str) -> list[float]:
    return [row[key] for report in reports for row in report["passes"] if key in row]


def judge(reports: list[dict[str, Any]]) -> dict[str, Any]:
    """All scenes of one size together."""
    values = {key: _values(reports, key) for key in KEPT}
    return {
        "passes_made": sum(report["passes_made"] for report in reports),
        "passes_missed": sum(report["passes_missed"] for report in reports),
        "arrival_miss_m_max": max(report["worst"]["arrival_miss_m"] for report in reports),
        "surface_gap_m_max": max(report["worst"]["surface_gap_m"] for report in reports),
        "time_warp_off_p50_p95_max": np.percentile(
            np.abs(np.array(values["time_warp"]) - 1), [50, 95, 100]
        ),
        **{f"{key}_p50_p95_max": np.percentile(values[key], [50, 95, 100]) for key in KEPT[1:]},
        "seam_speed_m_s_max": max(report["worst"]["seam_speed_m_s"] for report in reports),
        "turn_rate_deg_s_max": max(report["worst"]["turn_rate_deg_s"] for report in reports),
        "drift_m_max": max(report["worst"]["drift_m"] for report in reports),
        "distance_to_others_m_min": min(
            x for r in reports if (x := r["worst"]["least_distance_to_others_m"]) is not None
        ),
        "values": values,
    }


def run(config: Config) -> Results:
    rows: dict[str, dict[str, Any]] = {}
    timings: dict[str, Any] = {}
    shown: dict[str, Scene] = {}
    for count in config.players:
        reports: list[dict[str, Any]] = []
        scenes = [ring(config, count, seed) for seed in config.seeds]
        moves = prepare_scene(scenes[0])
        for scene in scenes:
            built = build_scene(scene, moves=moves)
            reports.append(scene_json(built))
            shown.setdefault(str(count), built)
        rows[str(count)] = judge(reports)
        timings[str(count)] = _timed(scenes[0], config.repeats)
    lines = tuple(
        f"{count} players: {row['passes_made']} passes, {row['passes_missed']} missed;"
        f" arrival {1000 * row['arrival_miss_m_max']:.3f} mm,"
        f" surfaces {1000 * row['surface_gap_m_max']:.3f} mm;"
        f" warp ±{100 * row['time_warp_off_p50_p95_max'][2]:.1f} % at most,"
        f" kick change {100 * row['kick_change_p50_p95_max'][0]:.0f} % in the median,"
        f" {100 * row['kick_change_p50_p95_max'][2]:.0f} % at most;"
        f" built in {timings[count]['with_clip_set_s']['median']:.2f} s,"
        f" {timings[count]['scene_s']['median']:.2f} s with the clip set at hand"
        for count, row in rows.items()
    )
    figures: dict[str, Any] = {
        f"scene_{count}": partial(scene_figure, scene) for count, scene in shown.items()
    }
    figures["spread"] = partial(spread_figure, rows)
    return Results(metrics={"scenes": rows}, timings=timings, figures=figures, lines=lines)


def _timed(scene: SceneConfig, repeats: int) -> dict[str, Any]:
    """Seconds to build a scene, with its clip set and without."""
    with_clip_set, alone = [], []
    for _ in range(repeats):
        begun = time.perf_counter()
        moves = prepare_scene(scene)
        middle = time.perf_counter()
        build_scene(scene, moves=moves)
        end = time.perf_counter()
        with_clip_set.append(end - begun)
        alone.append(end - middle)
    return {
        name: {"median": float(np.median(values)), "min": min(values)}
        for name, values in (("with_clip_set_s", with_clip_set), ("scene_s", alone))
    }


if __name__ == "__main__":
    experiment(run, Config)
