"""Soak of the planner: minutes of playback with an attack every 0.3–2 s.

On a simulated clock, where searches take random times, and for a while in real time. It counts the
answers (every attack has one), restarts and frames, checks that memory stays flat, and reports the
longest gap between two frames.

    python -m experiments.benchmarks.planner --set clips=capture --out out/planner
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.avoidance.graphs import graph_of
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.transform import in_frame
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.play.clocks import SimulatedClock, SimulatedSearches, ThreadSearches, WallClock
from mgjax.avoidance.play.planner import Planner
from mgjax.core import planar
from mgjax.core.motion import Motion
from mgjax.core.xla.compilation import one_thread
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment

EVERY_S = (0.3, 2.0)
FRAME_RATE = 60.0


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings."""

    graph: str = ""
    """Folder of a graph; empty: that of the embedded clips."""
    clips: str = ""
    """Folder of clips with its labels.json, of which a graph is built; empty: the graph."""
    exclude: tuple[str, ...] = ("bvh_converted/*",)
    """Globs on paths below the folder of clips that are left out."""
    minutes: float = 10.0
    """On the simulated clock."""
    real_s: float = 20.0
    """In real time, s."""
    seed: int = 0
    """Draws the walk and the attacks."""
    avoidance: AvoidanceConfig = field(default_factory=AvoidanceConfig)
    """Settings of the search."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "graph": "",
            "clips": "",
            "minutes": 0.1,
            "real_s": 0.5,
            "avoidance.checks": 12,
        }


def run(config: Config) -> Results:
    graph = graph_of(config.graph, config.clips, config.exclude)
    real = real_time(graph, config.real_s, seed=config.seed, config=config.avoidance)
    played = soak(graph, config.minutes, seed=config.seed, config=config.avoidance)
    line = f"{played['attacks']} attacks in {config.minutes:g} min, none without an answer"
    return Results(
        metrics={"minutes": config.minutes}, timings={"real": real, "soak": played}, lines=(line,)
    )


def ball_at(rng: np.random.Generator, root: np.ndarray, now: float) -> Attack:
    """A ball at 10 m/s from any side at the body's axis, in the world, on the planner's clock."""
    side = rng.uniform(0, 2 * np.pi)
    height = rng.uniform(0.5, 1.7)
    ball = ball_from(
        side, height, at=(float(root[0]), float(root[2])), arrives=rng.uniform(0.7, 1.6)
    )
    return replace(ball, times=ball.times + now)


def memory_mb() -> float:
    """Resident memory of this process, MB; NaN where the system does not tell."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
    except OSError:
        pass
    return float("nan")


def soak(
    graph: MotionGraph,
    minutes: float,
    *,
    seed: int = 0,
    latency: tuple[float, float] = (0.005, 0.6),
    config: AvoidanceConfig | None = None,
) -> dict[str, Any]:
    """Simulated minutes; searches take from ``latency``, log-uniformly.

    Raises:
        AssertionError: an attack was lost, or the counts do not add up.
    """
    rng = np.random.default_rng(seed)
    low, high = np.log(latency)
    searches = SimulatedSearches(lambda: float(np.exp(rng.uniform(low, high))))
    clock = SimulatedClock()
    planner = Planner(graph, clock=clock, searches=searches, config=config, seed=seed)
    begin, next_attack = time.perf_counter(), 0.5
    memory, frames = [], 0
    while clock.now() < 60 * minutes:
        motion = planner.frame()
        frames += 1
        if clock.now() >= next_attack:
            planner.attack(ball_at(rng, np.asarray(motion.root_translation[0]), clock.now()))
            next_attack += rng.uniform(*EVERY_S)
        if frames % int(30 * FRAME_RATE) == 0:
            gc.collect()
            memory.append(round(memory_mb(), 1))
        clock.advance(1 / FRAME_RATE)
    planner.finish()
    counts = planner.counts()
    answered = counts["avoided"] + counts["hit"] + counts["superseded"]
    assert counts["open"] == 0
    assert answered == counts["attacks"]
    assert sorted(a.number for a in planner.answers) == list(range(counts["attacks"]))
    searched: dict[str, int] = dict.fromkeys((*Status, "late", "committed"), 0)
    kept = 0
    for answer in planner.answers:
        searched[answer.search] += 1
        kept += answer.search == "avoided" and not answer.hit
    return {
        "minutes": minutes,
        "frames": frames,
        **counts,
        "searched": searched,
        "found_and_kept": kept,
        "before_edge_ended": sum(a.restarts == 0 and a.waited is not None for a in planner.answers),
        "edges": len(planner.timeline.edges),
        "memory_mb_each_30_s": memory,
        "wall_s": round(time.perf_counter() - begin, 1),
    }


