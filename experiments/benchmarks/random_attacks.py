"""Ten thousand random attacks, odd ones among them: nothing raises, nothing called avoided touches.

Balls that are fast, slow, tiny, huge, under way already, falling, through the floor or at rest;
several at once; spheres that turn sharply; and attacks that have to be refused. The motion of every
answer that is called avoided is swept 240 times a second, in double precision, by code that is not
that of the search or its check. Everything is compiled first; programs that are compiled
after that, and memory, are counted.

    python -m experiments.benchmarks.random_attacks --set graph=DIR --set attacks=10000
"""

from __future__ import annotations

import resource
import time
from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np
from jaxtyping import Float
from tqdm import tqdm

from experiments.avoidance.graphs import graph_of
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.merge import merge_attacks
from mgjax.avoidance.body.spheres import preset_spheres, sphere_centres
from mgjax.avoidance.choice.compile_ahead import warm_up
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import CLEAR_M
from mgjax.core.errors import AttackError
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion, sample
from mgjax.core.xla.compilation import one_thread
from mgjax.graph.types import MotionGraph
from mgjax.runs.experiment import Results, experiment

KINDS = (
    "ball", "falling", "fast", "slow", "tiny", "huge", "at rest", "through the floor",
    "under way", "late", "two balls", "zigzag", "not finite", "inside the body",
)  # fmt: skip
LAST_S = 8.0
"""No attack lasts longer."""
REFUSED = ("not finite", "inside the body")
SWEPT_HZ = 240
SWEPT_WITHIN_M = 1e-4
"""How far the sweep may be off: motion between its times is not quite straight."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Settings.

    Attributes:
        graph: folder of a graph; "" for that of the embedded clips.
        attacks: how many; none of them may have to wait for a compilation.
        seed: draws them.
    """

    graph: str = ""
    attacks: int = 10_000
    seed: int = 0

    @classmethod
    def smoke(cls) -> dict[str, Any]:
        """A few at the embedded clips."""
        return {"attacks": 6}


def random_attack(kind: str, rng: np.random.Generator) -> Attack:
    """One attack of a kind, in the frame of a character at the origin."""
    side, height = rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 1.8)
    at = np.array([0.0, height, 0.0])
    start = at + rng.uniform(3, 9) * np.array([np.sin(side), rng.uniform(-0.05, 0.2), np.cos(side)])
    start[1] = max(start[1], 0.0)
    speed, arrives = rng.uniform(8, 14), rng.uniform(0.4, 1.9)
    if kind == "falling":
        return ball_attack(start, at, speed=speed + 6, arrives=arrives, gravity=True)
    if kind == "fast":
        return ball_attack(start, at, speed=rng.uniform(30, 200), arrives=arrives)
    if kind == "slow":
        return ball_attack(start, at, speed=rng.uniform(1.0, 3.0), arrives=arrives + 1)
    if kind == "tiny":
        return ball_attack(start, at, speed=speed, arrives=arrives, radius=0.01)
    if kind == "huge":
        return ball_attack(start * 2, at, speed=speed, arrives=arrives, radius=1.5)
    if kind == "at rest":
        return still(start * rng.uniform(0.1, 1.0), rng.uniform(0.1, 3.0), 0.12)
    if kind == "through the floor":
        low = at * [1, 0, 1] + [0, -0.3, 0]
        return moving(start, low, arrives - 0.3, arrives + 0.4)
    if kind == "under way":
        return ball_attack(start, at, speed=speed, arrives=rng.uniform(0.05, 0.3))
    if kind == "late":
        return ball_attack(start, at, speed=speed, arrives=rng.uniform(2, 3))
    if kind == "two balls":
        other = ball_attack(start[[2, 1, 0]], at, speed=speed, arrives=arrives + 0.2)
        return merge_attacks([ball_attack(start, at, speed=speed, arrives=arrives), other])
    if kind == "zigzag":
        times = np.linspace(0.2, 2.0, 8)
        centres = rng.normal(at, 0.8, size=(8, 1, 3))
        return Attack(times=times, centres=centres, radii=np.array([0.1]))
    if kind == "not finite":
        given = moving(start, at, 0.5, 1.0)
        return replace(given, centres=given.centres * np.nan)
    if kind == "inside the body":
        return still(np.array([0.0, 1.0, 0.0]), 1.0, 0.3)
    return ball_attack(start, at, speed=speed, arrives=arrives)


def still(place: np.ndarray, seconds: float, radius: float) -> Attack:
    """A sphere that does not move."""
    centres = np.stack([place, place])[:, None]
    return Attack(times=np.array([0.0, seconds]), centres=centres, radii=np.array([radius]))


def moving(start: np.ndarray, stop: np.ndarray, begin: float, end: float) -> Attack:
    """A sphere on a straight line, also where no ball could be thrown."""
    centres = np.stack([start, stop])[:, None]
    return Attack(times=np.array([begin, end]), centres=centres, radii=np.array([0.12]))


