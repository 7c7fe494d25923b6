"""Success over reaction time, also with no edge much faster than captured, and what recovers.

    python -m experiments.avoidance.reaction_time --config \\
        configs/avoidance/reaction_time.toml --set clips=capture --out out/avoidance/reaction_time

Standard balls that are there in 0.3 … 2 s, answered as it is written: feet kept, near misses
refined. An answer has recovered where it avoids the ball, is at a node of the graph again within a
second after the ball has gone, and until then shows no fault: feet that skate no more, windows that
are no jerkier, limbs and feet no deeper than in uncut capture by the same code (1.1 times the 95th
percentile for feet, 0.5 % of the windows above its 99.9 % quantile of jerk, 1 cm, 5 mm). So many
pieces of uncut capture of the same length pass.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.avoidance.graphs import built, graph_of
from experiments.avoidance.recovery import Recovery
from experiments.avoidance.throws import Throws, arriving_in, percentiles, standard_throws, wilson
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.selection import Selection, select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.core.errors import AttackError
from mgjax.runs.experiment import Results, experiment
from mgjax.runs.points import Points


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is thrown at which graph, and how soon."""

    graph: str = ""
    """Folder of a graph; empty: built from the clips at the automatic threshold."""
    clips: str = ""
    """Folder of clips with its labels.json; empty: the graph, or the embedded clips."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    balls: int = 400
    """Standard balls per point."""
    arrives: tuple[float, ...] = (0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 2.0)
    """Reaction times: when balls are there, s from now."""
    fastest: tuple[float, ...] = (0.0, 1.15)
    """Largest speed-ups of an edge; 0: what the settings allow."""
    recovers: bool = True
    """Whether to look at what follows."""
    seed: int = 0
    """Draws nodes, sides and heights; the same for all points."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"graph": "", "clips": "", "balls": 3, "arrives": (0.6, 1.2), "fastest": (0.0, 1.15)}


def run(config: Config, points: Points) -> Results:
    """Measures all points; those of an interrupted run with the same settings are taken over."""
    graph = built(config.clips, config.exclude, threshold_m=None) if config.clips else None
    prepared = prepared_for(graph or graph_of(config.graph or None), config.avoidance)
    recovery = Recovery(prepared) if config.recovers else None
    rows: list[dict[str, Any]] = []
    for fastest in config.fastest:
        search = limited(config.avoidance, fastest)
        for arrives in config.arrives:
            throws = arriving_in(standard_throws(config.balls, config.seed), arrives)

            def work(search: AvoidanceConfig = search, throws: Throws = throws) -> dict[str, Any]:
                return measured(prepared, throws, search, recovery)

            row = points.measure(f"{fastest:g}/{arrives:g}", work)
            rows.append({"fastest": fastest, "arrives": arrives} | row)
    return Results(
        metrics={"rows": rows},
        figures={"reaction_time": lambda: figure(rows)},
        lines=tuple(_line(row) for row in rows),
    )


def limited(config: AvoidanceConfig, fastest: float) -> AvoidanceConfig:
    """The settings with a limit on speeding up edges; 0 leaves them as they are."""
    if not fastest:
        return config
    return replace(config, limit_scale=True, energy=replace(config.energy, E_fast=fastest))


def measured(
    prepared: Prepared, throws: Throws, search: AvoidanceConfig, recovery: Recovery | None
) -> dict[str, Any]:
    """The shares of one point, of answers as they are written."""
    answers = [
        answer for i in range(len(throws)) if (answer := _answer(prepared, throws, i, search))
    ]
    avoided = [answer for answer in answers if answer.status == Status.AVOIDED]
    none = sum(answer.status == Status.NO_CANDIDATE for answer in answers)
    row = {
        "avoided": len(avoided) / len(throws),
        "avoided_interval": wilson(len(avoided), len(throws)),
        "no_candidate": none / len(throws),
        "refined": sum(answer.refinement is not None for answer in avoided) / len(throws),
        "time_scale_p5_p50_p95": percentiles(
            [answer.time_scale for answer in avoided if answer.time_scale], (5, 50, 95)
        ),
    }
    if recovery is None:
        return row
    found = recovery.of(avoided, throws.arrives)
    recovered = found.pop("recovered")
    return row | {
        "recovered": recovered / len(throws),
        "recovered_interval": wilson(recovered, len(throws)),
        **found,
    }


def _answer(
    prepared: Prepared, throws: Throws, number: int, search: AvoidanceConfig
) -> Selection | None:
    """What a ball is answered by; None where it begins inside the body."""
    node = throws.node_of(number, prepared.graph)
    try:
        return select(prepared, node, throws.attack(number), config=search)
    except AttackError:
        return None


def figure(rows: list[dict[str, Any]]) -> Figure:
    """Shares of the balls over the reaction time."""
    drawn = Figure(figsize=(7.5, 4.8), layout="constrained")
    axes = drawn.subplots()
    for number, fastest in enumerate(dict.fromkeys(row["fastest"] for row in rows)):
        own = [row for row in rows if row["fastest"] == fastest]
        own.sort(key=lambda row: row["arrives"])
        x = [row["arrives"] for row in own]
        limit = f", no edge faster than {fastest:g} ×" if fastest else ""
        low, high = ([100 * row["avoided_interval"][side] for row in own] for side in (0, 1))
        axes.fill_between(x, low, high, color=f"C{number}", alpha=0.15, linewidth=0)
        for key, style in (("avoided", "o-"), ("recovered", "s--")):
            if key in own[0]:
                y = [np.nan if row[key] is None else 100 * row[key] for row in own]
                axes.plot(x, y, style, color=f"C{number}", label=key + limit)
    axes.set(xlabel="reaction time, s", ylabel="standard balls, %", ylim=(0, 100))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize=8)
    return drawn


def _share(value: float | None) -> str:
    """In percent; of nothing there is none."""
    return "none" if value is None else f"{value:.0%}"


def _line(row: dict[str, Any]) -> str:
    low, high = row["avoided_interval"]
    limit = f" below {row['fastest']:g} ×" if row["fastest"] else ""
    text = f"{row['arrives']:g} s{limit}: {row['avoided']:.0%} avoided ({low:.0%} … {high:.0%})"
    if "recovered" in row:
        text += (
            f", {_share(row['recovered'])} recovered; of those avoided"
            f" {_share(row['at_a_node'])} at a node"
            f" within 1 s, without fault {_share(row['without_fault'])}"
            f" (uncut capture {_share(row['uncut_without_fault'])}): G1 {_share(row['feet'])}"
            f" ({_share(row['uncut_feet'])}),"
            f" G2 {_share(row['smooth'])} ({_share(row['uncut_smooth'])}),"
            f" G3 {_share(row['solid'])} ({_share(row['uncut_solid'])})"
        )
    return text


if __name__ == "__main__":
    experiment(run, Config)
