"""What a clear answer costs: the energies' choice beside other clear candidates of the same ball.

    python -m experiments.avoidance.minimal_movement --config \\
        configs/avoidance/minimal_movement.toml --set clips=capture --out out/minimal_movement

For each ball that several candidates are clear of: how far all joints are, on average, from where
they would be had the character not reacted (its clip goes on), and how much farther its root
travels than then, both over the motion as it is written. Compared are what the energies choose,
what the three of the paper choose, a clear candidate drawn at random, the one with the largest
clearance, and the one that moves least of all. Then the weights of movement and of speeding up are
swept.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.avoidance.graphs import built, graph_of
from experiments.avoidance.movement_measure import POLICIES, Clear, answers_of, costs_of
from experiments.avoidance.throws import arriving_in, standard_throws, wilson
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import prepared_for
from mgjax.runs.experiment import Results, experiment

FAR_M, HIGH_M = 0.5, 1.4
"""To travel so much farther for a ball so high is a fault."""
FAST = 1.15


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is thrown at which graph."""

    graph: str = ""
    """Folder of a graph; empty: built from the clips at the automatic threshold."""
    clips: str = ""
    """Folder of clips with its labels.json; empty: the graph, or the embedded clips."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    balls: int = 400
    """Standard balls."""
    arrives: float = 1.2
    """When they are there, s from now."""
    seed: int = 0
    """Draws nodes, sides, heights, and the random candidates."""
    w_m: tuple[float, ...] = (0.0, 1.0, 3.0, 6.0, 12.0)
    """Weights of movement that are swept."""
    w_speed_up: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0, 16.0)
    """Weights of speeding up that are swept."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "graph": "",
            "clips": "",
            "balls": 6,
            "w_m": (0.0, 3.0),
            "w_speed_up": (1.0, 4.0),
        }


def run(config: Config) -> Results:
    """Throws the balls, and sums up."""
    graph = built(config.clips, config.exclude, threshold_m=None) if config.clips else None
    prepared = prepared_for(graph or graph_of(config.graph or None), config.avoidance)
    throws = arriving_in(standard_throws(config.balls, config.seed), config.arrives)
    found = answers_of(prepared, throws, config.avoidance)
    several = [clear for clear in found if len(clear.numbers) > 1]
    rng = np.random.default_rng(config.seed)
    costs = [costs_of(prepared, clear, config.avoidance, rng) for clear in several]
    movement, travel = (
        {name: np.array([row[name][k] for row in costs]) for name in POLICIES} for k in (0, 1)
    )
    high = np.array([throws.height[clear.ball] >= HIGH_M for clear in several], dtype=bool)
    rows = [_row(name, movement, travel, high) for name in POLICIES]
    weights = [
        _weighted(several, config.avoidance, w_m, w_speed_up)
        for w_speed_up in config.w_speed_up
        for w_m in config.w_m
    ]
    metrics: dict[str, Any] = {
        "balls": len(throws),
        "avoided": sum(len(clear.numbers) > 0 for clear in found) / len(throws),
        "with_several_clear": len(several),
        "clear_p5_p50_p95": _percentiles([len(clear.numbers) for clear in found], (5, 50, 95)),
        "policies": rows,
        "weights": weights,
    }
    return Results(
        metrics=metrics,
        arrays={
            **{f"movement_m/{name}": values for name, values in movement.items()},
            **{f"travel_m/{name}": values for name, values in travel.items()},
        },
        figures={"minimal_movement": lambda: figure(movement, weights)},
        lines=tuple(_line(row) for row in rows),
    )


def _row(
    name: str, movement: dict[str, np.ndarray], travel: dict[str, np.ndarray], high: np.ndarray
) -> dict[str, Any]:
    """One way to choose, and how much more than the energies' choice it costs, in pairs."""
    far = travel[name] > FAR_M
    return {
        "policy": name,
        "movement_m_mean": _mean(movement[name]),
        "movement_m_p50_p95": _percentiles(movement[name], (50, 95)),
        "more_movement_m": paired(movement[name] - movement["energies"]),
        "more_in_share": _mean(movement[name] > movement["energies"] + 1e-4),
        "less_in_share": _mean(movement[name] < movement["energies"] - 1e-4),
        "travel_m_mean": _mean(travel[name]),
        "more_travel_m": paired(travel[name] - travel["energies"]),
        "far": _mean(far),
        "far_for_high_balls": _mean(far[high]),
        "far_for_high_balls_interval": wilson(int(far[high].sum()), max(int(high.sum()), 1)),
    }


