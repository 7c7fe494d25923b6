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
    """Walks drawn at random on which an arm may parry where it cannot on the chosen one.

    With seeds after the one that is drawn with where there is no candidate.
    """
    seconds = attack.end + AFTER_S
    for number in range(OTHERS):
        yield random_walk(prepared.graph, node, seconds, seed + 1 + number)


def first_parried(
    prepared: Prepared,
    walks: Iterable[Walk],
    attack: Attack,
    config: AvoidanceConfig,
    begin: FeetState | None = None,
) -> tuple[int, Parry, WrittenWalk] | None:
    """The first of some walks that is hit and on which an arm parries, as it is then written.

    Args:
        prepared: of the graph.
        walks: the first is what is played otherwise, with one speed per edge.
        attack: in the planar frame of their first pose, its times from now.
        config: settings, of an adult.
        begin: what the feet are off now; default: nothing.

    Returns:
        Its number, and how; None without one, and where the first walk is not hit at all.
    """
    graph, spheres = prepared.graph, prepared.tables.spheres
    own = for_body(config, graph.body_scale)
    seconds = attack.end + max(config.settle_s, AFTER_S)
    for number, walk in enumerate(walks):
        longer = extend(graph, walk, seconds)
        written = write_walk(graph, spheres, longer, seconds, None, attack, begin)
        assert written.clearance is not None, "there is an attack"
        if written.clearance < CLEAR_M:
            found = find_parry(graph, written.motion, attack, own, written.clearance)
            if found is not None:
                parry, motion = found
                motion = _cut(motion, max(attack.end + config.settle_s, parry.stop))
                trace = sphere_trajectory(graph, spheres, motion)
                changed = replace(written, motion=motion, trace=trace, clearance=parry.clearance_m)
                return number, parry, changed
        elif number == 0:
            return None
    return None


def _cut(motion: Motion, seconds: float) -> Motion:
    """The frames of a motion up to a moment, s."""
    count = int(np.ceil(seconds * EXPORT_RATE - 1e-6)) + 1
    shorter = replace(
        motion,
        root_translation=motion.root_translation[:count],
        local_rotations=motion.local_rotations[:count],
    )
    return like(shorter, motion)
