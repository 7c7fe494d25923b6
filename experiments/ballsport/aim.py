"""Aiming a ball: success over distance and bounces, convergence, time, and the choice of a frame.

    python -m experiments.ballsport.aim --config configs/ballsport/aim.toml --out out/ballsport/aim

A pass is met if an integrator of its own, in float64, finds the ball within 0.1 mm of the target
after just the wanted bounces. Convergence is shown from the scanned guess and, as the paper begins,
from the bone's own velocity. Times are medians; those of a MuJoCo simulation fitted with SciPy's
conjugate gradients (7.4 ms without and 50 ms with one bounce, measured once on 2 cores) stand
beside them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from experiments.ballsport.aim_checks import Passes, checked, random_passes
from experiments.ballsport.aim_plot import convergence_figure, frames_figure, success_figure
from mgjax.ballsport import BallPhysics, aim, aim_batch, choose_frame, fly
from mgjax.ballsport.aiming.problem import Launch, flight_arcs, make_problem
from mgjax.ballsport.aiming.scan import guess_launch
from mgjax.ballsport.aiming.updates import SECOND, differential_updates
from mgjax.ballsport.ball.flight import contact_time
from mgjax.bench.timing import interleaved
from mgjax.core.arrays import Array
from mgjax.runs.experiment import Results, experiment

PEER_S = {0: 0.0074, 1: 0.050}
"""MuJoCo 4.0.0 with SciPy's conjugate gradients, one ball, by bounces, s."""

BOUNCES = (0, 1, 2)
MET_M = 1e-4
UPDATES = 12
"""Differential updates in the curves of convergence."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is aimed at."""

    passes: int = 1000
    """Passes per batch."""
    seed: int = 0
    """Draws starts, targets and guesses."""
    distances: tuple[float, ...] = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0)
    """From start to target over the floor, m."""
    heights: tuple[float, ...] = (0.11, 0.5, 1.2, 2.5)
    """Heights of the target's centre, m; the ball's radius is 0.11 m."""
    max_speed: float = 30.0
    """Largest kick speed, m/s."""
    repeats: int = 41
    """Timed calls."""

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        return {"passes": 4, "distances": (1.0, 10.0), "heights": (0.11, 1.2), "repeats": 3}


def run(config: Config) -> Results:
    """Success, convergence, time and the choice of a frame."""
    physics = BallPhysics()
    success = {b: _success(config, b, physics) for b in BOUNCES}
    curves = {b: _convergence(config, b, physics) for b in BOUNCES}
    times = {b: _times(config, b, physics) for b in BOUNCES}
    frames = _frames(physics)
    metrics = {
        "success": {f"{b} bounces": row for b, row in success.items()},
        "share_below_0.1_mm_by_updates": {
            f"{b} bounces": {name: np.mean(c < MET_M, axis=0) for name, c in row.items()}
            for b, row in curves.items()
        },
        "frame": {k: v for k, v in frames.items() if np.ndim(v) == 0},
    }
    return Results(
        metrics=metrics,
        timings={f"{b} bounces": row for b, row in times.items()},
        figures={
            "success": lambda: success_figure(success, config.distances, config.heights),
            "convergence": lambda: convergence_figure(curves),
            "frames": lambda: frames_figure(frames),
        },
        lines=tuple(_line(b, success[b], times[b]) for b in BOUNCES),
    )