def run(config: Config) -> Results:
    graph, settings = graph_of(config.graph), AvoidanceConfig()
    rng = np.random.default_rng(config.seed)
    found: Counter[tuple[str, str]] = Counter()
    touched, raised = [], []
    seconds: dict[str, list[float]] = {kind: [] for kind in KINDS}
    watch = _Compilations()
    warm_up(graph, config=settings, horizon=LAST_S, spheres=2)
    programs, memory = watch.count, [_megabytes()]
    for number in tqdm(range(config.attacks), leave=False):
        kind = KINDS[number % len(KINDS)]
        attack, node = random_attack(kind, rng), int(rng.integers(graph.num_nodes))
        begin = time.perf_counter()
        try:
            answer = select(graph, node, attack, config=settings)
        except AttackError:
            found[kind, "refused"] += 1
            continue
        except Exception as error:  # counted: that there is none is what is to be shown
            raised.append(f"{kind}: {type(error).__name__}: {error}")
            continue
        seconds[kind].append(time.perf_counter() - begin)
        found[kind, answer.status] += 1
        if answer.status == "avoided":
            least = least_distance(graph, attack, answer.motion)
            if least < CLEAR_M - SWEPT_WITHIN_M:
                touched.append({"kind": kind, "number": number, "m": least})
        if number + 1 == config.attacks // 2:
            memory.append(_megabytes())
    memory.append(_megabytes())
    accepted = sum(
        n for (kind, status), n in found.items() if kind in REFUSED and status != "refused"
    )
    metrics = {
        "attacks": config.attacks,
        "raised": raised,
        "avoided_but_touched": len(touched),
        "touched": touched,
        "accepted_that_had_to_be_refused": accepted,
        "by_kind": {
            kind: {s: n for (k, s), n in sorted(found.items()) if k == kind} for kind in KINDS
        },
    }
    every = [x for each in seconds.values() for x in each]
    timings = {
        "programs_compiled_ahead": programs,
        "programs_compiled_later": watch.count - programs,
        "memory_mb": memory,
        "median_ms": 1e3 * float(np.median(every)),
        "p95_ms": 1e3 * float(np.percentile(every, 95)),
        "longest_ms": {kind: 1e3 * max(each) for kind, each in seconds.items() if each},
    }
    lines = (
        f"{config.attacks} attacks: {len(raised)} raised, {len(touched)} called avoided and"
        f" touched, {accepted} accepted that had to be refused",
        f"{programs} programs compiled ahead, {watch.count - programs} later; memory"
        f" {memory[0]:.0f} MB before, {memory[-2]:.0f} half-way, {memory[-1]:.0f} at the end;"
        f" median {timings['median_ms']:.2f} ms, p95 {timings['p95_ms']:.2f} ms",
    )
    return Results(metrics=metrics, timings=timings, lines=lines)


def least_distance(graph: MotionGraph, attack: Attack, motion: Motion) -> float:
    """Least distance of the surfaces of attack and body while the attack is there, m.

    Between two times of the sweep both are taken to move straight; when the attack changes its way
    and when spheres come and go are among the times.
    """
    last = (motion.num_frames - 1) / motion.frame_rate
    grid = np.arange(int(np.ceil(last * SWEPT_HZ)) + 1) / SWEPT_HZ
    times = np.unique(np.concatenate([grid, attack.times, *attack.lifetimes]))
    times = times[(times >= attack.start) & (times <= min(attack.end, last))]
    poses = sample(motion, times * motion.frame_rate)
    skeleton = replace(graph.skeleton, offsets=np.asarray(graph.skeleton.offsets, np.float64))
    root, rotations = (
        np.asarray(x, np.float64) for x in (poses.root_translation, poses.local_rotations)
    )
    spheres = preset_spheres(graph.skeleton)
    body = np.asarray(sphere_centres(spheres, np.asarray(forward(skeleton, root, rotations)[0])))
    centres, active = attack.sampled(times)
    there = (active[:-1] & active[1:])[..., None]
    nearest = np.where(there, _nearest(centres[:, :, None] - body[:, None]), np.inf)
    return float((nearest - attack.radii[:, None] - spheres.radii).min(initial=np.inf))


def _nearest(apart: Float[np.ndarray, "T I S 3"]) -> Float[np.ndarray, "V I S"]:
    """Least length of vectors that go straight from one to the next."""
    step = np.diff(apart, axis=0)
    square = np.maximum((step * step).sum(axis=-1), 1e-18)
    share = np.clip(-(apart[:-1] * step).sum(axis=-1) / square, 0.0, 1.0)
    return np.linalg.norm(apart[:-1] + share[..., None] * step, axis=-1)


class _Compilations:
    """Counts what is compiled, or read from the cache on disk, from now on."""

    def __init__(self) -> None:
        self.count = 0
        jax.monitoring.register_event_duration_secs_listener(self._heard)

    def _heard(self, event: str, duration_secs: float, **_: Any) -> None:
        self.count += event == "/jax/core/compile/backend_compile_duration"


def _megabytes() -> float:
    """Memory in use now."""
    jax.effects_barrier()
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


if __name__ == "__main__":
    one_thread()
    experiment(run, Config)
