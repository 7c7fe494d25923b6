"""How many balls are avoided: over speed, height, direction, arrival and the graph's threshold.

    python -m experiments.avoidance.success --config configs/avoidance/success.toml \\
        --set clips=capture --out out/avoidance/success

Without clips and graph it uses the embedded clips. The standard ball flies at 10 m/s from any side,
0.5–1.7 m high over the root, and arrives in 1.2 s; the character stands at a random node.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from experiments.avoidance.graphs import EMBEDDED_M, built, graph_of, speed_changes, with_parts
from experiments.avoidance.success_plot import conditions_figure, failures_figure, threshold_figure
from experiments.avoidance.throws import (
    OUTCOMES,
    Throws,
    answer,
    answer_unscaled,
    arriving_in,
    at_height,
    at_speed,
    from_sector,
    standard_throws,
)
from mgjax.avoidance.config import AvoidanceConfig, SpeedConfig
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment
from mgjax.runs.points import Points

SCALING = {
    "agreeing": SpeedConfig(V_fast=math.inf, V_slow=0.0, V_still=0.0),
    "printed": SpeedConfig(V_fast=0.3, V_slow=0.1, V_still=0.0),
    "any": SpeedConfig(V_fast=0.0, V_slow=math.inf, V_still=math.inf),
}
"""Which edges may change speed: none, so that the times must agree to half a frame; as the paper
prints it; all, both ways. ``measured`` is what the settings say, ``natural`` plays every candidate
as captured."""
PER_BALL = ("outcome", "clearance_m")


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is thrown at which graphs."""

    graph: str = ""
    """Folder of a graph; empty: built from the clips at threshold_m."""
    clips: str = ""
    """Folder of clips with its labels.json; empty: the embedded clips, or none beside a graph."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    threshold_m: float = EMBEDDED_M
    """Largest distance of a transition in the graph that is thrown at, m."""
    thresholds_m: tuple[float, ...] = (0.03, 0.05, 0.08, 0.12)
    """Thresholds of the curve, m."""
    mirrored: bool = True
    """The curve also for clips with their mirrored copies."""
    balls: int = 100
    """Balls per point."""
    seed: int = 0
    """Draws nodes, sides and heights; the same for all points."""
    speeds: tuple[float, ...] = (5.0, 10.0, 15.0, 20.0, 30.0)
    """Speeds of the balls, m/s."""
    heights: tuple[float, ...] = (0.3, 0.6, 0.9, 1.2, 1.5)
    """Heights at the body's axis, m."""
    sectors: int = 8
    """Directions from which balls come."""
    arrivals: tuple[float, ...] = (0.4, 0.8, 1.2, 1.6, 2.0)
    """Times from now until a ball is at the axis, s."""
    kinds: tuple[str, ...] = ()
    """Kinds of parts that are also tried alone; empty: all that the graph has."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "graph": "",
            "clips": "",
            "threshold_m": EMBEDDED_M,
            "thresholds_m": (EMBEDDED_M,),
            "mirrored": False,
            "balls": 1,
            "speeds": (8.0, 12.0),
            "heights": (0.6, 1.5),
            "sectors": 2,
            "arrivals": (1.0,),
            "kinds": ("duck",),
            "avoidance.checks": 4,
            "avoidance.capacity": 64,
        }


def genuine_parts(graph: MotionGraph) -> MotionGraph:
    """The same graph with only the labels of real evasions."""
    return with_parts(graph, graph.label_genuine)


def run(config: Config, points: Points) -> Results:
    """Measures all points; those of an interrupted run with the same settings are taken over."""
    throws = standard_throws(config.balls, config.seed)
    graph = _base(config)
    metrics: dict[str, Any] = {"graph": _described(graph)}
    metrics |= _conditions(config, graph, throws, points)
    metrics["scaling"] = _scaling(config, graph, throws, points)
    metrics["kinds"] = _kinds(config, graph, throws, points)
    with_clips = bool(config.clips or not config.graph)
    metrics["threshold"] = _curve(config, throws, points) if with_clips else None
    metrics["embedded"] = None
    if config.graph or config.clips:
        metrics["embedded"] = _both(config, graph_of(None), throws, points, "embedded")
    arrays = _per_ball(metrics, throws)
    lines = _lines(metrics)
    figures: dict[str, Any] = {
        "conditions": lambda: conditions_figure(metrics),
        "failures": lambda: failures_figure(metrics),
    }
    if metrics["threshold"]:
        figures["threshold"] = lambda: threshold_figure(metrics["threshold"])
    return Results(metrics=metrics, arrays=arrays, figures=figures, lines=tuple(lines))


def _base(config: Config) -> MotionGraph:
    if config.graph:
        return graph_of(config.graph)
    return built(config.clips, config.exclude, threshold_m=config.threshold_m)


def _described(graph: MotionGraph) -> dict[str, Any]:
    """Size and quality of a graph."""
    blended, captured = speed_changes(graph)
    keys = ("threshold_m", "transitions", "nodes", "edges", "labels_kept", "genuine_kept")
    return {
        **{key: graph.report[key] for key in (*keys, "foot_slide_before", "foot_slide_after")},
        "speed_change_m_s_p50_p95_max": np.percentile(blended, [50, 95, 100]),
        "captured_speed_change_m_s_p50_p95_max": np.percentile(captured, [50, 95, 100]),
    }


def _conditions(
    config: Config, graph: MotionGraph, throws: Throws, points: Points
) -> dict[str, Any]:
    """One row for each value of each condition, the others standard."""
    axes: dict[str, list[tuple[float, Throws]]] = {
        "speed": [(x, at_speed(throws, x)) for x in config.speeds],
        "height": [(x, at_height(throws, x)) for x in config.heights],
        "arrival": [(x, arriving_in(throws, x)) for x in config.arrivals],
        "direction": [
            (360.0 * i / config.sectors, from_sector(throws, i, config.sectors))
            for i in range(config.sectors)
        ],
    }
    rows: dict[str, Any] = {}
    for axis, values in axes.items():
        rows[axis] = []
        for value, thrown in values:
            row = points.measure(
                f"{axis}/{value:g}", lambda t=thrown: answer(graph, t, config.avoidance)
            )
            rows[axis].append({axis: value} | row)
    return rows


def _scaling(config: Config, graph: MotionGraph, throws: Throws, points: Points) -> dict[str, Any]:
    """The standard balls with and without time scaling."""
    settings = config.avoidance
    rows = _both(config, graph, throws, points, "scaling/measured")
    found = {"measured": rows["all"], "measured, genuine parts": rows["genuine"]}
    for name, speed in SCALING.items():
        changed = replace(settings, speed=speed)
        found[name] = points.measure(f"scaling/{name}", lambda c=changed: answer(graph, throws, c))
    found["natural"] = points.measure(
        "scaling/natural", lambda: answer_unscaled(graph, throws, settings)
    )
    return found


def _both(
    config: Config, graph: MotionGraph, throws: Throws, points: Points, key: str
) -> dict[str, Any]:
    """The standard balls with all parts, and with genuine ones only."""
    work: dict[str, Callable[[], MotionGraph]] = {
        "all": lambda: graph,
        "genuine": lambda: genuine_parts(graph),
    }
    return {
        name: points.measure(f"{key}/{name}", lambda g=g: _answer(g(), throws, config))
        for name, g in work.items()
    }


def _answer(graph: MotionGraph, throws: Throws, config: Config) -> dict[str, Any]:
    if not len(graph.label_edge):
        return {"balls": len(throws), "avoided": None, "parts": 0}
    return answer(graph, throws, config.avoidance) | {"parts": len(graph.label_edge)}


def _kinds(config: Config, graph: MotionGraph, throws: Throws, points: Points) -> dict[str, Any]:
    """The standard balls where only parts of one kind count."""
    kinds = np.array(graph.label_kind)
    return {
        kind: points.measure(
            f"kind/{kind}", lambda k=kind: _answer(with_parts(graph, kinds == k), throws, config)
        )
        for kind in config.kinds or sorted(set(graph.label_kind))
    }


def _curve(config: Config, throws: Throws, points: Points) -> list[dict[str, Any]]:
    """Success and quality of the transitions over the threshold, plain and with mirrored clips."""
    rows: list[dict[str, Any]] = []
    for mirror in (False, True)[: 1 + config.mirrored]:
        for threshold in config.thresholds_m:
            key = f"threshold/{threshold:g}/{'mirrored' if mirror else 'plain'}"

            def graph(threshold: float = threshold, mirror: bool = mirror) -> MotionGraph:
                return built(config.clips, config.exclude, threshold_m=threshold, mirror=mirror)

            row = points.measure(f"{key}/graph", lambda g=graph: _described(g()))
            for name, parts in (("all", lambda g: g), ("genuine", genuine_parts)):
                row = row | {
                    name: points.measure(
                        f"{key}/{name}", lambda g=graph, p=parts: _answer(p(g()), throws, config)
                    )
                }
            rows.append({"mirrored": mirror} | row)
    return rows


def _per_ball(metrics: dict[str, Any], throws: Throws) -> dict[str, np.ndarray]:
    """Takes what is known of each ball out of the metrics, into arrays [point, ball]."""
    found: dict[str, dict[str, list]] = {}

    def visit(place: str, value: Any) -> Any:
        if isinstance(value, list):
            return [visit(f"{place}/{i}", item) for i, item in enumerate(value)]
        if not isinstance(value, dict):
            return value
        if "outcome" in value:
            found[place] = {key: value[key] for key in PER_BALL}
        return {
            k: visit(f"{place}/{k}".strip("/"), v) for k, v in value.items() if k not in PER_BALL
        }

    metrics.update(visit("", metrics))
    gaps = [row["clearance_m"] for row in found.values()]
    return {
        "points": np.array(list(found)),
        "outcomes": np.array(OUTCOMES),
        "outcome": np.array([row["outcome"] for row in found.values()], np.int8),
        "clearance_m": np.array(gaps, dtype=np.float64),  # None becomes NaN
        "node": throws.node,
        "side": throws.side,
        "height": throws.height,
    }


def _lines(metrics: dict[str, Any]) -> list[str]:
    """The main shares for people."""

    def text(name: str, row: dict[str, Any]) -> str:
        if row["avoided"] is None:
            return f"{name}: no such part"
        low, high = row["avoided_interval"]
        return (
            f"{name}: {row['avoided']:.0%} avoided ({low:.0%} … {high:.0%}), {row['hit']:.0%} hit,"
            f" {row['no_candidate']:.0%} without candidate,"
            f" {row['no_time_scale']:.0%} not to be scaled"
        )

    lines = [text(name, row) for name, row in metrics["scaling"].items()]
    for row in metrics["threshold"] or []:
        name = f"{row['threshold_m']:.2f} m{', mirrored' if row['mirrored'] else ''}"
        lines += [text(name, row["all"]), text(f"{name}, genuine parts", row["genuine"])]
    return lines


if __name__ == "__main__":
    experiment(run, Config)
