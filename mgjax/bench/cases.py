"""What ``mgjax bench all`` measures: an entry point, what grows, and a bare kernel beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.energy.energies import energies_batch
from mgjax.avoidance.many.attacks import select_batch
from mgjax.avoidance.many.settings import sweep_energies
from mgjax.ballsport.aiming.passes import aim_batch
from mgjax.ballsport.ball.physics import BallPhysics
from mgjax.ballsport.ball.trajectory import fly
from mgjax.ballsport.hits.detect import find_hits
from mgjax.bench.graph import WINDOW, smooth_motion
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.graph.distances.distance import distance_matrix, normalised_weights
from mgjax.graph.distances.minima import find_minima
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.ik.chain import fabrik

Work = Callable[[], Any]
CANDIDATES, MOMENTS, SPHERES, JOINTS = 128, 40, 24, 9


@dataclass(frozen=True, kw_only=True)
class Case:
    """One entry point over one quantity.

    Attributes:
        name: of the entry point, below ``mgjax``.
        axis: what grows.
        sizes: ascending.
        make: from a size the work, without arguments.
        items: how many numbers the bare kernel goes over, from a size.
    """

    name: str
    axis: str
    sizes: tuple[int, ...]
    make: Callable[[int], Work]
    items: Callable[[int], int]


def bare_pass(items: int) -> Work:
    """One multiply and add per number, summed: the least that anything does with its input."""
    values = jnp.asarray(np.random.default_rng(0).normal(size=max(items, 1)), jnp.float32)
    run = jax.jit(lambda x: jnp.sum(2 * x + 1))
    return lambda: run(values)


def cases(graph: MotionGraph | None = None) -> list[Case]:
    """All cases; those on a graph only where one is given."""
    found = [
        Case(
            name="core.kinematics.forward", axis="frames", sizes=(64, 512, 4096),
            make=lambda n: _kinematics(n, 31), items=lambda n: 31 * 7 * n,
        ),
        Case(
            name="core.kinematics.forward", axis="joints", sizes=(8, 32, 128),
            make=lambda n: _kinematics(512, n), items=lambda n: 512 * 7 * n,
        ),
        Case(
            name="graph.distance_matrix", axis="frames", sizes=(256, 1024, 4096),
            make=_distances, items=lambda n: n * n,
        ),
        Case(
            name="graph.distances.find_minima", axis="frames", sizes=(256, 1024, 4096),
            make=_minima, items=lambda n: n * n,
        ),
        Case(
            name="avoidance.energies_batch", axis="candidates", sizes=(32, 128, 512),
            make=lambda n: _energies(n, SPHERES), items=lambda n: 3 * MOMENTS * n * SPHERES,
        ),
        Case(
            name="avoidance.energies_batch", axis="spheres", sizes=(8, 24, 72),
            make=lambda n: _energies(CANDIDATES, n), items=lambda n: 3 * MOMENTS * CANDIDATES * n,
        ),
        Case(
            name="hybrid.fabrik", axis="batch", sizes=(64, 512, 4096),
            make=lambda n: _chains(n, JOINTS), items=lambda n: 3 * JOINTS * n,
        ),
        Case(
            name="hybrid.fabrik", axis="joints", sizes=(4, 8, 16),
            make=lambda n: _chains(512, n), items=lambda n: 3 * 512 * n,
        ),
        Case(
            name="ballsport.fly", axis="frames", sizes=(64, 512, 4096),
            make=_flight, items=lambda n: 3 * n,
        ),
        Case(
            name="ballsport.aim_batch", axis="batch", sizes=(16, 128, 1024),
            make=_passes, items=lambda n: 9 * n,
        ),
        Case(
            name="ballsport.find_hits", axis="frames", sizes=(1000, 4000, 16000),
            make=_hits, items=lambda n: 3 * n,
        ),
    ]  # fmt: skip
    return found if graph is None else found + _on_graph(graph)


def _on_graph(graph: MotionGraph) -> list[Case]:
    """Searches; a bare pass over a few numbers says how much quicker the machine is."""
    config = AvoidanceConfig(refine="off")
    rng = np.random.default_rng(0)
    balls = [
        (int(rng.integers(graph.num_nodes)), ball_from(rng.uniform(0, 6.28), 1.2))
        for _ in range(1024)
    ]

    def one_by_one(count: int) -> Work:
        return lambda: [choose(graph, *ball, config=config).status for ball in balls[:count]]

    def at_once(count: int) -> Work:
        nodes, attacks = zip(*balls[:count], strict=True)
        return lambda: select_batch(graph, nodes, attacks, config=config).clearance

    def settings(count: int) -> Work:
        several = [EnergyConfig(D_body=float(d)) for d in np.linspace(0.1, 1.0, count)]
        return lambda: sweep_energies(graph, *balls[0], several, config=config).clearance

    def items(count: int) -> int:
        return 10_000 * count

    return [
        Case(name="avoidance.choose", axis="attacks", sizes=(4, 16), make=one_by_one, items=items),
        Case(
            name="avoidance.select_batch", axis="batch", sizes=(64, 256, 1024),
            make=at_once, items=items,
        ),
        Case(
            name="avoidance.sweep_energies", axis="settings", sizes=(4, 16, 64),
            make=settings, items=items,
        ),
    ]  # fmt: skip


def _kinematics(frames: int, joints: int) -> Work:
    rng = np.random.default_rng(0)
    skeleton = Skeleton(
        names=tuple(f"j{i}" for i in range(joints)),
        parents=(-1, *(max(i - 3, 0) for i in range(joints - 1))),
        offsets=rng.normal(size=(joints, 3), scale=0.2).astype(np.float32),
    )
    turns = rng.normal(size=(frames, joints, 4))
    turns = jnp.asarray(turns / np.linalg.norm(turns, axis=-1, keepdims=True), jnp.float32)
    roots = jnp.asarray(rng.normal(size=(frames, 3)), jnp.float32)
    run = jax.jit(lambda root, turn: forward(skeleton, root, turn)[0])
    return partial(run, roots, turns)


def _distances(frames: int) -> Work:
    a, b = (smooth_motion(frames + WINDOW - 1, seed=s) for s in (0, 1))
    return lambda: distance_matrix(a, b, window=WINDOW)


def _minima(frames: int) -> Work:
    motion = smooth_motion(frames + WINDOW - 1)
    weights = normalised_weights(None, motion.shape[1])
    ends = np.array([0]), np.array([len(motion)])
    return lambda: (
        find_minima(motion, *ends, weights, window=WINDOW, neighbourhood=1, threshold=0.1).distances
    )


def _energies(candidates: int, spheres: int) -> Work:
    rng = np.random.default_rng(0)
    body = rng.normal(scale=0.4, size=(3, MOMENTS, candidates, spheres)).astype(np.float32)
    ball = np.zeros((3, MOMENTS, 1), np.float32)
    ball[0, :, 0] = np.linspace(-10, 10, MOMENTS)
    active = np.ones((MOMENTS, candidates), bool)
    arrays = (
        ball, np.full(1, 0.12, np.float32), body, np.full(spheres, 0.1, np.float32),
        body[:, 10], active, active,
    )  # fmt: skip
    arrays = tuple(jnp.asarray(x) for x in arrays)
    run = jax.jit(partial(energies_batch, dt=0.05, config=EnergyConfig()))
    return lambda: run(*arrays)


def _chains(chains: int, joints: int) -> Work:
    rng = np.random.default_rng(0)
    steps = rng.normal(size=(chains, joints - 1, 3), scale=0.2)
    places = np.concatenate([np.zeros((chains, 1, 3)), np.cumsum(steps, axis=1)], axis=1)
    reach = np.linalg.norm(steps, axis=-1).sum(axis=-1)
    way = rng.normal(size=(chains, 3))
    targets = way * (0.7 * reach / np.linalg.norm(way, axis=-1))[:, None]
    joints_, targets_ = jnp.asarray(places, jnp.float32), jnp.asarray(targets, jnp.float32)
    run = jax.jit(fabrik)
    return lambda: run(joints_, targets_)


def _flight(count: int) -> Work:
    times = jnp.linspace(0, 2, count)
    start, speed = jnp.array([0, 0.5, 0.0]), jnp.array([0, 3, 6.0])
    run = jax.jit(partial(fly, physics=BallPhysics()))
    return lambda: run(start, speed, times)


def _passes(count: int) -> Work:
    rng = np.random.default_rng(0)
    starts = rng.uniform([-1, 0.1, -1], [1, 0.6, 1], (count, 3))
    targets = rng.uniform([3, 0.2, 3], [8, 1.5, 8], (count, 3))
    guesses = (targets - starts) + [0, 3, 0]
    return lambda: aim_batch(starts, targets, bounces=1, guesses=guesses).velocity


def _hits(frames: int) -> Work:
    t = np.arange(frames) / 60
    path = np.stack([np.sin(6 * t), 0.3 + 0.25 * np.sin(7 * t), 0 * t], axis=-1)
    return lambda: len(find_hits(path, 60.0))


def named(found: Sequence[Case], words: Sequence[str]) -> list[Case]:
    """Those cases whose name or quantity has one of the words; all without words."""
    return [
        case
        for case in found
        if not words or any(word in f"{case.name} {case.axis}" for word in words)
    ]
