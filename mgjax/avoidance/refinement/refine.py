"""Near misses made clear: several walks at once, each by the least change, each checked exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.transform import shifted
from mgjax.avoidance.checks.written import clearance, sphere_trajectory
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.inside import too_deep
from mgjax.avoidance.refinement.played import (
    Played,
    Refiner,
    free_at,
    played,
    refiner_of,
    written_frames,
)
from mgjax.avoidance.refinement.problems import (
    empty_problem,
    lane_of,
    last_moment,
    padded,
)
from mgjax.avoidance.refinement.refinement import (
    Refinement,
    change_motion,
    change_of_joints,
    places_of,
    with_rows,
)
from mgjax.avoidance.refinement.solve import solve_compiled
from mgjax.avoidance.refinement.splines import SPLINES, basis
from mgjax.core.motion import Motion
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.feet.course import FeetState
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk

_SHRINKING = 3
_LITTLE = 1.12
"""A change so many times too large is made smaller, so often at most."""
ENOUGH_M = 0.003
"""Clearance of the written motion with which a change is good enough, of an adult."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Attempt:
    """A walk that may be changed.

    Attributes:
        played: as it is written.
        clearance: of that, m.
    """

    played: Played
    clearance: float


def attempts(
    prepared: Prepared,
    walks: Sequence[Walk],
    attack: Attack,
    config: AvoidanceConfig,
    begin: FeetState | None = None,
) -> list[Attempt]:
    """Walks as they are written, and how near an attack comes to each; see :func:`refine_walks`."""
    until, times = last_moment(attack, config), written_frames(attack)
    found: list[Attempt] = []
    for walk in walks:
        motion = played(prepared.graph, walk, until, begin=begin)
        least = _clearance(motion, motion.motion(times), attack, float(times[0]))
        found.append(Attempt(played=motion, clearance=least))
    return found


def within_reach(attempt: Attempt, config: AvoidanceConfig, scale: float) -> bool:
    """Whether moves within the cap can clear a walk at all: no sphere moves farther than joints."""
    return attempt.clearance + config.refine_max_m >= ENOUGH_M * scale


def refine_attempt(
    prepared: Prepared, attempt: Attempt, attack: Attack, config: AvoidanceConfig
) -> Refinement | None:
    """The least change that clears a walk; None where none is found. See :func:`refine_walks`."""
    refiner, scale = refiner_of(prepared.graph), prepared.graph.body_scale
    if attempt.clearance >= ENOUGH_M * scale:
        return _unchanged(refiner, attempt, attack)
    if not within_reach(attempt, config, scale):
        return None
    lane = lane_of(prepared, refiner, attempt.played, attack, config)
    if lane is None:
        return None
    solution = solve_compiled(refiner.rig, padded(lane))
    cleared = float(solution.clearance)
    if not np.isfinite(cleared) or cleared < 0:
        return None
    coefficients = np.asarray(solution.coefficients, np.float64)
    return checked(refiner, attempt, lane.start, lane.stop, coefficients, attack, config)


def refine_walks(
    prepared: Prepared,
    walks: Sequence[Walk],
    attack: Attack,
    config: AvoidanceConfig,
    *,
    begin: FeetState | None = None,
) -> list[Refinement | None]:
    """Least changes that clear some walks of an attack; None where none is found within the caps.

    Args:
        prepared: of the graph.
        walks: each from now on.
        attack: in the planar frame of their common node.
        config: settings of this graph's body (:func:`~mgjax.avoidance.config.for_body`).
        begin: what the feet are off now; default: nothing.

    Returns:
        One for each walk; of one that is clear as it is written it changes nothing. Every one that
        is not None was checked: the changed motion as it is written has a clearance of
        ``ENOUGH_M``, keeps within both caps, and has no limb deeper in the body than before, or
        than the capture and ``inside.DEPTH_M``.
    """
    return [
        refine_attempt(prepared, attempt, attack, config)
        for attempt in attempts(prepared, walks, attack, config, begin)
    ]


def compile_refining(prepared: Prepared, moments: int, spheres: int) -> None:
    """Changes a motion for nothing, so that no later call of this size compiles.

    Args:
        prepared: of the graph.
        moments: ``MOMENTS`` or ``MOST_MOMENTS``.
        spheres: of the attack, padded.
    """
    rig = refiner_of(prepared.graph).rig
    solve_compiled(rig, empty_problem(prepared.graph, rig, moments, spheres))


