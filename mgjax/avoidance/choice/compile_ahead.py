"""Compiling ahead of time, so that no attack has to wait for it."""

from __future__ import annotations

import math

import numpy as np

from mgjax.avoidance.attacks.batch import FRAMES, SPHERES, empty_shot
from mgjax.avoidance.body.poses import PosedGraph
from mgjax.avoidance.candidates.batch import LENGTH, LONG_SIZES, SIZES, empty_walks
from mgjax.avoidance.checks.bounds import MORE_LANES
from mgjax.avoidance.checks.fast import CHECK_FRAMES, Poses, nearest_of
from mgjax.avoidance.choice.search import bound, on_device, search_one
from mgjax.avoidance.config import AvoidanceConfig, validate_config
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
    validate_config(config)
    prepared = prepared_for(graph, config)
    device, rate = prepared.device, prepared.graph.frame_rate
    energy = on_device(config.energy)
    slots = _sizes(SPHERES, 8, spheres)
    frames = math.ceil(horizon * EXPORT_RATE) + 1
    programs = 0
    shapes = ((LENGTH, FRAMES, SIZES), (4 * LENGTH, 32 * FRAMES, LONG_SIZES))
    for length, known, sizes in shapes:
        for shot in (empty_shot(known, slot) for slot in slots):
            for size in (s for k, s in enumerate(sizes) if not k or sizes[k - 1] < config.capacity):
                walks = empty_walks(length, size, shared=True)
                limit = config.limit_scale
                search_one(device, walks, shot, energy, frame_rate=rate, limit_scale=limit)
                programs += 1
            lanes = empty_walks(length, MORE_LANES, shared=True)
            scales = np.ones((length, MORE_LANES), np.float32)
            bound(device, lanes, scales, shot, frame_rate=rate)
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
