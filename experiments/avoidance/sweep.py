"""What each setting of the avoidance changes: choice, success, clearance, time scale, saturation.

    python -m experiments.avoidance.sweep --config configs/avoidance/sweep.toml \\
        --set clips=capture --out out/avoidance/sweep

Without a graph it uses the embedded clips. The balls are the standard ones: 10 m/s from any side,
level, 0.5–1.7 m high over the root, there in 1.2 s, at random nodes; of the crop only the radius
matters to them. Settings of the energies are swept in one compiled call per ball; all others need a
search of their own. Each setting is varied alone, the others are those of ``avoidance``, and what
it changes is counted against these.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from experiments.avoidance.graphs import graph_of
from experiments.avoidance.sweep_measure import measure
from experiments.avoidance.sweep_plot import maps_figure, sweep_figure
from experiments.avoidance.throws import Throws, standard_throws
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig, SpeedConfig
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment
from mgjax.runs.points import Points

SPEEDS = {
    "printed": SpeedConfig(V_fast=0.3, V_slow=0.1, V_still=0.0),
    "measured": SpeedConfig(),
    "any": SpeedConfig(V_fast=0.0, V_slow=math.inf, V_still=math.inf),
    "none": SpeedConfig(V_fast=math.inf, V_slow=0.0, V_still=0.0),
}
"""Which edges may change speed: as the paper prints it, the defaults, all both ways, none."""
AXES = ("E_avoidance", "D_body", "w_a", "w_b", "w_t", "E_time", "w_m", "w_speed_up")
MAPPED = ("changed", "avoided", "clearance_m_p5_p50_p95")


@dataclass(frozen=True, kw_only=True)
class Config:
    """Which settings are tried on which graph."""

    graph: str = ""
    """Folder of a graph; empty: that of the embedded clips."""
    clips: str = ""
    """Folder of clips with its labels.json, of which a graph is built; empty: the graph."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    balls: int = 100
    """Standard balls."""
    seed: int = 0
    """Draws the balls."""
    E_avoidance: tuple[float, ...] = (0.001, 0.002, 0.004, 0.0085, 0.017, 0.035, 0.1, 0.5)
    """m·s, for the form of avoidance.energy."""
    E_paper: tuple[float, ...] = (0.1, 0.25, 0.5, 1.14, 2.5, 5.0, 10.0)
    """m·s, for the form as printed."""
    E_paper_measured: float = 1.14
    """m·s: the 90th percentile of e' for the form as printed."""
    D_body: tuple[float, ...] = (0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.5)
    """m."""
    weights: tuple[float, ...] = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0)
    """Of each of the paper's energies."""
    w_m: tuple[float, ...] = (0.0, 1.0, 3.0, 6.0, 12.0)
    """Of the movement energy."""
    w_speed_up: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0)
    """How much more speeding up weighs."""
    E_time: tuple[float, ...] = (1.25, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0)
    """Largest time scale, and the scale of its energy."""
    T_window: tuple[float, ...] = (0.25, 0.5, 1.0, 1.5, 2.0)
    """s."""
    crop_radius_m: tuple[float, ...] = (0.5, 0.75, 1.0, 1.5, 2.0)
    """m."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search that the others are compared with."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "graph": "",
            "clips": "",
            "balls": 3,
            "E_avoidance": (0.001, 0.0085),
            "E_paper": (0.5, 1.14),
            "D_body": (0.1, 0.3),
            "weights": (0.0, 1.0),
            "w_m": (0.0, 3.0),
            "w_speed_up": (1.0, 4.0),
            "E_time": (1.5, 4.0),
            "T_window": (0.5, 1.0),
            "crop_radius_m": (0.5, 1.0),
        }


def run(config: Config, points: Points) -> Results:
    """Measures all settings; those of an interrupted run are taken over."""
    graph = graph_of(config.graph, config.clips, config.exclude)
    throws = standard_throws(config.balls, config.seed)
    base = config.avoidance
    grid = _grid(config)
    found = points.measure("grid", lambda: measure(graph, throws, grid, base))
    balls, rows = found["balls"], found["rows"]
    timings = {"grid_s": found["seconds"], "grid_settings": len(grid)}
    metrics: dict[str, Any] = {
        "graph": {key: graph.report[key] for key in ("threshold_m", "nodes", "edges")},
        "default": rows["default"],
        "default_values": {name: getattr(base.energy, name) for name in AXES}
        | {"T_window": base.T_window, "crop_radius_m": base.crop_radius_m},
    }
    for name in AXES:
        metrics[name] = [{"value": x} | rows[f"{name}/{x:g}"] for x in _values(config, name)]
    metrics["maps"] = {f"{a}, {b}": _map(config, rows, a, b) for a, b in (AXES[:2], AXES[2:4])}
    metrics |= _other_forms(config, graph, throws, balls, points)
    metrics |= _structural(config, graph, throws, balls, points)
    figures: dict[str, Any] = {
        "sweep": lambda: sweep_figure(metrics),
        "maps": lambda: maps_figure(metrics["maps"]),
    }
    arrays = {
        f"{pair}/{key}": np.array(table, dtype=np.float64)
        for pair, tables in metrics["maps"].items()
        for key, table in tables.items()
    }
    return Results(
        metrics=metrics,
        timings=timings,
        arrays=arrays,
        figures=figures,
        lines=tuple(_lines(metrics)),
    )


def _values(config: Config, name: str) -> tuple[float, ...]:
    return config.weights if name in ("w_a", "w_b", "w_t") else getattr(config, name)


def _grid(config: Config) -> dict[str, EnergyConfig]:
    """All settings of the energies that are tried in one form: the default, axes and two planes."""
    base = config.avoidance.energy
    grid = {"default": base}
    for name in AXES:
        for x in _values(config, name):
            grid[f"{name}/{x:g}"] = replace(base, **{name: x})
    for a, b in (AXES[:2], AXES[2:4]):
        for x in _values(config, a):
            for y in _values(config, b):
                grid[f"{a}/{x:g}, {b}/{y:g}"] = replace(base, **{a: x, b: y})
    return grid


def _map(config: Config, rows: dict[str, Any], a: str, b: str) -> dict[str, Any]:
    """Tables of two settings that are varied together, ``[a, b]``."""
    first, second = _values(config, a), _values(config, b)

    def table(key: str) -> list[list[Any]]:
        found = [[rows[f"{a}/{x:g}, {b}/{y:g}"][key] for y in second] for x in first]
        if not key.endswith("p5_p50_p95"):
            return found
        return [[x and x[1] for x in line] for line in found]

    names = {key: key.replace("p5_p50_p95", "p50") for key in MAPPED}
    return {a: first, b: second} | {name: table(key) for key, name in names.items()}


def _other_forms(
    config: Config, graph: MotionGraph, throws: Throws, balls: dict[str, Any], points: Points
) -> dict[str, Any]:
    """The other forms of the energies, each with the axis that belongs to it."""
    base = config.avoidance
    energy = base.energy
    literal = replace(energy, d0="paper")
    paper = replace(energy, form="paper", E_avoidance=config.E_paper_measured)
    free = replace(base, limit_scale=False)
    axes = {
        "D_body, literal d0": ("D_body", config.D_body, literal, base),
        "E_avoidance, paper form": ("E_avoidance", config.E_paper, paper, base),
        "E_avoidance, paper form and d0": (
            "E_avoidance",
            config.E_paper,
            replace(paper, d0="paper"),
            base,
        ),
        "E_time, no limit": ("E_time", config.E_time, energy, free),
    }
    metrics: dict[str, Any] = {"forms": []}
    heads: dict[str, Any] = {}
    for name, (key, values, start, settings) in axes.items():
        grid = {"head": start} | {f"{x:g}": replace(start, **{key: x}) for x in values}
        found = points.measure(
            name, lambda g=grid, s=settings: measure(graph, throws, g, s, balls)
        )["rows"]
        metrics[name] = [{"value": x} | found[f"{x:g}"] for x in values]
        heads[name] = found["head"]
    clamped = {"head": replace(energy, form="overlap", d0="clamped")}
    plain = {"w_a": 1.0, "w_b": 1.0, "w_m": 0.0, "w_t": 1.0, "w_speed_up": 1.0}
    printed = {"head": replace(paper, d0="paper", E_avoidance=0.5, **plain)}
    as_printed = replace(free, T_window=1.0, T_wide=1.0, speed=SPEEDS["printed"])
    rows = {
        "overlap, clamped": points.measure(
            "forms/overlap", lambda: measure(graph, throws, clamped, base, balls)
        )["rows"]["head"],
        "overlap, literal d0": heads["D_body, literal d0"],
        "paper, clamped": heads["E_avoidance, paper form"],
        "paper, literal d0": heads["E_avoidance, paper form and d0"],
        "all as printed": points.measure(
            "forms/printed", lambda: measure(graph, throws, printed, as_printed, balls)
        )["rows"]["head"],
    }
    metrics["forms"] = [{"value": name} | row for name, row in rows.items()]
    return metrics


def _structural(
    config: Config, graph: MotionGraph, throws: Throws, balls: dict[str, Any], points: Points
) -> dict[str, Any]:
    """Settings that need other candidates, other times or another timing."""
    base = config.avoidance
    settings: dict[str, dict[Any, AvoidanceConfig]] = {
        "T_window": {x: replace(base, T_window=x, T_wide=x) for x in config.T_window},
        "crop_radius_m": {x: replace(base, crop_radius_m=x) for x in config.crop_radius_m},
        "speed": {name: replace(base, speed=speed) for name, speed in SPEEDS.items()},
    }
    grid = {"head": base.energy}
    return {
        name: [
            {"value": x}
            | points.measure(f"{name}/{x}", lambda s=s: measure(graph, throws, grid, s, balls))[
                "rows"
            ]["head"]
            for x, s in values.items()
        ]
        for name, values in settings.items()
    }


def _lines(metrics: dict[str, Any]) -> list[str]:
    """The default and the extremes of each setting, for people."""

    def text(name: str, row: dict[str, Any]) -> str:
        clearance, scaling = row["clearance_m_p5_p50_p95"], row["scaling_p50_p95"]
        words = f"{name}: {row['avoided']:.0%} avoided, {row['changed']:.0%} choose another walk"
        if clearance is None:
            return words
        return f"{words}, clearance {clearance[1]:.3f} m, time scale {scaling[0]:.2f} (medians)"

    lines = [text("default", metrics["default"])]
    for name, rows in metrics.items():
        if isinstance(rows, list):
            some = rows if isinstance(rows[0]["value"], str) else [rows[0], rows[-1]]
            lines += [text(f"{name} = {row['value']}", row) for row in some]
    return lines


if __name__ == "__main__":
    experiment(run, Config)
