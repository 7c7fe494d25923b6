"""How many targets around a walking character are reached, how exactly, how quickly.

    python -m experiments.hybrid.reach --config configs/hybrid/reach.toml \\
        --set clips=capture/locomotion/cmu16 --out out/hybrid/reach

Without clips and graph it uses the embedded clips. A walk of 2 m ends before each of the targets;
they are tried with and without extending the walk, with and without joint limits. The second
picture is a walk along an S-curve that reaches for a high target on its way.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import jax
import numpy as np
from matplotlib.figure import Figure

from experiments.hybrid.reach_plot import grid_place, strip, success_map
from experiments.hybrid.shapes import graph_of, sketches
from mgjax.core.kinematics import forward, global_positions
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.body.limb_limits import make_limb_limits
from mgjax.hybrid.config import PathConfig, ReachConfig
from mgjax.hybrid.ik.chain import fabrik
from mgjax.hybrid.ik.limbs import find_limb
from mgjax.hybrid.ik.pose import reach_pose
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import make_sketch
from mgjax.hybrid.reaching.result import ReachResult
from mgjax.hybrid.reaching.targets import make_target
from mgjax.hybrid.reaching.walk import reach
from mgjax.runs.experiment import Results, experiment

PEERS_US = {
    "pyfabrik, 4 / 8 links": (147, 360),
    "Caliko, 4 / 8 links": (2.9, 13.3),
    "mink, 4 / 8 bones": (230, 190),
    "pyroki single, 4 / 8 bones": (460, 270),
    "pyroki batched, 4 / 8 bones": (230, 510),
    "ikpy, 12 / 24 degrees of freedom": (12700, 31700),
}
"""Published or measured elsewhere, microseconds a solve."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Which graph, and the grid of targets around the end of a walk."""

    graph: str = ""
    """Folder of a graph; empty: built from the clips."""
    clips: str = ""
    """Folder of clips; empty: the embedded ones."""
    neighbourhood: int = 5
    """Of the graph's minima, if it is built."""
    heights: tuple[float, ...] = (0.2, 0.5, 0.8, 1.1, 1.4, 1.65, 1.9)
    """Of the targets, m."""
    radii: tuple[float, ...] = (0.4, 0.7, 1.0, 1.5, 2.0, 2.5, 3.0)
    """Their distances from the body, m."""
    directions: int = 8
    """All around."""
    limits: tuple[bool, ...] = (True, False)
    """With joint limits, without them."""
    hold_s: float = 0.3
    """How long each is held."""
    batch: int = 4096
    """Poses solved at once where the time is measured."""
    repeats: int = 9
    """Measurements of a time."""
    figures: int = 9
    """Poses in the picture of the S-curve."""
    arrive_m: float = 0.01
    """A target counts as reached within this distance over the whole hold, m."""
    reach: ReachConfig = field(default_factory=ReachConfig)
    """Settings of reaching."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {
            "graph": "",
            "clips": "",
            "heights": (1.1,),
            "radii": (0.5,),
            "directions": 1,
            "limits": (True,),
            "batch": 1,
            "repeats": 1,
            "figures": 5,
        }


def run(config: Config) -> Results:
    """Measures all variants, the time of a solve, and draws."""
    graph = graph_of(config.graph, config.clips, config.neighbourhood)
    angles = 2 * np.pi * np.arange(config.directions) / config.directions
    reached: dict[str, np.ndarray] = {}
    rows: dict[str, dict[str, Any]] = {}
    timings: dict[str, Any] = {}
    extended = np.zeros(0)
    for extend in (True, False):
        for limits in config.limits:
            name = f"{'extended' if extend else 'as it is'}, {'limits' if limits else 'no limits'}"
            settings = replace(config.reach, extend=extend, limits=limits)
            found = _grid(graph, config, settings, angles)
            reached[name] = found["reached"]
            rows[name] = _summary(found)
            timings[name] = {"reach_s_median": float(np.median(found["seconds"]))}
            if extend and limits:
                extended = found["extended"]
    timings["ik_us"] = _ik_times(graph, config)
    curve = sketches()["s_curve"]
    walk = s_curve(graph, config)
    row = walk.targets[0]
    metrics = {
        "variants": rows,
        "peers_us": PEERS_US,
        "s_curve": {
            "status": row.status,
            "error_m": row.error_m,
            "hold_error_m": row.hold_m,
            "fastest_turn_deg_s": walk.fastest_deg_s,
            "mean_distance_m": walk.walked.mean_distance,
        },
    }
    lines = [_line(name, row) for name, row in rows.items()]
    lines += [f"{name:28} {us:9.2f} µs a solve" for name, us in timings["ik_us"].items()]

    def draw_map() -> Figure:
        return success_map(config.heights, config.radii, angles, reached, extended)

    def draw_strip() -> Figure:
        return strip(graph, curve, walk, config.figures)

    return Results(
        metrics=metrics,
        timings=timings,
        figures={"reach": draw_map, "s_curve": draw_strip},
        lines=tuple(lines),
    )


def _grid(
    graph: MotionGraph, config: Config, settings: ReachConfig, angles: np.ndarray
) -> dict[str, np.ndarray]:
    """Reaches for each target of the grid with the right hand."""
    path = PathConfig(method="beam")
    line = make_sketch([[0.0, 0.0], [0.0, 2.0]])
    end = follow(graph, line, config=path).track.end
    shape = (len(config.heights), len(config.radii), len(angles))
    names = ("reached", "extended", "error", "hold", "fastest", "bones", "clear", "seconds")
    table = {name: np.zeros(shape) for name in names}
    for place in np.ndindex(shape):
        height, radius = config.heights[place[0]], config.radii[place[1]]
        angle = float(angles[place[2]])
        target = make_target(
            "right_hand", place=grid_place(end, radius, angle, height), when="end",
            hold_s=config.hold_s,
        )  # fmt: skip
        begun = time.perf_counter()
        result = reach(graph, line, (target,), config=settings, path=path)
        table["seconds"][place] = time.perf_counter() - begun
        row = result.targets[0]
        arrived = row.status == "reached" and row.hold_m <= config.arrive_m
        table["reached"][place] = arrived
        table["extended"][place] = row.extended_m > 0
        table["error"][place] = row.error_m if arrived else np.nan
        table["hold"][place] = row.hold_m if arrived else np.nan
        table["clear"][place] = row.clear_m if arrived else np.nan
        table["fastest"][place] = result.fastest_deg_s if arrived else np.nan
        table["bones"][place] = _bone_error(graph, result)
    return table


def _bone_error(graph: MotionGraph, result: ReachResult) -> float:
    positions = np.asarray(global_positions(graph.skeleton, result.motion), np.float64)
    parents = np.array(graph.skeleton.parents[1:])
    found = np.linalg.norm(positions[:, 1:] - positions[:, parents], axis=-1)
    wanted = np.linalg.norm(np.asarray(graph.skeleton.offsets, np.float64)[1:], axis=-1)
    return float(np.abs(found - wanted).max())


def _summary(found: dict[str, np.ndarray]) -> dict[str, Any]:
    def largest(name: str) -> float | None:
        values = found[name][np.isfinite(found[name])]
        return float(values.max()) if values.size else None

    clear = found["clear"][np.isfinite(found["clear"])]
    return {
        "targets": int(found["reached"].size),
        "reached": float(found["reached"].mean()),
        "walk_extended": float(found["extended"].mean()),
        "largest_error_m": largest("error"),
        "largest_hold_error_m": largest("hold"),
        "fastest_turn_deg_s": largest("fastest"),
        "largest_bone_error_m": largest("bones"),
        "arm_in_body": float((clear < 0).mean()) if clear.size else None,
    }


def _line(name: str, row: dict[str, Any]) -> str:
    return (
        f"{name:22} {100 * row['reached']:5.1f} % of {row['targets']} reached,"
        f" {100 * row['walk_extended']:5.1f} % by a longer walk; hold within"
        f" {1000 * (row['largest_hold_error_m'] or 0):.2f} mm, bones within"
        f" {row['largest_bone_error_m']:.1e} m, fastest turn"
        f" {row['fastest_turn_deg_s'] or 0:.0f}°/s"
    )


def _ik_times(graph: MotionGraph, config: Config) -> dict[str, float]:
    """Median microseconds a solve of the right arm to 1 mm, targets within reach."""
    limb = find_limb(graph.skeleton, "right_hand")
    rng = np.random.default_rng(0)
    frames = rng.integers(0, int(graph.clip_stops[-1]), config.batch)
    root, local = graph.root_translation[frames], graph.local_rotations[frames]
    places = np.asarray(forward(graph.skeleton, root, local)[0])
    aim = rng.normal(size=(config.batch, 3))
    aim *= rng.uniform(0.3, 0.6, (config.batch, 1)) / np.linalg.norm(aim, axis=1, keepdims=True)
    target = (places[:, limb.joints[4]] + aim).astype(np.float32)
    chains = places[:, list(limb.joints)]
    limits = make_limb_limits(graph).of((limb,))

    def pose(count: int, use: Any) -> Callable[[], Any]:
        arrays = (root[:count], local[:count], target[:count, None])
        return lambda: reach_pose(graph.skeleton, *arrays, limbs=(limb,), limits=use)

    some = min(config.batch, 256)
    work = {
        "chain, single": (lambda: fabrik(chains[0], target[0]), 1),
        "chain, batched": (lambda: fabrik(chains, target), config.batch),
        "pose, single": (pose(1, None), 1),
        "pose, batched": (pose(some, None), some),
        "pose with limits, single": (pose(1, limits), 1),
        "pose with limits, batched": (pose(some, limits), some),
    }
    return {name: _median(call, config.repeats) / count for name, (call, count) in work.items()}


def _median(call: Callable[[], Any], repeats: int) -> float:
    """Microseconds of a call, after a first one."""
    jax.block_until_ready(call())
    found = []
    for _ in range(repeats):
        begun = time.perf_counter()
        jax.block_until_ready(call())
        found.append(time.perf_counter() - begun)
    return 1e6 * float(np.median(found))


def s_curve(graph: MotionGraph, config: Config) -> ReachResult:
    """A walk along an S-curve; half way there is something high beside it."""
    target = make_target(
        "right_hand", place=[0.05, 1.85, 5.55], when="passing", hold_s=config.hold_s
    )
    return reach(graph, sketches()["s_curve"], (target,), config=config.reach)


if __name__ == "__main__":
    experiment(run, Config)
