"""Near misses made clear: several walks at once, each by the least change, each checked exactly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.transform import shifted
from mgjax.avoidance.checks.written import clearance, sphere_trajectory
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.played import Played, Refiner, free_at, refiner_of, written_frames
from mgjax.avoidance.refinement.problems import (
    MOMENTS,
    MOST_MOMENTS,
    Lane,
    empty_problem,
    lane_of,
    padded,
)
from mgjax.avoidance.refinement.refinement import (
    Refinement,
    change_motion,
    change_of_joints,
)
from mgjax.avoidance.refinement.solve import solve_lanes
from mgjax.avoidance.refinement.splines import SPLINES, basis
from mgjax.avoidance.timing.walk_warps import linear_warp, natural_starts
from mgjax.core.motion import Motion
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, extend

ENOUGH_M = 0.003
"""Clearance of the written motion with which a change is good enough, of an adult."""


def refine_walks(
    prepared: Prepared,
    walks: Sequence[Walk],
    attack: Attack,
    config: AvoidanceConfig,
    *,
    timings: Sequence[TimeWarp] | None = None,
) -> list[Refinement | None]:
    """Least changes that clear some walks of an attack; None where none is found within the caps.

    Args:
        prepared: of the graph.
        walks: each from now on.
        attack: in the planar frame of their common node.
        config: settings of this graph's body (:func:`~mgjax.avoidance.config.for_body`).
        timings: how the walks are played; default: as their scales say.

    Returns:
        One for each walk. Every one that is not None was checked: the changed motion as it is
        written has a clearance of ``ENOUGH_M`` and keeps within both caps.
    """
    graph, refiner = prepared.graph, refiner_of(prepared.graph)
    lanes: list[Lane | None] = []
    for number, walk in enumerate(walks):
        timing = linear_warp(graph, walk) if timings is None else timings[number]
        played = Played(graph=graph, walk=walk, timing=timing)
        lanes.append(lane_of(prepared, refiner, played, attack, config))
    some = [lane for lane in lanes if lane is not None]
    if not some:
        return [None] * len(walks)
    solution = solve_lanes(refiner.rig, padded(some))
    coefficients = np.asarray(solution.coefficients, np.float64)
    cleared = np.asarray(solution.clearance)
    found: list[Refinement | None] = []
    row = 0
    for lane in lanes:
        if lane is None:
            found.append(None)
            continue
        good = np.isfinite(cleared[row]) and cleared[row] >= 0
        found.append(
            checked(refiner, lane.played, lane.start, lane.stop, coefficients[row], attack, config)
            if good
            else None
        )
        row += 1
    return found


def compile_refining(prepared: Prepared, spheres: int) -> None:
    """Changes motions for nothing, so that no later call compiles: at both numbers of moments.

    Args:
        prepared: of the graph.
        spheres: of the attack, padded.
    """
    rig = refiner_of(prepared.graph).rig
    for moments in (MOMENTS, MOST_MOMENTS):
        solve_lanes(rig, empty_problem(prepared.graph, rig, moments, spheres))


def checked(
    refiner: Refiner,
    played: Played,
    start: float,
    stop: float,
    coefficients: Float[np.ndarray, "K C"],
    attack: Attack,
    config: AvoidanceConfig,
) -> Refinement | None:
    """The change that some coefficients make; None unless the written motion is clear with it.

    Its clearance, and how far each joint moves and turns, are those of every written frame.
    """
    rig, graph = refiner.rig, played.graph
    values = values_of(refiner, played, start, stop, coefficients)
    frames = np.arange(round(start * EXPORT_RATE), round(stop * EXPORT_RATE) + 1) / EXPORT_RATE
    before = played.motion(frames)
    after = change_motion(rig, before, frames, values, start)
    moved, turned = change_of_joints(rig, before, after)
    if moved.max() > config.refine_max_m or turned.max() > config.refine_max_deg:
        return None
    least = clearance_at(refiner, played, attack, values, start)
    if least < ENOUGH_M * graph.body_scale:
        return None
    some = np.flatnonzero((moved > 1e-5) | (turned > 1e-3))
    return Refinement(
        start=start,
        values=values,
        joints=tuple(graph.skeleton.names[j] for j in some),
        moved_m=tuple(moved[some].tolist()),
        turned_deg=tuple(turned[some].tolist()),
        clearance_before_m=clearance_at(refiner, played, attack, None, start),
        clearance_m=least,
        coefficients=coefficients,
    )


def retimed(
    prepared: Prepared,
    walk: Walk,
    timing: TimeWarp,
    refinement: Refinement,
    attack: Attack,
    config: AvoidanceConfig,
) -> Refinement | None:
    """A change of a walk, for the same walk that is played otherwise; None where it is not clear.

    Feet are planted at other times then. The arguments are those of :func:`refine_walks`.
    """
    graph = prepared.graph
    beyond = float(timing.at(np.array([refinement.stop]))[0] - natural_starts(graph, walk)[-1])
    longer = extend(graph, walk, float(walk.starts(graph)[-1]) + beyond)
    played = Played(graph=graph, walk=longer, timing=timing)
    start, stop = refinement.start, refinement.stop
    return checked(refiner_of(graph), played, start, stop, refinement.coefficients, attack, config)


def change_written(graph: MotionGraph, refinement: Refinement, motion: Motion) -> Motion:
    """A written motion, from now on, with the change of a refinement."""
    times = np.arange(motion.num_frames) / EXPORT_RATE
    return change_motion(refiner_of(graph).rig, motion, times, refinement.values, refinement.start)


def values_of(
    refiner: Refiner,
    played: Played,
    start: float,
    stop: float,
    coefficients: Float[np.ndarray, "K C"],
) -> Float[np.ndarray, "W C"]:
    """Channels over the window, with planted feet left where they are."""
    frames = np.arange(round(start * EXPORT_RATE), round(stop * EXPORT_RATE) + 1) / EXPORT_RATE
    values = basis(frames, start, stop, SPLINES) @ coefficients
    legs = len(refiner.rig.legs)
    if legs:
        free = free_at(refiner, played, start, stop, frames)
        values[:, -3 * legs :] *= np.repeat(free, 3, axis=1)
    return values


def clearance_at(
    refiner: Refiner,
    played: Played,
    attack: Attack,
    values: Float[np.ndarray, "W C"] | None,
    start: float,
) -> float:
    """The exact check of a walk that is changed, over the time at which the attack is there, m."""
    times = written_frames(attack)
    motion = played.motion(times)
    if values is not None:
        motion = change_motion(refiner.rig, motion, times, values, start)
    trace = sphere_trajectory(played.graph, refiner.spheres, motion)
    return clearance(shifted(attack, float(times[0])), trace, refiner.spheres.radii)[1]


def refined_clearance(
    graph: MotionGraph, walk: Walk, refinement: Refinement, attack: Attack
) -> float:
    """The exact check of a walk with the change of a refinement against another attack, m."""
    longer = extend(graph, walk, attack.end)
    played = Played(graph=graph, walk=longer, timing=linear_warp(graph, longer))
    values, start = refinement.values, refinement.start
    return clearance_at(refiner_of(graph), played, attack, values, start)
