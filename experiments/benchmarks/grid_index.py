"""The grid index of a graph: build, size, paths per cell, and lookups against enumeration.

Balls at 10 m/s come from any side, 0.5 to 1.7 m high at the body's axis, and arrive in 1.2 s at
random nodes.

    python -m experiments.benchmarks.grid_index --set clips=capture --out out/grid_index
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.avoidance.graphs import graph_of
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.crop import crop_attack
from mgjax.avoidance.attacks.transform import of_size
from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.avoidance.candidates.enumerate import enumerate_candidates
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.index import GridIndex
from mgjax.avoidance.index.swept_cells import swept_cells
from mgjax.avoidance.prepared import prepared_for
from mgjax.core.xla.compilation import one_thread
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment

WARM, NODES = 50, 60
MOST = 512
"""Nodes with more paths are left out of the count of paths per cell."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings."""

    graph: str = ""
    """Folder of a graph; empty: that of the embedded clips."""
    clips: str = ""
    """Folder of clips with its labels.json, of which a graph is built; empty: the graph."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    balls: int = 500
    """That are looked up."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"graph": "", "clips": "", "balls": 3}


def run(config: Config) -> Results:
    graph, settings = graph_of(config.graph, config.clips, config.exclude), AvoidanceConfig()
    tables = prepared_for(graph, settings).tables
    built, index = build_row(graph)
    found = lookup_row(graph, tables, index, settings, config.balls)
    measured = {k: v for k, v in (built | found).items() if k.endswith(("_s", "_ms"))}
    counted = {k: v for k, v in (built | found).items() if k not in measured and k != "case"}
    line = (
        f"{counted['candidates']} walks in {counted['megabytes']:.2f} MB; look-up"
        f" {measured['lookup_median_ms']:.2f} ms, enumeration"
        f" {measured['enumerate_median_ms']:.2f} ms"
    )
    return Results(metrics=counted, timings=measured, lines=(line,))


def ball(rng: np.random.Generator) -> Attack:
    """From 5 m away, at the vertical above the character."""
    side, height = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.7)
    return ball_from(side, height)


def build_row(graph: MotionGraph) -> tuple[dict[str, Any], GridIndex]:
    """Builds twice: the first time also compiles, or loads the programs."""
    start = time.perf_counter()
    build_index(graph)
    first, start, busy = time.perf_counter() - start, time.perf_counter(), time.process_time()
    index = build_index(graph)
    seconds, cpu = time.perf_counter() - start, time.process_time() - busy
    rng = np.random.default_rng(0)
    filled = np.flatnonzero(index.nearest <= index.horizon * index.half_frames + 1e-6)
    some = rng.choice(filled, min(NODES, len(filled)), replace=False)
    per_cell = [index.paths_per_cell(int(node), MOST) for node in some]
    per_cell = [counts for counts in per_cell if counts is not None]
    counts = np.concatenate(per_cell)
    row = {
        "case": "build",
        "nodes": graph.num_nodes,
        "build_s": seconds,
        "build_cpu_s": cpu,
        "compile_s": max(first - seconds, 0.0),
        "megabytes": index.nbytes / 1e6,
        "megabytes_per_hour": index.nbytes / 1e6 * 3600 / _seconds(graph),
        "candidates": index.report["paths"],
        "candidates_per_node": index.report["paths"] / graph.num_nodes,
        "nodes_counted": len(per_cell),
        "cells_per_node": len(counts) / len(per_cell),
        "paths_per_cell_mean": float(counts.mean()),
        "paths_per_cell_p95": float(np.percentile(counts, 95)),
        **{name: index.report[name] for name in ("arrivals", "jumps", "paths_s", "parts_s")},
    }
    return row, index


def _seconds(graph: MotionGraph) -> float:
    """How much motion a graph was made of, s."""
    return float((graph.clip_stops - graph.clip_starts).sum()) / graph.frame_rate


def lookup_row(
    graph: MotionGraph, tables: EdgeTables, index: GridIndex, config: AvoidanceConfig, balls: int
) -> dict[str, Any]:
    """Seeded balls at random nodes, each looked up and enumerated."""
    config = for_body(config, graph.body_scale)
    rng = np.random.default_rng(0)
    times, found, all_ = [], [], []
    for _ in range(WARM + balls):
        node, attack = int(rng.integers(graph.num_nodes)), ball(rng)
        crop = crop_attack(attack, radius=config.crop_radius_m, height=config.crop_height_m)
        assert crop is not None
        clock = [time.perf_counter()]
        cells = swept_cells(of_size(attack, 1 / index.scale), crop)
        clock.append(time.perf_counter())
        paths = None if cells is None else index.in_time(node, crop.middle, config.T_window)
        candidates = None
        if cells is not None and paths is not None:
            candidates = index.walks(paths[index.touched_by(paths, cells)])
        clock.append(time.perf_counter())
        every = enumerate_candidates(
            graph, tables, node, crop.middle, window=config.T_window, capacity=1_000_000
        )
        clock.append(time.perf_counter())
        times.append(np.diff(clock))
        found.append(-1 if candidates is None else len(candidates.part))
        all_.append(len(every.part))
    cells_ms, lookup_ms, enumerate_ms = 1e3 * np.array(times)[WARM:].T
    hits, every_ = np.array(found)[WARM:], np.array(all_)[WARM:]
    row: dict[str, Any] = {"case": "lookup", "balls": balls}
    for name, values in (("cells", cells_ms), ("lookup", lookup_ms), ("enumerate", enumerate_ms)):
        row[f"{name}_median_ms"] = float(np.median(values))
        row[f"{name}_p95_ms"] = float(np.percentile(values, 95))
    return row | {
        "found_mean": float(np.maximum(hits, 0).mean()),
        "enumerated_mean": float(every_.mean()),
        "answered": float((hits > 0).mean()),
        "answerable": float((every_ > 0).mean()),
        "not_covered": float((hits < 0).mean()),
    }


if __name__ == "__main__":
    one_thread()
    experiment(run, Config)
