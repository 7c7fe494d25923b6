"""Smooth time warp against one speed per edge (§4.1): change of speed, success, clearance.

    python -m experiments.avoidance.warp --config configs/avoidance/warp.toml \\
        --set clips=capture --out out/avoidance/warp

Without a graph it uses the embedded clips. The walks are the same for both forms; ``fell_back`` is
the share of balls whose smooth form the ball would have touched, so that the linear one is written.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from experiments.avoidance.graphs import graph_of
from experiments.avoidance.throws import Throws, arriving_in, at_speed, standard_throws
from experiments.avoidance.warp_plot import changes_figure, profiles_figure
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.selection import both_timings, write
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.timing.walk_warps import part_moments, speed_change
from mgjax.core.errors import AttackError
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment

PERCENT = (50, 95, 100)


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is thrown at which graph."""

    graph: str = ""
    """Folder of a graph; empty: that of the embedded clips."""
    clips: str = ""
    """Folder of clips with its labels.json, of which a graph is built; empty: the graph."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    balls: int = 100
    """Balls per condition."""
    seed: int = 0
    """Draws nodes, sides and heights; the same for all conditions."""
    speeds: tuple[float, ...] = (3.0, 5.0)
    """Speeds of the balls beside 10 m/s, m/s: the slower, the longer they are near."""
    arrivals: tuple[float, ...] = (0.7, 1.9)
    """Times until a ball is at the axis beside 1.2 s, s."""
    profiles: int = 6
    """Walks of which the speed is drawn."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "graph": "",
            "clips": "",
            "balls": 3,
            "speeds": (),
            "arrivals": (),
            "profiles": 2,
            "avoidance.checks": 4,
            "avoidance.capacity": 64,
        }


def run(config: Config) -> Results:
    """Answers every ball in both forms."""
    graph, base = (
        graph_of(config.graph, config.clips, config.exclude),
        standard_throws(config.balls, config.seed),
    )
    conditions = {"standard": base}
    conditions |= {f"{x:g} m/s": at_speed(base, x) for x in config.speeds}
    conditions |= {f"in {x:g} s": arriving_in(base, x) for x in config.arrivals}
    rows = {name: _answers(graph, balls, config.avoidance) for name, balls in conditions.items()}
    metrics = {name: _summary(found, config.balls) for name, found in rows.items()}
    drawn = _spread(rows["standard"], config.profiles)
    arrays = {
        f"{name}/{key}": np.array([row[key] for row in found], dtype=np.float64)
        for name, found in rows.items()
        for key in ("linear_change", "smooth_change", "linear_m", "smooth_m")
    }
    return Results(
        metrics=metrics,
        arrays=arrays,
        figures={
            "profiles": lambda: profiles_figure(drawn),
            "changes": lambda: changes_figure(rows),
        },
        lines=tuple(_line(name, row) for name, row in metrics.items()),
    )


def _answers(graph: MotionGraph, throws: Throws, config: AvoidanceConfig) -> list[dict[str, Any]]:
    """What became of each ball for which there was a candidate; walks are compared as they are."""
    config = replace(config, refine="off")
    rows: list[dict[str, Any]] = []
    for number in range(len(throws)):
        attack = throws.attack(number)
        try:
            choice = choose(graph, throws.node_of(number, graph), attack, config=config)
        except AttackError:
            continue
        if choice.part is None:
            continue
        linear, smooth = (
            write(prepared_for(graph, config), attack, choice, replace(config, warp=form))
            for form in ("linear", "smooth")
        )
        timings = both_timings(graph, choice)
        until = attack.end + config.settle_s
        changes = [speed_change(timing, until, EXPORT_RATE) for timing in timings]
        middle = part_moments(graph, choice.walk, choice.path_length, choice.part)[1:2]
        shown = [float(timing.when(middle)[0]) for timing in timings]
        rows.append(
            {
                "avoided": linear.status == "avoided",
                "avoided_smooth": smooth.status == "avoided",
                "fell_back": choice.status == "avoided" and smooth.warp == "linear",
                "scaled": choice.time_scale != 1.0,
                "linear_change": changes[0],
                "smooth_change": changes[1],
                "linear_m": linear.clearance_m,
                "smooth_m": smooth.clearance_m,
                "apart_s": abs(shown[1] - shown[0]),
                "timings": timings,
                "t_avoid": shown[0],
                "until": until,
            }
        )
    return rows


def _summary(rows: list[dict[str, Any]], balls: int) -> dict[str, Any]:
    """Shares are of all balls; speeds and clearances of those avoided by a scaled walk."""
    moved = [row for row in rows if row["avoided"] and row["scaled"]]

    def percentiles(values: list[float], at: tuple[int, ...]) -> list[float] | None:
        return np.percentile(values, at).tolist() if values else None

    return {
        "balls": balls,
        "avoided_linear": sum(row["avoided"] for row in rows) / balls,
        "avoided_smooth": sum(row["avoided_smooth"] for row in rows) / balls,
        "fell_back": sum(row["fell_back"] for row in rows) / balls,
        "scaled_and_avoided": len(moved),
        "speed_change_per_s_p50_p95_max": {
            form: percentiles([row[f"{form}_change"] for row in moved], PERCENT)
            for form in ("linear", "smooth")
        },
        "clearance_change_m_p0_p5_p50_p95_p100": percentiles(
            [row["smooth_m"] - row["linear_m"] for row in moved], (0, 5, 50, 95, 100)
        ),
        "t_avoid_apart_s_max": max((row["apart_s"] for row in rows), default=None),
    }


def _spread(rows: list[dict[str, Any]], count: int) -> list[dict[str, Any]]:
    """Some avoided walks, from the smallest change of speed to the largest."""
    moved = [row for row in rows if row["avoided"] and row["scaled"]]
    moved.sort(key=lambda row: row["smooth_change"])
    chosen = np.unique(np.linspace(0, len(moved) - 1, min(count, len(moved))).astype(int))
    return [moved[i] for i in chosen]


def _line(name: str, row: dict[str, Any]) -> str:
    text = (
        f"{name}: {row['avoided_linear']:.0%} avoided in linear form,"
        f" {row['avoided_smooth']:.0%} asked for the smooth one, which {row['fell_back']:.0%} lack"
    )
    changes = row["speed_change_per_s_p50_p95_max"]
    if changes["linear"] is None:
        return text
    linear, smooth = (", ".join(f"{x:.2f}" for x in changes[k]) for k in ("linear", "smooth"))
    least, *_, most = row["clearance_change_m_p0_p5_p50_p95_p100"]
    return (
        f"{text}; change of speed per s (median, p95, largest) {linear} against {smooth};"
        f" clearance {1e3 * least:+.1f} … {1e3 * most:+.1f} mm"
    )


if __name__ == "__main__":
    experiment(run, Config)