def paired(differences: np.ndarray) -> list[float | None]:
    """Mean of paired differences, and its 95 % interval; nothing of less than two."""
    if len(differences) < 2:
        return [None, None, None]
    mean = float(differences.mean())
    half = 1.959964 * float(differences.std(ddof=1)) / np.sqrt(len(differences))
    return [mean, mean - half, mean + half]


def _weighted(
    several: list[Clear], avoidance: AvoidanceConfig, w_m: float, w_speed_up: float
) -> dict[str, Any]:
    """What other weights would choose of the same clear candidates."""
    energy = replace(avoidance.energy, w_m=w_m, w_speed_up=w_speed_up)
    chosen = [(clear, clear.first(energy)) for clear in several]
    scales = np.array([clear.time_scale[number] for clear, number in chosen])
    return {
        "w_m": w_m,
        "w_speed_up": w_speed_up,
        "displacement_m_mean": _mean([clear.displacement[number] for clear, number in chosen]),
        "time_scale_p5_p50_p95": _percentiles(scales, (5, 50, 95)),
        "faster_than_1.15": _mean(scales < 1 / FAST),
        "faster_than_1.5": _mean(scales < 1 / 1.5),
        "clearance_m_p10_p50": _percentiles([c.clearance[n] for c, n in chosen], (10, 50)),
    }


def _mean(values: Any) -> float | None:
    return float(np.mean(values)) if len(values) else None


def _percentiles(values: Any, percents: tuple[float, ...]) -> list[float] | None:
    return [float(x) for x in np.percentile(values, percents)] if len(values) else None


def figure(movement: dict[str, np.ndarray], weights: list[dict[str, Any]]) -> Figure:
    """Movement by the way to choose, over the balls; and what the weights trade."""
    drawn = Figure(figsize=(11, 4.8), layout="constrained")
    left, right = drawn.subplots(1, 2)
    for number, (name, values) in enumerate(movement.items()):
        style = "--" if name == "least movement" else "-"
        shares = 100 * (1 + np.arange(len(values))) / max(len(values), 1)
        left.plot(np.sort(values), shares, style, color=f"C{number}", label=name)
    left.set(xlabel="mean joint displacement against not reacting, m", ylabel="balls, %")
    left.set(xlim=(0, None), ylim=(0, 100))
    for number, speeds in enumerate(dict.fromkeys(row["w_speed_up"] for row in weights)):
        own = [row for row in weights if row["w_speed_up"] == speeds]
        x = [row["displacement_m_mean"] for row in own]
        y = [100 * (row["faster_than_1.15"] or 0) for row in own]
        right.plot(x, y, "o-", color=f"C{number}", label=f"w_speed_up = {speeds:g}")
        for a, b, row in zip(x, y, own, strict=True):
            right.annotate(f"{row['w_m']:g}", (a, b), fontsize=7, textcoords="offset points",
                           xytext=(3, 3))  # fmt: skip
    right.set(xlabel="displacement of the body's spheres, m (at each point: w_m)")
    right.set(ylabel="answers faster than 1.15 ×, %")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize=8)
    return drawn


def _line(row: dict[str, Any]) -> str:
    if row["movement_m_mean"] is None:
        return f"{row['policy']}: no ball with several clear candidates"
    more, low, high = (100 * (x or 0) for x in row["more_movement_m"])
    return (
        f"{row['policy']}: moves {100 * row['movement_m_mean']:.1f} cm"
        f" ({more:+.1f}, {low:+.1f} … {high:+.1f}, against the energies' choice), travels"
        f" {100 * row['travel_m_mean']:+.1f} cm farther; more than {FAR_M} m: {row['far']:.1%},"
        f" of balls above {HIGH_M} m {row['far_for_high_balls'] or 0:.1%}"
    )


if __name__ == "__main__":
    experiment(run, Config)
