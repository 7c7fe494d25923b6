"""What is left where nothing avoids: the walk that is played anyway, with an arm that parries."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.checks.written import WrittenWalk, sphere_trajectory, write_walk
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.parry.parry import AFTER_S, Parry, find_parry
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE
from mgjax.core.motion import Motion
from mgjax.core.shown import like
from mgjax.graph.feet.course import FeetState
from mgjax.graph.walk import Walk, extend, random_walk

OTHERS = 4
"""Walks that are tried beside the one that is touched least."""


def others_of(prepared: Prepared, node: int, attack: Attack, seed: int) -> Iterator[Walk]:
    """Walks drawn at random on which an arm may parry where it cannot on the chosen one."""
    seconds = attack.end + AFTER_S
    for number in range(OTHERS):
        yield random_walk(prepared.graph, node, seconds, seed + number)


def first_parried(
    prepared: Prepared,
    walks: Iterable[Walk],
    attack: Attack,
    config: AvoidanceConfig,
    begin: FeetState | None = None,
) -> tuple[int, Parry, WrittenWalk] | None:
    """The first of some walks on which an arm parries: its number, and how; None without one."""
    for number, walk in enumerate(walks):
        found = parried_walk(prepared, walk, attack, config, begin)
        if found is not None:
            return number, *found
    return None


def parried_walk(
    prepared: Prepared,
    walk: Walk,
    attack: Attack,
    config: AvoidanceConfig,
    begin: FeetState | None = None,
) -> tuple[Parry, WrittenWalk] | None:
    """A walk as it is written with an arm that parries; None where it is not hit, or none can.

    Args:
        prepared: of the graph.
        walk: what is played, with one speed per edge.
        attack: in the planar frame of its first pose, its times from now.
        config: settings, of an adult.
        begin: what the feet are off now; default: nothing.
    """
    graph, spheres = prepared.graph, prepared.tables.spheres
    seconds = attack.end + max(config.settle_s, AFTER_S)
    written = write_walk(graph, spheres, extend(graph, walk, seconds), seconds, None, attack, begin)
    assert written.clearance is not None, "there is an attack"
    if written.clearance >= CLEAR_M:
        return None
    own = for_body(config, graph.body_scale)
    found = find_parry(graph, written.motion, attack, own, written.clearance)
    if found is None:
        return None
    parry, motion = found
    motion = _cut(motion, max(attack.end + config.settle_s, parry.stop))
    trace = sphere_trajectory(graph, spheres, motion)
    changed = WrittenWalk(
        walk=written.walk, motion=motion, trace=trace, clearance=parry.clearance_m
    )
    return parry, changed


def _cut(motion: Motion, seconds: float) -> Motion:
    """The frames of a motion up to a moment, s."""
    count = int(np.ceil(seconds * EXPORT_RATE - 1e-6)) + 1
    shorter = replace(
        motion,
        root_translation=motion.root_translation[:count],
        local_rotations=motion.local_rotations[:count],
    )
    return like(shorter, motion)