def warm_up(graph: MotionGraph, config: AvoidanceConfig, *, count: int = 40) -> None:
    """Searches for random balls at random nodes, so that most shapes are compiled."""
    rng = np.random.default_rng(99)
    for _ in range(count):
        node, now = int(rng.integers(graph.num_nodes)), float(rng.uniform(0.0, 0.4))
        ball = ball_at(rng, np.array([0.0, 1.0, 0.0]), 0.0)
        shifted = in_frame(ball, np.asarray(planar.identity(ball.centres)), now)
        choose(graph, node, shifted, config=config)


@dataclass(frozen=True, kw_only=True)
class Report:
    """How a real-time run went; seconds.

    Attributes:
        frames: how many were shown.
        longest_gap: from one frame to the next.
        longest_frame: that one frame took to compute.
        median_frame: the same, for half of the frames.
    """

    frames: int
    longest_gap: float
    longest_frame: float
    median_frame: float


def play(
    frame: Callable[[], Motion],
    seconds: float,
    *,
    rate: float = 60.0,
    before_frame: Callable[[float], None] | None = None,
) -> Report:
    """Asks for frames in real time, ``rate`` a second, and reports the longest gap between two.

    Args:
        frame: gives the pose of now, such as :meth:`mgjax.avoidance.play.planner.Planner.frame`.
        seconds: how long.
        rate: frames per second.
        before_frame: called before each frame with the seconds since the run began; may throw.
    """
    begin = time.perf_counter()
    shown, took = [], []
    number = 0
    while (now := time.perf_counter() - begin) < seconds:
        if before_frame is not None:
            before_frame(now)
        asked = time.perf_counter()
        frame()
        shown.append(time.perf_counter())
        took.append(shown[-1] - asked)
        number = max(number + 1, math.floor((shown[-1] - begin) * rate))
        time.sleep(max(begin + number / rate - time.perf_counter(), 0.0))
    return Report(
        frames=len(shown),
        longest_gap=float(np.diff(shown).max(initial=0.0)),
        longest_frame=max(took, default=0.0),
        median_frame=float(np.median(took)) if took else 0.0,
    )


def real_time(
    graph: MotionGraph, seconds: float, *, seed: int = 0, config: AvoidanceConfig | None = None
) -> dict[str, Any]:
    """Plays in real time with a search thread, and attacks as in the soak."""
    config = config or AvoidanceConfig()
    warm_up(graph, config)
    rng = np.random.default_rng(seed)
    clock = WallClock()
    planner = Planner(graph, clock=clock, searches=ThreadSearches(), config=config, seed=seed)
    next_attack = 0.3

    def throw(now: float) -> None:
        nonlocal next_attack
        if now >= next_attack:
            root = np.asarray(planner.frame().root_translation[0])
            planner.attack(ball_at(rng, root, clock.now()))
            next_attack += rng.uniform(*EVERY_S)

    report = play(planner.frame, seconds, rate=FRAME_RATE, before_frame=throw)
    answers = planner.finish()
    planner.close()
    waited = [a.waited for a in answers if a.waited is not None]
    return {
        **{name: round(value, 5) for name, value in asdict(report).items()},
        **planner.counts(),
        "median_wait_s": round(float(np.median(waited)), 4) if waited else None,
        "longest_wait_s": round(max(waited), 4) if waited else None,
    }


if __name__ == "__main__":
    one_thread()
    experiment(run, Config)
