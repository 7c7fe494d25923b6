"""Culling by slices (§5.2): what it drops that was clear, what it keeps that is hit, what it saves.

    python -m experiments.avoidance.culling --config configs/avoidance/culling.toml \\
        --set clips=capture --out out/avoidance/culling

Without a graph it uses the embedded clips. A candidate counts as clear if the exact check finds
that the path, and what can follow it, stays clear of the ball until that is gone.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np

from experiments.avoidance.culling_measure import (
    FORMS,
    Scene,
    answers_of,
    balls_of,
    check_all,
    times_of,
)
from experiments.avoidance.culling_plot import errors_figure, slices_figure, times_figure
from experiments.avoidance.graphs import graph_of
from experiments.avoidance.throws import standard_throws
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.culling.pictures import Form, Slices, build_slices, picture_bytes
from mgjax.avoidance.culling.rasterise import PIXEL_M
from mgjax.avoidance.prepared import prepared_for
from mgjax.runs.experiment import Results, experiment


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is thrown at which graph."""

    graph: str = ""
    """Folder of a graph; empty: that of the embedded clips."""
    clips: str = ""
    """Folder of clips with its labels.json, of which a graph is built; empty: the graph."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    balls: int = 200
    """Balls of the standard kind whose candidates are counted and timed."""
    checked: int = 60
    """Most candidates of a ball that are checked exactly, drawn at random."""
    thresholds: tuple[int, ...] = (0, 1, 2, 4, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
    """Numbers of pixels up to which a candidate is kept."""
    paper_threshold: int = 96
    """The one with which times and answers are measured, for whole-edge pictures."""
    binned_threshold: int = 32
    """The same for pictures per 0.1 s."""
    repeats: int = 5
    """Measurements of each time, in turn; their median counts."""
    seed: int = 0
    """Draws the balls, and the candidates that are checked."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "graph": "",
            "clips": "",
            "balls": 3,
            "checked": 4,
            "repeats": 1,
            "thresholds": (0, 24, 96),
            "avoidance.capacity": 8,
            "avoidance.checks": 4,
        }


def run(config: Config) -> Results:
    """Counts errors over thresholds, compares the answers, and measures times."""
    graph, settings = graph_of(config.graph, config.clips, config.exclude), config.avoidance
    tables = prepared_for(graph, settings).tables
    start = time.perf_counter()
    slices = build_slices(tables, graph.body_scale)
    build_s = time.perf_counter() - start
    scene = Scene(
        graph=graph,
        tables=tables,
        slices=jax.device_put(slices),
        settings=settings,
        thresholds={"paper": config.paper_threshold, "binned": config.binned_threshold},
    )
    balls = balls_of(scene, standard_throws(config.balls, config.seed))
    rows = check_all(scene, balls, config.checked, config.seed)
    errors = {form: _errors(rows, form, config.thresholds) for form in FORMS}
    metrics = {
        "graph": {k: graph.report[k] for k in ("threshold_m", "nodes", "edges", "labels_kept")},
        "bytes": {form: picture_bytes(getattr(slices, form)) for form in FORMS},
        "pictures": {form: len(getattr(slices, form).first) for form in FORMS},
        "balls": len(balls),
        "checked": len(rows["clear"]),
        "clear": float(rows["clear"].mean()),
        "errors": errors,
        "answers": answers_of(scene, balls),
    }
    timed = times_of(scene, balls, config.repeats)
    edge = _shown(slices, tables.part_edge)
    return Results(
        metrics=metrics,
        timings={"build_s": build_s, "by_candidates": timed},
        arrays=rows,
        figures={
            "errors": lambda: errors_figure(errors, scene.thresholds),
            "times": lambda: times_figure(timed),
            "slices": lambda: slices_figure(slices, edge),
        },
        lines=tuple(_lines(metrics, timed, build_s, scene.thresholds)),
    )


def _errors(
    rows: dict[str, np.ndarray], form: Form, thresholds: tuple[int, ...]
) -> list[dict[str, Any]]:
    """Shares kept, falsely culled (of the clear ones) and falsely kept (of those hit).

    ``balls_lost`` is the share of balls of which clear candidates are known and none is kept.
    """
    clear, ball = rows["clear"], rows["ball"]
    found = []
    for threshold in thresholds:
        keep = rows[form] <= threshold
        some, left = (np.unique(ball[mask]) for mask in (clear, clear & keep))
        found.append(
            {
                "threshold": threshold,
                "kept": float(keep.mean()),
                "false_culls": _share(~keep & clear, clear),
                "false_keeps": _share(keep & ~clear, ~clear),
                "balls_lost": 1 - len(left) / len(some) if len(some) else None,
            }
        )
    return found


def _share(part: np.ndarray, whole: np.ndarray) -> float | None:
    return float(part.sum() / whole.sum()) if whole.any() else None


def _shown(slices: Slices, part_edge: np.ndarray) -> int:
    """The edge with an avoidance part that has the largest picture not wider than 2 m."""
    size = np.asarray(slices.paper.size)[part_edge]
    area = np.where((size * PIXEL_M).max(axis=1) <= 2.0, size.prod(axis=1), 0)
    return int(part_edge[np.argmax(area)])


def _lines(
    metrics: dict[str, Any],
    timed: list[dict[str, Any]],
    build_s: float,
    thresholds: dict[Form, int],
) -> list[str]:
    """The main figures for people."""

    def text(share: float | None) -> str:
        return "none" if share is None else f"{share:.1%}"

    sizes = metrics["bytes"]
    lines = [
        f"slices: built in {build_s:.1f} s; {sizes['paper'] / 1e6:.1f} MB for whole edges,"
        f" {sizes['binned'] / 1e6:.1f} MB per 0.1 s",
        f"{metrics['checked']} candidates of {metrics['balls']} balls checked,"
        f" {metrics['clear']:.1%} clear",
    ]
    for form, rows in metrics["errors"].items():
        lines += [
            f"{form}, at most {row['threshold']} pixels: {row['kept']:.1%} kept,"
            f" {text(row['false_culls'])} false culls, {text(row['false_keeps'])} false keeps"
            for row in rows
            if row["threshold"] == thresholds[form]
        ]
    for form, row in metrics["answers"].items():
        lines.append(f"{form}: " + ", ".join(f"{k} {v:.1%}" for k, v in row.items()))
    for row in timed:
        lines.append(
            f"{row['least']}–{row['most']} candidates ({row['balls']} balls): search"
            f" {row['search_ms']:.2f} ms, timing alone {row['timing_ms']:.2f}; "
            + "; ".join(
                f"{form} culls in {row[form]['cull_ms']:.2f}, then {row[form]['search_ms']:.2f} ms,"
                f" keeping {row[form]['kept']:.0%}, saved {row[form]['search_saved_ms']:.2f}"
                for form in FORMS
            )
        )
    return lines


if __name__ == "__main__":
    experiment(run, Config)
