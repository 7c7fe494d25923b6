"""What standard balls come to under one setting of the avoidance; made to be swept.

    mgjax runs sweep experiments.avoidance.settings --set clips=capture --out out/settings.jsonl \\
        --grid "avoidance.energy.E_avoidance=[0.002, 0.0085, 0.035]" \\
        --draw "avoidance.energy.w_m=[0, 12]" --samples 8

Runs that differ in numbers of the energies only are made together: candidates are enumerated,
timed and judged once, and ranked for all settings in one compiled call per ball. Without a graph
it uses the embedded clips. The balls are the standard ones; captured motion is judged, and near
misses are not refined.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

from experiments.avoidance.graphs import graph_of
from experiments.avoidance.sweep_measure import measure
from experiments.avoidance.throws import standard_throws
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.runs.experiment import Results, experiment

TRACED = tuple(
    f"avoidance.energy.{setting.name}"
    for setting in fields(EnergyConfig)
    if setting.name not in ("form", "d0")
)
"""Settings in which configs of one call may differ."""
COMPARED = ("changed", "gained", "lost", "clearance_change_m_mean")
"""Figures against another setting, which one setting alone does not have."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Which setting is tried on which graph."""

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
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"graph": "", "clips": "", "balls": 3}


def run(config: Config) -> Results:
    """Throws all balls."""
    return run_together([config])[0]


def run_together(configs: Sequence[Config]) -> list[Results]:
    """The same for configs that differ in ``TRACED`` only."""
    first = configs[0]
    graph = graph_of(first.graph, first.clips, first.exclude)
    throws = standard_throws(first.balls, first.seed)
    energies = {str(number): config.avoidance.energy for number, config in enumerate(configs)}
    rows = measure(graph, throws, energies, first.avoidance)["rows"]
    return [_results(rows[number]) for number in energies]


def _results(row: dict[str, Any]) -> Results:
    """Percentiles and ends of intervals have a name each, so that each is a column."""
    metrics: dict[str, Any] = {}
    for key, value in row.items():
        name, *percents = key.split("_p")
        if key in COMPARED:
            continue
        if percents and percents[0][:1].isdigit():
            values = [None] * len(percents) if value is None else value
            metrics[name] = {f"p{p}": x for p, x in zip(percents, values, strict=True)}
        elif key.endswith("_interval"):
            metrics[key] = dict(zip(("low", "high"), value, strict=True))
        else:
            metrics[key] = value
    text = f"{row['avoided']:.0%} of {row['balls']} balls avoided"
    return Results(metrics=metrics, lines=(text,))


if __name__ == "__main__":
    experiment(run, Config)