def checked(
    refiner: Refiner,
    attempt: Attempt,
    start: float,
    stop: float,
    coefficients: Float[np.ndarray, "K C"],
    attack: Attack,
    config: AvoidanceConfig,
) -> Refinement | None:
    """The change that some coefficients make; None unless the written motion is clear with it.

    Its clearance, and how far each joint moves and turns, are those of every written frame. A
    change that is a little too large is made smaller as a whole, since more than enough is aimed
    at.
    """
    rig, motion = refiner.rig, attempt.played
    graph, tiny = motion.graph, 1e-9
    frames = np.arange(round(start * EXPORT_RATE), round(stop * EXPORT_RATE) + 1) / EXPORT_RATE
    before = motion.motion(frames)
    were = places_of(rig, before)
    for _ in range(_SHRINKING):
        values = values_of(refiner, motion, start, stop, coefficients)
        after = change_motion(rig, before, frames, values, start)
        places = places_of(rig, after)
        moved, turned = change_of_joints(before, after, were, places)
        share = max(
            float(moved.max()) / max(config.refine_max_m, tiny),
            float(turned.max()) / max(config.refine_max_deg, tiny),
        )
        if share <= 1:
            break
        if share > _LITTLE:
            return None
        coefficients = coefficients * (0.999 / share)
    else:
        return None
    times = written_frames(attack)
    poses = with_rows(motion.motion(times), times, after, start)
    least = _clearance(motion, poses, attack, float(times[0]))
    if least < ENOUGH_M * graph.body_scale or too_deep(rig, were, places, graph.body_scale):
        return None
    some = np.flatnonzero((moved > 1e-5) | (turned > 1e-3))
    return Refinement(
        start=start,
        values=values,
        joints=tuple(graph.skeleton.names[j] for j in some),
        moved_m=tuple(moved[some].tolist()),
        turned_deg=tuple(turned[some].tolist()),
        clearance_before_m=attempt.clearance,
        clearance_m=least,
        coefficients=coefficients,
    )


def _unchanged(refiner: Refiner, attempt: Attempt, attack: Attack) -> Refinement:
    """What changes nothing of a walk that is clear as it is written."""
    channels = refiner.rig.channels
    return Refinement(
        start=float(written_frames(attack)[0]),
        values=np.zeros((2, channels)),
        joints=(),
        moved_m=(),
        turned_deg=(),
        clearance_before_m=attempt.clearance,
        clearance_m=attempt.clearance,
        coefficients=np.zeros((SPLINES, channels)),
    )


def retimed(
    prepared: Prepared,
    walk: Walk,
    timing: TimeWarp,
    refinement: Refinement,
    attack: Attack,
    config: AvoidanceConfig,
    begin: FeetState | None = None,
) -> Refinement | None:
    """A change of a walk, for the same walk that is played otherwise; None where it is not clear.

    Feet are planted at other times then. The arguments are those of :func:`refine_walks`.
    """
    start, stop = refinement.start, refinement.stop
    motion = played(prepared.graph, walk, last_moment(attack, config), timing=timing, begin=begin)
    refiner = refiner_of(prepared.graph)
    least = clearance_at(refiner, motion, attack, None, start)
    attempt = Attempt(played=motion, clearance=least)
    found = checked(refiner, attempt, start, stop, refinement.coefficients, attack, config)
    return None if found is None else replace(found, shift_s=refinement.shift_s)


def change_written(graph: MotionGraph, refinement: Refinement, motion: Motion) -> Motion:
    """A written motion, from now on, with the change of a refinement."""
    times = np.arange(motion.num_frames) / EXPORT_RATE
    return change_motion(refiner_of(graph).rig, motion, times, refinement.values, refinement.start)


def values_of(
    refiner: Refiner,
    motion: Played,
    start: float,
    stop: float,
    coefficients: Float[np.ndarray, "K C"],
) -> Float[np.ndarray, "W C"]:
    """Channels over the window, with planted feet left where they are."""
    frames = np.arange(round(start * EXPORT_RATE), round(stop * EXPORT_RATE) + 1) / EXPORT_RATE
    values = basis(frames, start, stop, SPLINES) @ coefficients
    legs = len(refiner.rig.legs)
    if legs:
        free = free_at(refiner, motion, start, stop, frames)
        values[:, -3 * legs :] *= np.repeat(free, 3, axis=1)
    return values


def clearance_at(
    refiner: Refiner,
    motion: Played,
    attack: Attack,
    values: Float[np.ndarray, "W C"] | None,
    start: float,
) -> float:
    """The exact check of a walk that is changed, over the time at which the attack is there, m."""
    times = written_frames(attack)
    poses = motion.motion(times)
    if values is not None:
        poses = change_motion(refiner.rig, poses, times, values, start)
    return _clearance(motion, poses, attack, float(times[0]))


def _clearance(motion: Played, poses: Motion, attack: Attack, begins: float) -> float:
    """The exact check of poses of a walk from a moment on, m."""
    spheres = refiner_of(motion.graph).spheres
    trace = sphere_trajectory(motion.graph, spheres, poses)
    return clearance(shifted(attack, begins), trace, spheres.radii)[1]


def refined_clearance(
    graph: MotionGraph,
    walk: Walk,
    refinement: Refinement,
    attack: Attack,
    begin: FeetState | None = None,
) -> float:
    """The exact check of a walk with the change of a refinement against another attack, m."""
    motion = played(graph, walk, attack.end + 2 / EXPORT_RATE, begin=begin)
    values, start = refinement.values, refinement.start
    return clearance_at(refiner_of(graph), motion, attack, values, start)
