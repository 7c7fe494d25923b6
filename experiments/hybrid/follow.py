"""How well and how quickly walks follow paths: line, circle, square, S-curve and figure eight.

    python -m experiments.hybrid.follow --config configs/hybrid/follow.toml \\
        --set clips=capture/locomotion/cmu16 --out out/hybrid/follow

Without clips and graph it uses the embedded clips. The search of a public implementation of motion
graphs (ethanngam) takes 0.035–0.30 s per second of motion.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.hybrid.shapes import graph_of, sketches
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.hybrid.config import PathConfig
from mgjax.hybrid.paths.result import PathResult
from mgjax.hybrid.paths.search import follow
from mgjax.pictures.walk import played_edges, top_view
from mgjax.runs.experiment import Results, experiment

METHODS = ("beam", "exact")
PEER_S = (0.035, 0.30)
"""Search per second of motion of a peer, s."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Which graph follows which paths."""

    graph: str = ""
    """Folder of a graph; empty: built from the clips."""
    clips: str = ""
    """Folder of clips; empty: the embedded ones."""
    neighbourhood: int = 5
    """Of the graph's minima, if it is built."""
    shapes: tuple[str, ...] = ("line", "circle", "square", "s_curve", "eight")
    """Which paths."""
    scale: float = 1.0
    """Size of the paths."""
    repeats: int = 5
    """Searches that are timed, after a first one."""
    path: PathConfig = field(default_factory=PathConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"graph": "", "clips": "", "shapes": ("line",), "scale": 0.3, "repeats": 1}


def run(config: Config) -> Results:
    """Follows every path by both methods."""
    graph = graph_of(config.graph, config.clips, config.neighbourhood)
    paths = {name: sketches(config.scale)[name] for name in config.shapes}
    rows: dict[str, dict[str, Any]] = {}
    timings: dict[str, dict[str, Any]] = {}
    walks: dict[tuple[str, str], PathResult] = {}
    for name, sketch in paths.items():
        for method in METHODS:
            settings = replace(config.path, method=method)
            found = [follow(graph, sketch, config=settings) for _ in range(config.repeats + 1)]
            walks[name, method] = walked = found[0]
            key = f"{name}_{method}"
            rows[key] = _row(graph, walked)
            speed = [w.search_s / w.seconds for w in found[1:]]
            timings[key] = {
                "search_s_per_s_median": float(np.median(speed)),
                "search_s_per_s_min": min(speed),
                "prepare_s": walked.prepare_s,
            }
    lines = [_line(key, row, timings[key]) for key, row in rows.items()]
    lines.append(f"a peer: {PEER_S[0]}–{PEER_S[1]} s of search per second of motion")
    metrics = {
        "transitions": graph.report["transitions"],
        "threshold_m": graph.report["threshold_m"],
        "peer_search_s_per_s": PEER_S,
        "paths": rows,
    }

    def draw() -> Figure:
        figure = Figure(figsize=(4.5 * len(paths), 9), layout="constrained")
        grid = figure.subplots(2, len(paths), squeeze=False)
        for column, (name, sketch) in enumerate(paths.items()):
            for line, method in enumerate(METHODS):
                walked = walks[name, method]
                top_view(grid[line, column], graph, sketch, walked)
                grid[line, column].set_title(
                    f"{name}, {method}: mean {100 * walked.mean_distance:.1f} cm, largest"
                    f" {100 * walked.largest_distance:.1f} cm",
                    fontsize=9,
                )
        return figure

    return Results(metrics=metrics, timings=timings, figures={"follow": draw}, lines=tuple(lines))


def _row(graph: MotionGraph, walked: PathResult) -> dict[str, Any]:
    return {
        "status": walked.status,
        "seconds": walked.seconds,
        "error_m2": walked.error,
        "mean_distance_m": walked.mean_distance,
        "largest_distance_m": walked.largest_distance,
        "expanded": walked.expanded,
        "pruned": walked.pruned,
        "horizons": walked.windows,
        "horizons_proven": walked.proven,
        "foot_slide_m_per_frame": walked.slide,
        "foot_slide_share": walked.slide_share,
        "share_of_transitions": float((played_edges(graph, walked) == NO_CLIP).mean()),
        "slowest_0_3_s_m_s": float(np.convolve(walked.track.speed, np.ones(9) / 9, "valid").min()),
    }


def _line(key: str, row: dict[str, Any], timing: dict[str, Any]) -> str:
    return (
        f"{key:14} {row['status']:8} {row['seconds']:5.1f} s, error {row['error_m2']:6.2f} m²,"
        f" mean {100 * row['mean_distance_m']:4.1f} cm, largest"
        f" {100 * row['largest_distance_m']:4.1f} cm, search"
        f" {1000 * timing['search_s_per_s_median']:5.1f} ms/s, proven"
        f" {row['horizons_proven']}/{row['horizons']}, slide"
        f" {1000 * row['foot_slide_m_per_frame']:.1f} mm"
    )


if __name__ == "__main__":
    experiment(run, Config)
