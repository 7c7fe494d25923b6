"""Compiling ahead of time, so that no attack has to wait for it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import (
    FRAME_BUCKET,
    SPHERE_BUCKET,
    AttackBatch,
    empty_attack_batch,
)
from mgjax.avoidance.body.poses import PosedGraph
from mgjax.avoidance.candidates.batch import (
    CANDIDATE_BUCKETS,
    EDGE_BUCKET,
    LONG_CANDIDATE_BUCKETS,
    CandidateBatch,
    empty_candidate_batch,
)
from mgjax.avoidance.checks.bounds import MORE_LANES
from mgjax.avoidance.checks.fast import CHECK_FRAMES, Poses, nearest_of
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.search import bound, in_32_bits, search_one
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.index.protocol import CandidateIndex
from mgjax.avoidance.parry.parry import compile_parrying
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.problems import MOMENTS, MOST_MOMENTS
from mgjax.avoidance.refinement.refine import compile_refining
from mgjax.core.motion import Motion
from mgjax.core.parallel.run import run_all
from mgjax.core.xla.compilation import threads
from mgjax.graph.feet.course import FeetState
from mgjax.graph.feet.played import FRAMES, legs_of, play, with_feet
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk


def warm_up(
    graph: MotionGraph | Prepared,
    *,
    config: AvoidanceConfig | None = None,
    horizon: float = 3.0,
    spheres: int = 1,
) -> int:
    """Compiles everything that is needed to answer attacks, without slices.

    With a compilation cache on disk (``MGJAX_CACHE``) it takes seconds from the second time on.

    Args:
        graph: a motion graph with labelled avoidance parts.
        config: settings; only the graph's tables, ``form``, ``d0``, ``capacity``, ``refine`` and
            ``parry`` matter.
        horizon: attacks that are over by then, s from now, are answered without compiling; so
            are those of walks of up to 160 edges.
        spheres: the most spheres of an attack.

    Returns:
        How many programs there are.
    """
    calls = programs(graph, config=config, horizon=horizon, spheres=spheres)
    compile_all(calls)
    return len(calls)


def compile_for(
    graph: MotionGraph | Prepared,
    node: int,
    attack: Attack,
    *,
    config: AvoidanceConfig | None = None,
    index: CandidateIndex | None = None,
) -> None:
    """Prepares a graph and compiles what one attack needs, the search beside the feet, so that a
    first answer comes sooner.

    Args: those of :func:`mgjax.avoidance.select`, and its errors.
    """
    config = config or AvoidanceConfig()
    search = partial(choose, graph, node, attack, config=config, index=index)
    of = graph.graph if isinstance(graph, Prepared) else graph
    frames = math.ceil(attack.end * EXPORT_RATE) + 1
    feet = [] if legs_of(of) is None else _sizes(FRAMES, 8, frames)[-1:]
    compile_all([search, *(partial(_keep_feet, of, size) for size in feet)])


def compile_all(
    calls: Sequence[Callable[[], object]], watch: Callable[[int], object] | None = None
) -> None:
    """Makes calls of :func:`programs`, as many at a time as compiled code has threads: compiling
    one takes one thread.

    Args:
        calls: in this order.
        watch: told how many are done, beginning with none.
    """
    watch = watch or (lambda done: None)
    watch(0)
    count = threads()
    with ThreadPoolExecutor(count) as pool:
        for done, _ in enumerate(run_all(pool, _made, calls, ahead=count), start=1):
            watch(done)


def _made(call: Callable[[], object]) -> None:
    call()


def programs(
    graph: MotionGraph | Prepared,
    *,
    config: AvoidanceConfig | None = None,
    horizon: float = 3.0,
    spheres: int = 1,
) -> list[Callable[[], object]]:
    """A call for each program of :func:`warm_up`, which compiles it.

    Those that nearly every attack needs come first: of short walks, then the checks, then of long
    walks, and refinement and parries last.
    """
    config = config or AvoidanceConfig()
    prepared = prepared_for(graph, config)
    slots = _sizes(SPHERE_BUCKET, 8, spheres)
    short: list[Callable[[], object]] = []
    long: list[Callable[[], object]] = []
    shapes = (
        (short, EDGE_BUCKET, FRAME_BUCKET, CANDIDATE_BUCKETS),
        (long, 4 * EDGE_BUCKET, 32 * FRAME_BUCKET, LONG_CANDIDATE_BUCKETS),
    )
    for calls, length, known, sizes in shapes:
        for slot in slots:
            attacks = empty_attack_batch(known, slot, 3 * len(prepared.device.radii))
            for size in (s for k, s in enumerate(sizes) if not k or sizes[k - 1] < config.capacity):
                walks = empty_candidate_batch(length, size, shared=True)
                calls.append(partial(_search, prepared, walks, attacks, config))
            calls.append(partial(_bound, prepared, length, attacks))
    frames = math.ceil(horizon * EXPORT_RATE) + 1
    checks = [
        partial(_check, prepared.posed, count, slot)
        for count in _sizes(CHECK_FRAMES, 4, frames)
        for slot in slots
    ]
    refined = [
        partial(compile_refining, prepared, moments, slot)
        for slot in slots
        for moments in (MOMENTS, MOST_MOMENTS)
    ]
    if config.refine == "off":
        refined = []
    if config.parry == "on":
        refined.append(partial(compile_parrying, prepared.graph))
    return [*short, *checks, *_feet_programs(prepared.graph, frames), *long, *refined]


def _feet_programs(graph: MotionGraph, frames: int) -> list[Callable[[], object]]:
    """A call for each size of motions, and of a few poses, whose feet are kept."""
    if legs_of(graph) is None:
        return []
    sizes = _sizes(FRAMES, 8, frames)
    return [partial(feet, graph, size) for feet in (_keep_feet, _put_feet) for size in sizes]


def _keep_feet(graph: MotionGraph, count: int) -> tuple[Motion, FeetState]:
    """A body that stands still for so many frames."""
    walk = Walk(edges=np.zeros(1, np.int64), scales=np.ones(1))
    return play(graph, walk, np.linspace(0.0, 1e-3, count), rate=EXPORT_RATE)


def _put_feet(graph: MotionGraph, count: int) -> Motion:
    """So many poses of it."""
    motion, states = _keep_feet(graph, count)
    return with_feet(graph, motion, states)


def _search(
    prepared: Prepared, walks: CandidateBatch, attacks: AttackBatch, config: AvoidanceConfig
) -> None:
    """One search for nothing."""
    search_one(
        prepared.device,
        walks,
        attacks,
        in_32_bits(config.energy),
        frame_rate=prepared.graph.frame_rate,
        limit_scale=config.limit_scale,
    )


def _bound(prepared: Prepared, length: int, attacks: AttackBatch) -> None:
    """Bounds of nothing."""
    lanes = empty_candidate_batch(length, MORE_LANES, shared=True)
    scales = np.ones((length, MORE_LANES), np.float32)
    bound(prepared.device, lanes, scales, attacks, frame_rate=prepared.graph.frame_rate)


def _sizes(least: int, factor: int, most: int) -> list[int]:
    """The sizes that up to ``most`` items are padded to."""
    sizes = [least]
    while sizes[-1] < most:
        sizes.append(sizes[-1] * factor)
    return sizes


def _check(posed: PosedGraph, count: int, spheres: int) -> None:
    """One exact check of nothing."""
    rows, places = np.zeros(count, np.int32), np.zeros((count, 3), np.float32)
    poses = Poses(
        low=rows, high=rows, place_low=places, place_high=places, share=places[:, 0].copy()
    )
    moments = 2 * count - 1
    nearest_of(
        posed.poses,
        poses,
        np.zeros((moments, spheres, 3), np.float32),
        np.ones(spheres, np.float32),
        np.ones((moments - 1, spheres), np.float32),
    ).block_until_ready()
