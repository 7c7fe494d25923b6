"""What a build costs as the corpus grows, and what that makes of days of capture on many cores.

    python -m experiments.benchmarks.scaling --set 'clips=["corpus"]' --out out/scaling

The clips of the folders, the first minutes of them and more at a time; beyond what there is, varied
copies (played at other speeds, begun elsewhere). Times are of the processor. Blocks of pairs of
groups of clips are timed one by one; a scheduler then hands as many blocks as a larger corpus has,
at costs drawn from these, to the next of so many cores that is free.
"""

from __future__ import annotations

import heapq
import resource
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mgjax.clips.folder import load_clips
from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip
from mgjax.core.motion import Motion, sample
from mgjax.core.parallel.executors import SerialExecutor
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.stages.block import search_block
from mgjax.graph.stages.stages import Stages
from mgjax.runs.experiment import Results, experiment

MOST_BLOCKS = 4_000_000
"""Of more blocks only the sums are given."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is built."""

    clips: tuple[str, ...] = ()
    """Folders of clips of one skeleton; none: the embedded clips."""
    minutes: tuple[float, ...] = (2.5, 5.0, 10.0, 20.0)
    """Of motion, in ascending order."""
    threshold_m: float = 0.13
    """Largest distance of a transition."""
    best_per_s: int = 20
    """Transitions that stay out of each second of motion."""
    hours: tuple[float, ...] = (4.0, 40.0, 1000.0)
    """Of what is extrapolated to."""
    cores: tuple[int, ...] = (1, 16, 256)
    """On how many."""
    dispatch_s: float = 0.003
    """What the process that hands out blocks does for each, s."""
    seed: int = 0
    """Draws costs of blocks."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"clips": (), "minutes": (0.5, 1.0), "hours": (1.0,), "cores": (1, 4)}


class _Timed(SerialExecutor):
    """Notes the processor time of each block of the search."""

    def __init__(self) -> None:
        self.seconds: list[float] = []

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        begin = time.process_time()
        future = super().submit(fn, *args, **kwargs)
        if fn is search_block:
            self.seconds.append(time.process_time() - begin)
        return future


def run(config: Config) -> Results:
    """Builds all sizes, fits, and extrapolates."""
    clips = [clip for folder in config.clips for clip in load_clips(folder)[0]]
    clips = clips or synthetic_clips()[0]
    graph = GraphConfig(threshold_m=config.threshold_m, best_per_s=config.best_per_s)
    build_graph(_first(clips, 60 * config.minutes[0]), config=graph)  # loads programs
    rows = [_built(_first(clips, 60 * minutes), graph, None) for minutes in config.minutes]
    timed = _Timed()
    staged = _built(_first(clips, 60 * config.minutes[-1]), graph, timed)
    exponents = {
        name: _exponent([row["frames"] for row in rows], [row[name] for row in rows])
        for name in ("distance_cpu_s", "rest_cpu_s", "transitions")
    }
    # The first block of each size of program loads it.
    blocks = np.sort(timed.seconds)[: max(len(timed.seconds) - 3, 1)]
    frames = staged["frames"]
    rng = np.random.default_rng(config.seed)
    farther = [
        _extrapolated(config, hours, cores, blocks, len(timed.seconds), frames, rows[-1], rng)
        for hours in config.hours
        for cores in config.cores
    ]
    metrics = {
        "sizes": rows,
        "in_stages": staged | {"blocks": len(timed.seconds)},
        "block_cpu_s_p5_p50_p95": np.percentile(blocks, (5, 50, 95)).tolist(),
        "exponents": exponents,
        "extrapolated": farther,
    }
    lines = [
        f"{row['minutes']:.1f} min, {row['frames']} frames: search {row['distance_cpu_s']:.1f} s,"
        f" rest {row['rest_cpu_s']:.1f} s of CPU, {_count(row['minima'])} minima,"
        f" {row['transitions']} transitions,"
        f" {row['window_pairs_per_cpu_s'] / 1e6:.0f} M window pairs a second,"
        f" {row['peak_mb']:.0f} MB at most so far"
        for row in rows
    ]
    lines.append("exponents: " + ", ".join(f"{k} {v:.2f}" for k, v in exponents.items()))
    lines += [
        f"{row['hours']:g} h on {row['cores']} cores: {row['wall_h']:.2f} h"
        f" ({row['blocks']} blocks{', handed out too slowly' if row['dispatch_bound'] else ''})"
        for row in farther
    ]
    return Results(metrics=metrics, figures={"scaling": lambda: _picture(rows)}, lines=tuple(lines))


def _first(clips: list[Clip], seconds: float) -> list[Clip]:
    """Clips of so many seconds together: those that there are, then varied copies."""
    found: list[Clip] = []
    total, turn = 0.0, 0
    while True:
        for clip in clips:
            if total >= seconds:
                return found
            copy = _varied(clip, turn) if turn else clip
            found.append(copy)
            total += copy.motion.num_frames / copy.motion.frame_rate
        turn += 1


def _varied(clip: Clip, turn: int) -> Clip:
    """A copy played at another speed and begun elsewhere."""
    motion = clip.motion
    speed = (0.9, 1.1, 0.95, 1.05)[turn % 4] * (1.0 + 0.013 * (turn // 4))
    begin = min(turn % 3 * motion.frame_rate / 2, motion.num_frames / 4)
    places = np.arange(begin, motion.num_frames - 1, speed)
    poses = sample(motion, places)
    return replace(clip, name=f"{clip.name}+{turn}", motion=_plain(poses, motion.frame_rate))


def _plain(poses: Motion, rate: float) -> Motion:
    return Motion(
        root_translation=np.asarray(poses.root_translation),
        local_rotations=np.asarray(poses.local_rotations),
        frame_rate=rate,
    )


def _built(clips: list[Clip], config: GraphConfig, pool: Executor | None) -> dict[str, Any]:
    """One build; processor time of the search, and of everything else."""
    marks: list[tuple[float, str]] = []

    def watch(share: float, what: str) -> None:
        if not marks or marks[-1][1] != what:
            marks.append((time.process_time(), what))

    begin = time.process_time()
    stages = None if pool is None else Stages(executor=pool)
    graph = build_graph(clips, config=config, watch=watch, stages=stages)
    total = time.process_time() - begin
    names = [what for _, what in marks]
    at = names.index("comparing poses")
    search = marks[at + 1][0] - marks[at][0]
    frames = round(graph.report["seconds_of_clips"] * graph.frame_rate)
    return {
        "minutes": graph.report["seconds_of_clips"] / 60,
        "clips": len(clips),
        "frames": frames,
        "distance_cpu_s": search,
        "rest_cpu_s": total - search,
        "window_pairs_per_cpu_s": frames**2 / search,
        "minima": graph.report["minima"],
        "transitions": graph.report["transitions"],
        "dropped_by_best_per_s": graph.report["dropped_by_best_per_s"],
        "megabytes": sum(v.nbytes for v in vars(graph).values() if isinstance(v, np.ndarray)) / 1e6,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def _count(number: int | None) -> str:
    return "not counted" if number is None else str(number)


def _exponent(sizes: list[float], values: list[float]) -> float:
    """Slope of the straight line through the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(np.maximum(values, 1e-9)), 1)[0])