def _success(config: Config, bounces: int, physics: BallPhysics) -> dict[str, Any]:
    """Share met, largest miss and kick speeds per distance and height; and for random passes."""
    shape = len(config.heights), len(config.distances)
    share, speed, change = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    worst, wrong, total = 0.0, 0, 0
    for index in np.ndindex(*shape):
        place = {"height": config.heights[index[0]], "distance": config.distances[index[1]]}
        passes = random_passes(max(config.passes // 10, 4), config.seed, **place)
        aimed, miss, counts = _aimed(config, passes, bounces, physics)
        met = (aimed.status == 0) & (miss <= MET_M) & (counts == bounces)
        share[index], total = met.mean(), total + len(met)
        worst, wrong = max(worst, miss.max()), wrong + int((counts != bounces).sum())
        speed[index] = np.median(np.linalg.norm(aimed.velocity, axis=1))
        change[index] = np.median(np.linalg.norm(aimed.velocity - passes.guesses, axis=1))
    passes = random_passes(config.passes, config.seed + 1)
    aimed, miss, counts = _aimed(config, passes, bounces, physics)
    return {
        "share_met": share,
        "median_speed_m_s": speed,
        "median_change_m_s": change,
        "cells_passes": total,
        "cells_largest_miss_mm": 1e3 * worst,
        "cells_other_bounces": wrong,
        "random_share_met": np.mean((miss <= MET_M) & (counts == bounces) & (aimed.status == 0)),
        "random_largest_miss_mm": 1e3 * miss.max(),
        "random_other_bounces": int((counts != bounces).sum()),
    }


def _aimed(config: Config, passes: Passes, bounces: int, physics: BallPhysics) -> Any:
    aimed = aim_batch(
        passes.starts,
        passes.targets,
        guesses=passes.guesses,
        bounces=bounces,
        physics=physics,
        max_speed=config.max_speed,
    )
    return aimed, *checked(aimed, passes, physics)


def _convergence(config: Config, bounces: int, physics: BallPhysics) -> dict[str, np.ndarray]:
    """Miss after 0 … ``UPDATES`` differential updates, from two beginnings. [N, U+1]"""
    passes = random_passes(config.passes, config.seed + 2)
    most = np.arange(UPDATES + 1)
    curves = _curves(passes.starts, passes.targets, passes.guesses, most, physics, bounces)
    return {name: np.asarray(curve) for name, curve in curves.items()}


@partial(jax.jit, static_argnames="bounces")
def _curves(
    starts: Array, targets: Array, guesses: Array, most: Array, physics: BallPhysics, bounces: int
) -> dict[str, Array]:
    def one(start: Array, target: Array, guess: Array, limit: Array) -> dict[str, Array]:
        problem = make_problem(start, target, guess, np.nan, SECOND, 30.0, None, physics)
        begins = {"scan": guess_launch(problem, bounces).launch, "bone": _plain(problem, bounces)}
        done = {k: differential_updates(problem, v, bounces, limit) for k, v in begins.items()}
        return {k: jnp.where(d.kept, jnp.linalg.norm(d.miss), jnp.inf) for k, d in done.items()}

    over_limits = jax.vmap(one, (None, None, None, 0))
    return jax.vmap(over_limits, (0, 0, 0, None))(starts, targets, guesses, most)


def _plain(problem: Any, bounces: int) -> Launch:
    """The bone's own velocity, until the middle of the arc after the wanted bounces."""
    start, place, v = flight_arcs(problem, problem.guess, bounces)[-1]
    return Launch(problem.guess, start + contact_time(place[1], v, problem.physics) / 2)


def _times(config: Config, bounces: int, physics: BallPhysics) -> dict[str, Any]:
    """Seconds of one pass, and of one in a batch, in turns with a bare pass over a million numbers.

    Where others use the machine too, the ratio of a batch of 1,000 to the bare pass tells more.
    """
    passes = random_passes(config.passes, config.seed)
    first = passes.starts[0], passes.targets[0]
    numbers = jnp.ones(1_000_000, jnp.float32)

    def single() -> Any:
        return aim(*first, bounces=bounces, guess=passes.guesses[0], physics=physics)

    def batch() -> Any:
        return aim_batch(
            passes.starts, passes.targets, guesses=passes.guesses, bounces=bounces, physics=physics
        )

    one = interleaved(single, None, config.repeats)
    many = interleaved(batch, lambda: _bare(numbers), config.repeats)
    peer = PEER_S.get(bounces)
    return {
        "single": one,
        "batch": many,
        "batch_per_ball_s": many["median_s"] / config.passes,
        "peer_single_s": peer,
        "peer_over_single": peer / one["median_s"] if peer else None,
    }


@jax.jit
def _bare(numbers: Array) -> Array:
    return 2 * jnp.exp(numbers) + jnp.sin(numbers)


def _frames(physics: BallPhysics) -> dict[str, Any]:
    """A swinging foot: the curves of all frames, the chosen one and the adjusted one."""
    u = np.linspace(-1.0, 1.0, 25)
    feet = np.stack([0.1 * u, 0.15 + 0.4 * (u + 1) ** 2 / 4, 0.45 * u], axis=1)
    speeds = np.stack([0.9 + 0 * u, 2.8 * (u + 1), 9.5 - 3 * u * u], axis=1)
    target = np.array([1.0, 0.45, 7.0])
    aimed = choose_frame(feet, speeds, target, bounces=1, physics=physics)
    frame = int(aimed.frame)

    def curve(start: np.ndarray, velocity: Any, end: float) -> np.ndarray:
        times = np.linspace(0.0, end, 200).astype(np.float32)
        return np.asarray(
            fly(start.astype(np.float32), np.asarray(velocity), times, physics=physics)
        )

    rows = [curve(p, v, 2.2) for p, v in zip(feet, aimed.velocities, strict=True)]
    return {
        "feet": feet,
        "speeds": speeds,
        "target": target,
        "curves": np.array(rows),
        "chosen_curve": curve(feet[frame], aimed.velocities[frame], aimed.times[frame]),
        "adjusted_curve": curve(feet[frame], aimed.aim.velocity, float(aimed.aim.time)),
        "chosen": frame,
        "distance_before_m": float(aimed.distances[frame]),
        "miss_after_mm": 1e3 * float(aimed.aim.miss),
        "flight_s": float(aimed.aim.time),
        "bone_speed_m_s": float(np.linalg.norm(speeds[frame])),
        "ball_speed_m_s": float(np.linalg.norm(aimed.aim.velocity)),
    }


def _line(bounces: int, row: dict[str, Any], times: dict[str, Any]) -> str:
    peer = times["peer_single_s"]
    beside = f" (MuJoCo + SciPy {1e3 * peer:g} ms)" if peer else ""
    return (
        f"{bounces} bounces: {row['share_met'].mean():.1%} of {row['cells_passes']} passes in cells"
        f" and {row['random_share_met']:.1%} of random ones met, largest miss"
        f" {max(row['cells_largest_miss_mm'], row['random_largest_miss_mm']):.3f} mm;"
        f" {1e3 * times['single']['median_s']:.3f} ms single{beside},"
        f" {1e6 * times['batch_per_ball_s']:.1f} µs a ball in a batch"
    )


if __name__ == "__main__":
    experiment(run, Config)
