"""Work of the ball: the launch with which it is at a target at a given time."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from experiments.benchmarks.beside.calls import Calls
from experiments.benchmarks.beside.types import Job
from mgjax.ballsport import BallPhysics, aim, fly

PHYSICS = BallPhysics(drag=0.0, restitution=0.7)
START = (0.0, 1.0, 0.0)
MET_M = 1e-3
EXACT = 1e3
"""What a second off the wanted time counts beside a m/s, m/s². mgjax takes the time as a wish, and
so much keeps it to a millisecond for most passes; the peer takes it as given."""


def passes(seed: int, items: int, *, bounces: int) -> Job:
    """Passes without drag from 1 m up, each with a guess some m/s away from the launch."""
    rng = np.random.default_rng(seed)
    velocities = np.stack(
        [
            rng.uniform(4, 7, items),
            rng.uniform(2, 4, items) - 4 * bounces,
            rng.uniform(-1, 1, items),
        ],
        axis=1,
    )
    duration = 0.6 if not bounces else 1.0
    launches = velocities.astype(np.float32)
    start, when = np.array(START, np.float32), np.array([duration], np.float32)
    targets = np.stack([np.asarray(fly(start, v, when, physics=PHYSICS))[0] for v in launches])
    guesses = (velocities + rng.normal(scale=1.0, size=(items, 3))).astype(np.float32)

    def call(number: int) -> Any:
        found = aim(
            start,
            targets[number],
            bounces=bounces,
            guess=guesses[number],
            physics=PHYSICS,
            flight_time=duration,
            time_weight=EXACT,
        )
        return jax.block_until_ready(found)

    def miss(number: int, found: Any) -> float:
        there = fly(start, found.velocity, np.asarray(found.time)[None], physics=PHYSICS)
        return float(np.linalg.norm(np.asarray(there)[0] - targets[number]))

    data = {
        "start": list(START),
        "targets": targets.tolist(),
        "guesses": guesses.tolist(),
        "duration": duration,
        "gravity": PHYSICS.gravity,
        "radius": PHYSICS.radius,
    }
    return Job(data=data, ours=Calls(count=items, call=call, miss=miss), tolerance=MET_M)
