"""Building the graph of walks and runs: time per step, quality, and the pictures of the paper.

    python -m experiments.hybrid.build --config configs/hybrid/build.toml \\
        --set clips=capture/locomotion/cmu16 --out out/hybrid/build

Without clips it uses the embedded ones. The paper builds the graph of 8 clips in 40 s. Published
slides of planted feet: 0.0132–0.0147 m per transition frame, and 0.021 is noticed.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.hybrid.build_plot import error_figure, fewer_figure, unrolled_figure
from experiments.hybrid.shapes import EMBEDDED_M, clips_of, graph_config, sketches
from mgjax.clips.types import Clip
from mgjax.core.contacts import foot_joints
from mgjax.core.errors import GraphError
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.plants import foot_slide
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.hybrid.config import PathConfig
from mgjax.hybrid.paths.search import follow
from mgjax.runs.experiment import Results, experiment

PAPER_S = 40.0
PUBLISHED_SLIDE_M = {"peer": (0.0132, 0.0147), "noticeable": 0.021}
RUN_M_S = 2.2
"""A clip with a faster mean is a run."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Which clips, and what is tried with them."""

    clips: str = ""
    """Folder of clips; empty: the embedded ones."""
    names: tuple[str, ...] = ()
    """The clips of the timed graph (the paper: 8); empty: all."""
    fewer: tuple[str, ...] = ("walk",)
    """The clips of the smaller graph that follows the same path."""
    neighbourhood: int = 1
    """Of the graph's minima."""
    thresholds_m: tuple[float, ...] = (0.08, 0.09, 0.10, 0.11, 0.12, 0.13, 0.14, 0.16, 0.18, 0.20)
    """Thresholds at which it is reported what is left of all clips."""
    repeats: int = 7
    """Builds that are timed, after a first one."""
    cold: bool = True
    """Also from a new process without any cache of compiled programs."""
    path: str = "s_curve"
    """The path that is followed with all clips and with fewer."""
    scale: float = 1.0
    """Its size."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "clips": "",
            "names": ("walk", "walk_curve"),
            "fewer": ("walk",),
            "neighbourhood": 10,
            "thresholds_m": (EMBEDDED_M,),
            "repeats": 1,
            "cold": False,
            "path": "line",
            "scale": 0.3,
        }


def run(config: Config) -> Results:
    """Builds, measures and draws."""
    some = clips_of(config.clips, config.names)
    settings = graph_config(config.clips, config.neighbourhood)
    built = [_timed(some, settings) for _ in range(config.repeats + 1)]
    graph, seconds, busy = built[-1][0], [s for _, s, _ in built], [b for _, _, b in built]
    steps = [g.report["seconds"] for g, _, _ in built]
    cold = cold_process(config) if config.cold and config.clips else (None, None)
    timings: dict[str, Any] = {
        "first_s": seconds[0],
        "warm_s_median": float(np.median(seconds[1:])),
        "warm_s_min": min(seconds[1:]),
        "warm_cpu_s_median": float(np.median(busy[1:])),
        "steps_s_median": {k: float(np.median([s[k] for s in steps[1:]])) for k in steps[0]},
        "cold_process_s": cold[0],
        "cold_process_cpu_s": cold[1],
    }
    every = build_graph(clips_of(config.clips), config=settings)
    sketch = sketches(config.scale)[config.path]
    walks = {"all": (graph, follow(graph, sketch))}
    few = build_graph(clips_of(config.clips, config.fewer), config=settings)
    walks["fewer"] = (few, follow(few, sketch))
    metrics = {
        "clips": len(some),
        "frames": graph.report["frames"],
        "transitions": graph.report["transitions"],
        "paper_s": PAPER_S,
        "quality": quality(every, config),
        "thresholds": [left_at(config, threshold) for threshold in config.thresholds_m],
        "fewer": {
            name: {
                "transitions": own.report["transitions"],
                "status": walked.status,
                "mean_distance_m": walked.mean_distance,
                "largest_distance_m": walked.largest_distance,
            }
            for name, (own, walked) in walks.items()
        },
    }
    longest = sorted(some, key=lambda clip: clip.motion.num_frames)
    pair = longest[-1], longest[-min(2, len(longest))]
    figures: dict[str, Figure | Callable[[], Figure]] = {
        "error": lambda: error_figure(pair, settings),
        "fewer": lambda: fewer_figure(sketch, walks),
        "unrolled": lambda: unrolled_figure(graph, sketch, PathConfig(beam_width=24)),
    }
    return Results(
        metrics=metrics, timings=timings, figures=figures, lines=_lines(metrics, timings)
    )


def _timed(clips: list[Clip], settings: GraphConfig) -> tuple[MotionGraph, float, float]:
    """A graph, and seconds of wall and of processor time."""
    begin, busy = time.perf_counter(), time.process_time()
    graph = build_graph(clips, config=settings)
    return graph, time.perf_counter() - begin, time.process_time() - busy


def cold_process(config: Config) -> tuple[float, float]:
    """Wall and processor seconds of ``mgjax build`` in a new process without compiled programs."""
    files = sorted(Path(config.clips).glob("*.amc")) + sorted(Path(config.clips).glob("*.bvh"))
    others = [f.name for f in files if config.names and f.stem not in config.names]
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "mgjax", "build", "--clips", config.clips, "--out", folder]
        for name in others:
            words += ["--exclude", name]
        begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            words, check=True, capture_output=True, env=os.environ | {"MGJAX_CACHE": folder}
        )
        wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def quality(graph: MotionGraph, config: Config) -> dict[str, Any]:
    """What the largest component holds, and how far planted feet slide."""
    plain = build_graph(
        clips_of(config.clips),
        config=graph_config(config.clips, config.neighbourhood, clean_feet=False),
    )
    slides = {name: transition_slide(g) for name, g in (("before", plain), ("after", graph))}
    stop = int(graph.clip_stops[-1])
    captured = Motion(
        root_translation=graph.root_translation[:stop],
        local_rotations=graph.local_rotations[:stop],
        frame_rate=graph.frame_rate,
    )
    plants = graph.plants[:stop].copy()
    plants[graph.clip_starts] = False  # no step leads from clip to clip
    slides["captured"] = foot_slide(graph.skeleton, captured, plants)
    return {
        "threshold_m": graph.report["threshold_m"],
        "transitions": graph.report["transitions"],
        "clips": kept_clips(graph),
        "slide_m_per_frame": {name: both[0] for name, both in slides.items()},
        "slide_share_of_stance": {name: both[1] for name, both in slides.items()},
        "published_slide_m_per_frame": PUBLISHED_SLIDE_M,
    }


def transition_slide(graph: MotionGraph) -> tuple[float, float]:
    """:func:`foot_slide` over all transitions, each with the frame before it."""
    edges = np.flatnonzero(graph.edge_clip == NO_CLIP)
    before = graph.node_frame[graph.edge_source[edges]] - 1
    step = np.arange(graph.window + 1)
    frames = np.concatenate([before[:, None], graph.edge_starts[edges][:, None] + step], axis=1)
    plants = graph.plants[frames]
    positions = np.asarray(
        forward(graph.skeleton, graph.root_translation, graph.local_rotations)[0]
    )
    floor = positions[:, [*foot_joints(graph.skeleton), 0]][..., ::2].astype(np.float64)
    moved = np.linalg.norm(np.diff(floor[frames], axis=1), axis=-1)
    on = plants[:, 1:] & plants[:, :-1]
    slid, way = (moved[..., :2] * on).sum(), (moved[..., 2:] * on).sum()
    return float(slid / on.shape[0] / on.shape[1]), float(slid / way)


def kept_clips(graph: MotionGraph) -> dict[str, dict[str, float]]:
    """Of every clip: seconds in the component, how far the body turns in them, mean speed."""
    positions = np.asarray(
        forward(graph.skeleton, graph.root_translation, graph.local_rotations)[0]
    )
    bodies = np.asarray(planar_frames(graph.skeleton, positions), dtype=np.float64)
    rows = {}
    for number, name in enumerate(graph.clip_names):
        own = np.flatnonzero(graph.edge_clip == number)
        begin, end = graph.clip_starts[number], graph.clip_stops[number]
        if len(own):
            first, last = graph.edge_starts[own].min(), graph.edge_stops[own].max()
        else:
            first = last = begin
        heading = np.unwrap(bodies[first : last + 1, 0])
        way = np.linalg.norm(np.diff(bodies[begin:end, 1:], axis=0), axis=1).sum()
        rows[name] = {
            "seconds": float(graph.edge_frames[own].sum() / graph.frame_rate),
            "turn_deg": float(np.degrees(heading[-1] - heading[0])),
            "m_s": float(way / max(end - begin - 1, 1) * graph.frame_rate),
        }
    return rows


def left_at(config: Config, threshold: float) -> dict[str, Any]:
    """What is left of all clips at a threshold, and whether walks and runs are linked there."""
    settings = graph_config(
        config.clips, config.neighbourhood, threshold_m=threshold, clean_feet=False
    )
    try:
        graph = build_graph(clips_of(config.clips), config=settings)
    except GraphError:
        return {"threshold_m": threshold, "seconds": 0.0, "walks": 0, "runs": 0}
    rows = [row for row in kept_clips(graph).values() if row["seconds"] > 0]
    return {
        "threshold_m": threshold,
        "transitions": graph.report["transitions"],
        "seconds": sum(row["seconds"] for row in rows),
        "walks": sum(row["m_s"] < RUN_M_S for row in rows),
        "runs": sum(row["m_s"] >= RUN_M_S for row in rows),
    }


def _lines(metrics: dict[str, Any], timings: dict[str, Any]) -> tuple[str, ...]:
    own = metrics["quality"]
    cold = timings["cold_process_s"]
    slide = ", ".join(
        f"{name} {1000 * value:.1f} mm ({100 * own['slide_share_of_stance'][name]:.0f} %)"
        for name, value in own["slide_m_per_frame"].items()
    )
    linked = [r["threshold_m"] for r in metrics["thresholds"] if r["walks"] and r["runs"]]
    return (
        f"{metrics['clips']} clips, {metrics['transitions']} transitions: first"
        f" {timings['first_s']:.2f} s, warm {timings['warm_s_median']:.3f} s, cold process "
        + ("not tried" if cold is None else f"{cold:.1f} s")
        + f"; the paper: {PAPER_S:.0f} s",
        *(f"  {name}: {value:.3f} s" for name, value in timings["steps_s_median"].items()),
        f"planted feet per frame, and by what the root travels: {slide}; a peer 13.2–14.7 mm",
        f"walks and runs in one component at {min(linked):.2f} m" if linked else "no link to runs",
        *(
            f"{name}: {row['status']}, mean {100 * row['mean_distance_m']:.1f} cm, largest"
            f" {100 * row['largest_distance_m']:.1f} cm with {row['transitions']} transitions"
            for name, row in metrics["fewer"].items()
        ),
    )


if __name__ == "__main__":
    experiment(run, Config)
