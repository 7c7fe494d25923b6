"""What refinement gains: balls avoided without and with it, how near the misses were, how large
the changes are.

    python -m experiments.avoidance.refining --config configs/avoidance/refining.toml \\
        --set clips=capture --out out/avoidance/refining

Standard balls at some thresholds, there in some times, with all parts and with genuine ones alone.
A near miss is a ball that is hit without refinement; how near is the depth of the contact of the
walk that is touched least. All are judged as written.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter, process_time
from typing import Any, TypeAlias

import numpy as np

from experiments.avoidance.attack_strips import Strip, drawn_results, spread
from experiments.avoidance.graphs import built, graph_of
from experiments.avoidance.success import genuine_parts
from experiments.avoidance.throws import (
    OUTCOMES,
    Throws,
    arriving_in,
    outcome_of,
    percentiles,
    standard_throws,
)
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.checks.written import sphere_trajectory
from mgjax.avoidance.choice.selection import Selection, refine, select
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.refinement.refine import refine_walks
from mgjax.avoidance.refinement.refinement import Refinement
from mgjax.core.errors import AttackError
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment

NEAR_M = (0.05, 0.12)
"""Depths up to which misses are counted apart."""
Near: TypeAlias = tuple[MotionGraph, Selection, Attack]
"""An answer that is hit, and what hits it."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is thrown at which graphs."""

    graph: str = ""
    """Folder of a graph; empty: built from the clips."""
    clips: str = ""
    """Folder of clips with its labels.json; empty: the graph, or the embedded clips."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    arrives: tuple[float, ...] = (1.2, 0.8, 0.6)
    """When balls are there, s from now; at the automatic threshold with all parts."""
    thresholds: tuple[float, ...] = (0.16,)
    """Of further graphs built from the clips, with the first time of arrival."""
    genuine: bool = True
    """Adds a row with only the parts that are real evasions, with the first time of arrival."""
    balls: int = 400
    """Standard balls a row."""
    strips: int = 10
    """Refinements that are drawn."""
    timed: int = 30
    """Near misses for which the time to change one path is measured, when all else is done."""
    seed: int = 0
    """Draws nodes, sides and heights."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search; ``refine`` is switched off for the comparison."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        few = {
            "arrives": (0.8,),
            "thresholds": (),
            "genuine": False,
            "balls": 6,
            "strips": 1,
            "timed": 1,
        }
        return {"graph": "", "clips": "", **few}


@dataclass(frozen=True, kw_only=True)
class Case:
    """One row: the threshold of its graph, which parts, how soon the balls are there."""

    arrives: float
    threshold_m: float | None = None
    genuine: bool = False


def run(config: Config) -> Results:
    """Throws all balls twice."""
    rows: list[dict[str, Any]] = []
    drawn: list[Strip] = []
    near: list[Near] = []
    for case in _cases(config):
        row, found, misses = _measured(config, case, _graph(config, case))
        rows.append(row)
        drawn += found
        near += misses
    results = drawn_results(rows, drawn, config.strips, _line)
    timed = one_path(near, config.timed, config.avoidance)
    if timed is None:
        return results
    lines = (*results.lines, _timed_line(timed))
    return replace(results, metrics={**results.metrics, "one_path": timed}, lines=lines)


def _cases(config: Config) -> list[Case]:
    first = config.arrives[0]
    cases = [Case(arrives=arrives) for arrives in config.arrives]
    cases += [Case(arrives=first, genuine=True)] if config.genuine else []
    # A graph that is given has the threshold that it has.
    further = config.thresholds if config.clips else ()
    return cases + [Case(arrives=first, threshold_m=threshold) for threshold in further]


def _graph(config: Config, case: Case) -> MotionGraph:
    if config.clips:
        graph = built(config.clips, config.exclude, threshold_m=case.threshold_m)
    else:
        graph = graph_of(config.graph or None)
    return genuine_parts(graph) if case.genuine else graph


