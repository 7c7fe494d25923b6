"""What connects a graph better, and at which price: each option alone and all together.

    python -m experiments.avoidance.connectivity --config configs/avoidance/connectivity.toml \\
        --set clips=capture --out out/avoidance/connectivity

For each option and threshold: the time to an avoidance part from every frame (C1), the cells of
direction, height and arrival that are avoided from 90 % of the nodes (C2), how many parts are clear
of a ball (C3), the labels that can be entered (C4), frames no answer plays (C5), what the seams are
like beside uncut motion (C6), balls avoided at three times of arrival, and how far planted feet
travel and velocities jump in transitions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from experiments.avoidance.connectivity_plot import figure, price_figure
from experiments.avoidance.graphs import EMBEDDED_M, clips_of, speed_changes
from experiments.avoidance.success import genuine_parts
from experiments.avoidance.throws import arriving_in, standard_throws, wilson
from experiments.quality.price import price_of
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.coverage.connected import connected
from mgjax.avoidance.coverage.throws import measure_coverage
from mgjax.avoidance.many.attacks import select_batch
from mgjax.avoidance.prepared import prepared_for
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment
from mgjax.runs.points import Points

PAPER = GraphConfig(minima="all", label_quiet=0.0, label_overlap=0.0)
BETWEEN_M = 0.3
"""Parts this near to one another get a clip between them."""
OPTIONS: dict[str, tuple[GraphConfig, bool]] = {
    "paper": (PAPER, False),
    "allowed minima": (replace(PAPER, minima="allowed"), False),
    "quiet margins": (replace(PAPER, label_quiet=0.2), False),
    "overlap": (replace(PAPER, label_overlap=0.33), False),
    "ranges": (replace(PAPER, range_frames=8), False),
    "mirrored": (replace(PAPER, mirror=True), False),
    "interpolated": (replace(PAPER, interpolate_m=BETWEEN_M), False),
    "wide window": (PAPER, True),
    "margins": (GraphConfig(), False),
    "default": (GraphConfig(), True),
    "default, interpolated": (GraphConfig(interpolate_m=BETWEEN_M), True),
    "default, mirrored": (GraphConfig(mirror=True), True),
    "default, mirrored, interpolated": (GraphConfig(mirror=True, interpolate_m=BETWEEN_M), True),
}
"""Settings of the graph, and whether the search may widen its window."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is built and thrown."""

    clips: str = ""
    """Folder of clips with its labels.json; empty: the embedded clips."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    options: tuple[str, ...] = tuple(OPTIONS)
    """Which of the options."""
    thresholds_m: tuple[float, ...] = (EMBEDDED_M,)
    """Largest distances of a transition, m; 0: the automatic one of the paper's form."""
    balls: int = 200
    """Standard balls per time of arrival."""
    arrivals: tuple[float, ...] = (1.2, 0.8, 0.6)
    """Times until they are there, s."""
    nodes: int = 96
    """At how many nodes the cells are tried, from 16 directions each."""
    seams: int = 1000
    """Transitions that are measured, drawn at random."""
    seed: int = 0
    """Draws nodes, sides and heights; the same for all points."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "clips": "",
            "options": ("paper", "default"),
            "thresholds_m": (EMBEDDED_M,),
            "balls": 2,
            "arrivals": (1.2,),
            "nodes": 2,
            "seams": 20,
            "avoidance.checks": 4,
            "avoidance.capacity": 64,
        }


def run(config: Config, points: Points) -> Results:
    """Measures all points; those of an interrupted run with the same settings are taken over."""
    tasks: dict[str, tuple[Config, GraphConfig, AvoidanceConfig]] = {}
    named: list[dict[str, Any]] = []
    for name in config.options:
        settings, wide = OPTIONS[name]
        search = config.avoidance if wide else replace(config.avoidance, T_wide=0.0)
        for threshold in config.thresholds_m:
            at = replace(settings, threshold_m=threshold or None)
            tasks[f"{name}/{threshold:g}"] = (config, at, search)
            named.append({"option": name, "threshold_m": threshold})
    found = points.measure_all(tasks, _measured)
    rows = [name | row for name, row in zip(named, found.values(), strict=True)]
    return Results(
        metrics={"rows": rows},
        figures={"connectivity": lambda: figure(rows), "price": lambda: price_figure(rows)},
        lines=tuple(_line(row) for row in rows),
    )


def _measured(task: tuple[Config, GraphConfig, AvoidanceConfig]) -> dict[str, Any]:
    config, settings, search = task
    clips, labels = clips_of(config.clips, config.exclude)
    graph = build_graph(clips, labels=labels, config=settings)
    report = graph.report
    blended, captured = speed_changes(graph)
    found = measure_coverage(graph, nodes=config.nodes, seed=config.seed, config=search)
    throw: Callable[..., Any] = lambda g, s: _avoided(config, g, s, search)  # noqa: E731
    return {
        **{k: report[k] for k in ("transitions", "nodes", "edges", "labels_kept")},
        **{k: report[k] for k in ("labels_enterable", "genuine_enterable", "foot_slide_after")},
        "built_below_m": report["threshold_m"],
        "build_s": sum(report["seconds"].values()),
        "mb": (graph.root_translation.nbytes + graph.local_rotations.nbytes) / 1e6,
        "speed_change_m_s_p50_p95": np.percentile(blended, [50, 95]),
        "captured_speed_change_m_s_p50_p95": np.percentile(captured, [50, 95]),
        "connectivity": connected(graph, found, config=search),
        "seams": price_of(graph, config.seams),
        "avoided": {f"{s:g}": throw(graph, s) for s in config.arrivals},
        "genuine": throw(genuine_parts(graph), config.arrivals[0]),
    }


def _avoided(
    config: Config, graph: MotionGraph, arrives: float, search: AvoidanceConfig
) -> dict[str, Any]:
    """The standard balls that are avoided, and by what time scales."""
    if not len(graph.label_edge):
        return {"share": 0.0, "interval": wilson(0, config.balls), "time_scale": None}
    throws = arriving_in(standard_throws(config.balls, config.seed), arrives)
    answers = select_batch(
        prepared_for(graph, search),
        [throws.node_of(i, graph) for i in range(len(throws))],
        [throws.attack(i) for i in range(len(throws))],
        config=search,
    )
    avoided = answers.status == Status.AVOIDED.code
    scales = answers.time_scale[avoided]
    return {
        "share": float(avoided.mean()),
        "interval": wilson(int(avoided.sum()), len(throws)),
        "candidates": float(answers.candidates.mean()),
        "time_scale": np.percentile(scales, [5, 50, 95]).tolist() if len(scales) else None,
        "no_faster_than_1.15": float((avoided & (answers.time_scale >= 1 / 1.15)).mean()),
    }


def _line(row: dict[str, Any]) -> str:
    found = row["connectivity"]
    near = found["time_to_part_s"].get("any", {"p50": None, "p95": None})
    shares = ", ".join(f"{s} s {100 * x['share']:.0f}" for s, x in row["avoided"].items())
    return (
        f"{row['option']} below {row['built_below_m']:.3f} m: {row['transitions']} transitions,"
        f" {row['labels_enterable']} of {row['labels_kept']} labels enterable, part in"
        f" {near['p50']} / {near['p95']} s, {found['avoidable_cells']:.0%} of cells,"
        f" {found['clear_parts']['p50']} parts clear, avoided {shares} %, genuine"
        f" {row['genuine']['share']:.0%}; seams slide {row['seams']['skate_cm']:.2f} cm (uncut"
        f" {row['seams']['skate_cm_uncut']:.2f}), skate {row['seams']['skate_ratio']:.1%},"
        f" jerky {row['seams']['jerky']:.2%}, velocity jumps"
        f" {row['speed_change_m_s_p50_p95'][1]:.2f} m/s (p95)"
    )


if __name__ == "__main__":
    experiment(run, Config)