def _extrapolated(
    config: Config,
    hours: float,
    cores: int,
    blocks: np.ndarray,
    count: int,
    frames: int,
    largest: dict[str, Any],
    rng: np.random.Generator,
) -> dict[str, Any]:
    """How long the search of so many hours takes, and the rest where it is done once."""
    factor = hours * 3600 * 30 / frames
    number = round(count * factor**2)
    total = float(blocks.mean()) * number
    handed_out = config.dispatch_s * number
    if number <= MOST_BLOCKS:
        wall = _scheduled(rng.choice(blocks, number), cores, config.dispatch_s)
    else:
        wall = max(total / cores, handed_out)
    return {
        "hours": hours,
        "cores": cores,
        "blocks": number,
        "cpu_h": total / 3600,
        "wall_h": wall / 3600,
        "rest_h": largest["rest_cpu_s"] * factor / 3600,
        "scheduled": number <= MOST_BLOCKS,
        "dispatch_bound": handed_out > total / cores,
    }


def _scheduled(costs: np.ndarray, cores: int, dispatch: float) -> float:
    """Seconds until all blocks are done, in their order, each by the core that is free first."""
    free = [0.0] * cores
    handed = 0.0
    for cost in costs.tolist():
        handed += dispatch
        begin = max(heapq.heappop(free), handed)
        heapq.heappush(free, begin + cost)
    return max(free)


def _picture(rows: list[dict[str, Any]]) -> Figure:
    """Processor time and sizes over the length of the corpus."""
    figure = Figure(figsize=(8, 3.2), layout="constrained")
    times, sizes = figure.subplots(1, 2)
    minutes = [row["minutes"] for row in rows]
    times.plot(minutes, [row["distance_cpu_s"] for row in rows], "o-", label="search for minima")
    times.plot(minutes, [row["rest_cpu_s"] for row in rows], "s-", label="everything else")
    times.set_ylabel("processor time, s")
    counted = [row["minima"] or np.nan for row in rows]
    sizes.plot(minutes, counted, "o-", label="minima, where they are counted")
    sizes.plot(minutes, [row["transitions"] for row in rows], "s-", label="transitions kept")
    for axes in (times, sizes):
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xticks(minutes, [f"{x:.0f}" for x in minutes], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("motion, minutes")
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize=8)
    return figure


if __name__ == "__main__":
    experiment(run, Config)
