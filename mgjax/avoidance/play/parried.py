"""Parries of a planner: found for a path before it is played, and checked after it was."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.transform import shifted
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.checks.written import clearance, sphere_trajectory
from mgjax.avoidance.config import AvoidanceConfig, for_body
from mgjax.avoidance.parry.checked import met, track_of
from mgjax.avoidance.parry.guard import guard_of
from mgjax.avoidance.parry.parry import AFTER_S, Parry, find_parry
from mgjax.avoidance.play.timeline import Piece, line_of
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.rates import CLEAR_M, EXPORT_RATE
from mgjax.core.motion import Motion
from mgjax.graph.feet.course import FeetState
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, extend


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The exact check of what was played.

    Attributes:
        clearance: signed distance of attack and body, m; of the rest of the body if it is parried.
        limb: that parried, or None.
    """

    clearance: float
    limb: str | None = None


def find_parried(
    prepared: Prepared,
    node: int,
    walks: Iterable[Walk],
    attack: Attack,
    config: AvoidanceConfig,
    feet: FeetState | None,
) -> tuple[Walk, Parry] | None:
    """The first of some walks that is hit and on which an arm parries.

    None without one, and where the first walk is not hit at all.

    Args:
        prepared: of the graph.
        node: where they begin.
        walks: what may be played.
        attack: in the planar frame of the node.
        config: settings, of an adult.
        feet: what the feet are off where the walks begin, in the same frame.
    """
    graph = prepared.graph
    seconds = attack.end + AFTER_S
    own = for_body(config, graph.body_scale)
    for number, walk in enumerate(walks):
        longer = extend(graph, walk, seconds + 0.5)
        piece = line_of(graph, node, longer, feet).between(0.0, seconds, feet=True)
        gap = played_clearance(graph, piece, attack, 0.0)
        if gap >= CLEAR_M and number == 0:
            return None
        if gap >= CLEAR_M:
            continue
        motion = _motion(graph, piece, 0, int(np.ceil(seconds * EXPORT_RATE)))
        found = find_parry(graph, motion, attack, own, gap)
        if found is not None:
            return longer, found[0]
    return None


def outcome_of(graph: MotionGraph, piece: Piece, attack: Attack, since: float) -> Outcome:
    """What became of an attack of the world from ``since`` to its end; see :class:`Outcome`."""
    gap = played_clearance(graph, piece, attack, since)
    parries = [change.change for change in piece.changes if isinstance(change.change, Parry)]
    if gap >= CLEAR_M or not parries:
        return Outcome(clearance=gap)
    first, last = _frames(attack, since)
    guard, motion = guard_of(graph), _motion(graph, piece, first, last)
    track, trace = track_of(guard, motion)
    here = shifted(attack, first / EXPORT_RATE)
    for parry in parries:
        for sphere in range(len(attack.radii)):
            found = met(guard, guard.arm(parry.side), track, trace, here, sphere)
            if found is not None:
                return Outcome(clearance=found.clearance, limb=found.limb)
    return Outcome(clearance=gap)


def played_clearance(graph: MotionGraph, piece: Piece, attack: Attack, since: float) -> float:
    """Signed distance of an attack of the world and what was played from ``since`` to its end, m.

    The exact check of :mod:`mgjax.avoidance.checks.written` at the frames of the written motion,
    which are counted from 0 s on the planner's clock.
    """
    first, last = _frames(attack, since)
    spheres = preset_spheres(graph.skeleton)
    trace = sphere_trajectory(graph, spheres, _motion(graph, piece, first, last))
    return clearance(shifted(attack, first / EXPORT_RATE), trace, spheres.radii)[1]


def _frames(attack: Attack, since: float) -> tuple[int, int]:
    """The written frames around an attack from ``since`` on."""
    first, last = int(np.floor(since * EXPORT_RATE)), int(np.ceil(attack.end * EXPORT_RATE))
    return first, max(last, first + 1)


def _motion(graph: MotionGraph, piece: Piece, first: int, last: int) -> Motion:
    """The written frames of a piece, both ends included."""
    motion = piece.sample(graph, np.arange(first, last + 1) / EXPORT_RATE)
    return replace(motion, frame_rate=EXPORT_RATE)
