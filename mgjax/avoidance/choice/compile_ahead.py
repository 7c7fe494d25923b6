"""Compiling ahead of time, so that no attack has to wait for it."""

from __future__ import annotations

import math

import numpy as np

from mgjax.avoidance.attacks.batch import FRAME_BUCKET, SPHERE_BUCKET, empty_attack_batch
from mgjax.avoidance.body.poses import PosedGraph
from mgjax.avoidance.candidates.batch import (
    CANDIDATE_BUCKETS,
    EDGE_BUCKET,
    LONG_CANDIDATE_BUCKETS,
    empty_candidate_batch,
)
from mgjax.avoidance.checks.bounds import MORE_LANES
from mgjax.avoidance.checks.fast import CHECK_FRAMES, Poses, nearest_of
from mgjax.avoidance.choice.search import bound, in_32_bits, search_one
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.graph.types import MotionGraph


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
        config: settings; only the graph's tables, ``form``, ``d0`` and ``capacity`` matter.
        horizon: attacks that are over by then, s from now, are answered without compiling; so
            are those of walks of up to 160 edges.
        spheres: the most spheres of an attack.

    Returns:
        How many programs there are.
    """
    config = config or AvoidanceConfig()
    prepared = prepared_for(graph, config)
    device, rate = prepared.device, prepared.graph.frame_rate
    energy = in_32_bits(config.energy)
    slots = _sizes(SPHERE_BUCKET, 8, spheres)
    frames = math.ceil(horizon * EXPORT_RATE) + 1
    programs = 0
    shapes = (
        (EDGE_BUCKET, FRAME_BUCKET, CANDIDATE_BUCKETS),
        (4 * EDGE_BUCKET, 32 * FRAME_BUCKET, LONG_CANDIDATE_BUCKETS),
    )
    for length, known, sizes in shapes:
        for attack_batch in (empty_attack_batch(known, slot) for slot in slots):
            for size in (s for k, s in enumerate(sizes) if not k or sizes[k - 1] < config.capacity):
                walks = empty_candidate_batch(length, size, shared=True)
                limit = config.limit_scale
                search_one(device, walks, attack_batch, energy, frame_rate=rate, limit_scale=limit)
                programs += 1
            lanes = empty_candidate_batch(length, MORE_LANES, shared=True)
            scales = np.ones((length, MORE_LANES), np.float32)
            bound(device, lanes, scales, attack_batch, frame_rate=rate)
            programs += 1
    for count in _sizes(CHECK_FRAMES, 4, frames):
        for slot in slots:
            _check(prepared.posed, count, slot)
            programs += 1
    return programs


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