def _measured(
    config: Config, case: Case, graph: MotionGraph
) -> tuple[dict[str, Any], list[Strip], list[Near]]:
    """One row, its refinements, and its misses that a move within the cap may clear."""
    throws = arriving_in(standard_throws(config.balls, config.seed), case.arrives)
    plain, refined = (
        _answers(graph, throws, replace(config.avoidance, refine=how)) for how in ("off", "near")
    )
    misses: list[tuple[float, bool]] = []
    near: list[Near] = []
    strips: list[Strip] = []
    changes: list[Refinement] = []
    for number, (without, with_) in enumerate(zip(plain, refined, strict=True)):
        if without is None or with_ is None:
            continue
        if without.status == "hit" and without.clearance_m is not None:
            misses.append((-without.clearance_m, with_.status == "avoided"))
            if -without.clearance_m < config.avoidance.refine_max_m:
                near.append((graph, without, throws.attack(number)))
        if with_.refinement is not None:
            change = with_.refinement
            title = (
                f"ball {number}, there in {case.arrives:g} s: {100 * change.largest_m:.1f} cm,"
                f" {change.largest_deg:.0f}°; clearance {100 * change.clearance_before_m:.1f} to"
                f" {100 * change.clearance_m:.1f} cm; {1000 * change.shift_s:+.0f} ms"
            )
            attack = throws.attack(number)
            strips.append(
                Strip(
                    title=title,
                    skeleton=graph.skeleton,
                    motion=with_.motion,
                    attack=attack,
                    time=_nearest(graph, attack, with_.motion),
                )
            )
            changes.append(change)
    depth, mended = np.array([d for d, _ in misses]), np.array([m for _, m in misses], bool)
    row = {
        "threshold_m": float(graph.report["threshold_m"]),
        "arrives": case.arrives,
        "genuine": case.genuine,
        "without": _shares(plain),
        "with": _shares(refined),
        "refined": len(changes),
        "later": sum(change.shift_s != 0 for change in changes),
        "largest_cm_p5_p50_p95": percentiles([100 * c.largest_m for c in changes], (5, 50, 95)),
        "largest_deg_p5_p50_p95": percentiles([c.largest_deg for c in changes], (5, 50, 95)),
        "near_misses": [
            {
                "up_to_m": limit,
                "misses": int((depth <= limit).sum()),
                "mended": int(mended[depth <= limit].sum()),
            }
            for limit in NEAR_M
        ],
    }
    return row, strips, near


def one_path(near: list[Near], wanted: int, config: AvoidanceConfig) -> dict[str, Any] | None:
    """What it takes to change one path, compiled and warm: median and 95th percentile, ms.

    ``path`` is the change with its check, ``answer`` that and its motion, written; ``processor`` is
    the time of all threads.
    """
    chosen = [near[k] for k in spread(len(near), wanted)]
    taken: dict[str, list[tuple[float, float]]] = {"path": [], "answer": []}
    cleared = 0
    for warm in (False, True):
        for graph, selection, attack in chosen:
            prepared = prepared_for(graph, config)
            own = for_body(config, graph.body_scale)
            for name, call in (
                ("path", partial(refine_walks, prepared, [selection.walk], attack, own)),
                ("answer", partial(refine, prepared, selection, attack, config=config)),
            ):
                began = perf_counter(), process_time()
                found = call()
                seconds = perf_counter() - began[0], process_time() - began[1]
                if warm:
                    taken[name].append(seconds)
                    cleared += isinstance(found, Selection) and found.status == "avoided"
    if not chosen:
        return None
    times = {
        f"{name}_{clock}_ms_p50_p95": percentiles([1000 * pair[k] for pair in pairs], (50, 95))
        for name, pairs in taken.items()
        for k, clock in enumerate(("wall", "processor"))
    }
    return {"misses": len(chosen), "cleared": cleared, **times}


def _timed_line(timed: dict[str, Any]) -> str:
    parts = [f"one path of {timed['misses']}, {timed['cleared']} of them cleared:"]
    for name in ("path", "answer"):
        for clock in ("wall", "processor"):
            p50, p95 = timed[f"{name}_{clock}_ms_p50_p95"]
            parts.append(f"{name} {p50:.0f} ms (p95 {p95:.0f}) {clock};")
    return " ".join(parts).rstrip(";")


def _nearest(graph: MotionGraph, attack: Attack, motion: Motion) -> float:
    """When a ball comes nearest to the body's spheres, s."""
    spheres = preset_spheres(graph.skeleton)
    trace = sphere_trajectory(graph, spheres, motion, stop=attack.end)
    gaps = np.linalg.norm(trace.centres - attack.at(trace.times)[:, :1], axis=-1) - spheres.radii
    return float(trace.times[gaps.min(axis=1).argmin()])


def _answers(graph: MotionGraph, throws: Throws, config: AvoidanceConfig) -> list[Selection | None]:
    """What each ball is answered by; None where it begins inside the body."""
    found: list[Selection | None] = []
    for number in range(len(throws)):
        try:
            node = throws.node_of(number, graph)
            found.append(select(graph, node, throws.attack(number), config=config))
        except AttackError:
            found.append(None)
    return found


def _shares(answers: list[Selection | None]) -> dict[str, float]:
    outcomes = ["refused" if x is None else outcome_of(x) for x in answers]
    return {name: outcomes.count(name) / len(outcomes) for name in OUTCOMES}


def _line(row: dict[str, Any]) -> str:
    parts = ", genuine parts" if row["genuine"] else ""
    text = (
        f"{row['threshold_m']:.3f} m, {row['arrives']:g} s{parts}:"
        f" avoided {row['without']['avoided']:.1%}, refined {row['with']['avoided']:.1%}"
    )
    for near in row["near_misses"]:
        text += f"; up to {100 * near['up_to_m']:.0f} cm {near['mended']} of {near['misses']}"
    if row["refined"]:
        text += (
            f"; {row['refined']} changed, {row['later']} of them earlier or later, by"
            f" {row['largest_cm_p5_p50_p95'][1]:.1f} cm,"
            f" {row['largest_deg_p5_p50_p95'][1]:.0f}°"
        )
    return text


if __name__ == "__main__":
    experiment(run, Config)
