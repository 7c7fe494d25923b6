"""Near misses made clear: several walks at once, each by the least change, each checked exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import jax
import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import SPHERE_BUCKET
from mgjax.avoidance.attacks.transform import shifted
from mgjax.avoidance.body.spheres import BodySpheres, preset_spheres, sphere_centres
from mgjax.avoidance.checks.written import clearance, sphere_trajectory
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.rates import EXPORT_RATE, FAR
from mgjax.avoidance.refinement.refinement import (
    Refinement,
    change_motion,
    change_of_joints,
    free_feet,
)
from mgjax.avoidance.refinement.rig import Rig, make_rig, unit_of
from mgjax.avoidance.refinement.solve import PER_LANE, Problem, solve_lanes
from mgjax.avoidance.refinement.splines import SPLINES, basis, size_matrix
from mgjax.avoidance.timing.walk_warps import linear_warp
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.cache import cached
from mgjax.graph.plants import planted_frames
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, frames_at, sample_walk

MARGIN_M = 0.008
"""Clearance that is aimed at, of an adult."""
ENOUGH_M = 0.003
"""Clearance of the written motion with which a change is good enough."""
LEAD_S = 0.5
"""How long before the first contact the change begins, and after the last one ends."""
MOMENTS = 24
"""Written frames near the attack that a call is compiled for, and twice as many, …"""
OTHERS = 16
"""Moments of the whole window at which bounds are looked at."""
MOST_MOMENTS = 96
"""Of longer contacts fewer frames a second are looked at while changing; all in the check."""
UNIT_M = 0.05
UNIT_RAD = float(np.radians(10.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Refiner:
    """What changing motions of a graph takes.

    Attributes:
        rig: the channels of its body.
        spheres: of its body.
        plants: which foot of each leg of the rig stands in which frame of the graph. [F, L]
    """

    rig: Rig
    spheres: BodySpheres
    plants: Bool[np.ndarray, "F L"]


def refiner_of(graph: MotionGraph) -> Refiner:
    """The refiner of a graph, made once."""
    return cached(graph, ("avoidance", "refiner"), lambda: _make(graph))


def _make(graph: MotionGraph) -> Refiner:
    spheres = preset_spheres(graph.skeleton)
    rig = make_rig(graph, spheres)
    return Refiner(rig=rig, spheres=spheres, plants=planted_frames(graph)[:, : len(rig.legs)])


@dataclass(frozen=True, kw_only=True, eq=False)
class Played:
    """A walk as it is played.

    Attributes:
        graph, walk: the walk.
        timing: which moment of it, as captured, is shown when.
    """

    graph: MotionGraph
    walk: Walk
    timing: TimeWarp

    def motion(self, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses at some times."""
        poses = sample_walk(self.graph, self._captured, self.timing.at(times))
        return replace(poses, frame_rate=EXPORT_RATE)

    def planted(self, plants: Bool[np.ndarray, "F L"], times: np.ndarray) -> np.ndarray:
        """Which feet stand at some times, where either of the two frames says so."""
        frames = frames_at(self.graph, self._captured, self.timing.at(times))
        return plants[frames.low] | plants[frames.high]

    @property
    def _captured(self) -> Walk:
        return Walk(edges=self.walk.edges, scales=np.ones(len(self.walk.edges)))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Lane:
    """One motion that is to be changed.

    Attributes:
        played: the walk.
        times: of the written frames at which the attack may reach the body. [T]
        start, stop: of the window, s.
        problem: of these frames, not padded.
    """

    played: Played
    times: Float[np.ndarray, " T"]
    start: float
    stop: float
    problem: Problem


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
    lanes: list[_Lane | None] = []
    for number, walk in enumerate(walks):
        timing = linear_warp(graph, walk) if timings is None else timings[number]
        played = Played(graph=graph, walk=walk, timing=timing)
        lanes.append(_lane(prepared, refiner, played, attack, config))
    some = [lane for lane in lanes if lane is not None]
    if not some:
        return [None] * len(walks)
    solution = solve_lanes(refiner.rig, _padded(some))
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


def _lane(
    prepared: Prepared, refiner: Refiner, played: Played, attack: Attack, config: AvoidanceConfig
) -> _Lane | None:
    """The problem of one motion; None where the attack never comes near it."""
    scale = prepared.graph.body_scale
    times = written_frames(attack)
    poses = played.motion(times)
    centres, active = attack.sampled(np.clip(times, attack.start, attack.end))
    away = np.linalg.norm(centres - poses.root_translation[:, None], axis=-1)
    step = attack.largest_speed / EXPORT_RATE
    slack = 2 * config.refine_max_m + MARGIN_M * scale + step
    close = np.flatnonzero((away - attack.radii <= prepared.posed.reach + slack).any(axis=1))
    if not close.size:
        return None
    span = slice(int(close[0]), int(close[-1]) + 1)
    times, centres, active = times[span], centres[span], active[span]
    root, rotations = poses.root_translation[span], poses.local_rotations[span]
    positions, _ = forward(prepared.graph.skeleton, root, rotations)
    body = np.asarray(sphere_centres(refiner.spheres, np.asarray(positions)))
    gap = np.linalg.norm(centres[:, :, None] - body[:, None], axis=-1)
    gap = gap - attack.radii[:, None] - refiner.spheres.radii
    gap = np.where(active[..., None], gap, FAR).min(axis=(1, 2))
    near = np.flatnonzero(gap <= slack)
    touched = np.flatnonzero(gap <= MARGIN_M * scale + 0.5 * step)
    if not near.size or not touched.size:
        return None
    first, last = max(int(near[0]) - 1, 0), min(int(near[-1]) + 1, len(times) - 1)
    stride = -(-(last - first + 1) // MOST_MOMENTS)
    rows = np.arange(first, last + 1, stride)
    start = max(float(times[touched[0]]) - LEAD_S, 0.0)
    start = np.floor(start * EXPORT_RATE) / EXPORT_RATE
    stop = np.ceil((float(times[touched[-1]]) + LEAD_S) * EXPORT_RATE) / EXPORT_RATE
    others = np.linspace(start, stop, OTHERS + 2)[1:-1]
    rest = played.motion(others)
    moments = np.concatenate([times[rows], others])
    return _Lane(
        played=played,
        times=times[rows],
        start=float(start),
        stop=float(stop),
        problem=Problem(
            root=np.concatenate([root[rows], rest.root_translation]),
            rotations=np.concatenate([rotations[rows], rest.local_rotations]),
            basis=basis(moments, start, stop).astype(np.float32),
            free=_free(refiner, played, start, stop, moments).astype(np.float32),
            attack=centres[rows].astype(np.float32),
            radii=attack.radii.astype(np.float32),
            absent=(~attack.lives(times[rows])).astype(np.float32),
            size=size_matrix().astype(np.float32),
            unit=unit_of(refiner.rig, UNIT_M * scale, UNIT_RAD).astype(np.float32),
            margin=np.asarray(MARGIN_M * scale, np.float32),
            max_m=np.asarray(config.refine_max_m, np.float32),
            max_rad=np.asarray(np.radians(config.refine_max_deg), np.float32),
        ),
    )


def written_frames(attack: Attack) -> Float[np.ndarray, " T"]:
    """Times of the written frames from just before an attack is there until just after, s."""
    first = int(np.floor(max(attack.start, 0.0) * EXPORT_RATE))
    last = max(int(np.ceil(attack.end * EXPORT_RATE)), first + 1)
    return np.arange(first, last + 1) / EXPORT_RATE


def _free(
    refiner: Refiner, played: Played, start: float, stop: float, times: Float[np.ndarray, " T"]
) -> Float[np.ndarray, "T L"]:
    """How far feet may be moved at some times within a window."""
    around = np.arange(round((start - 0.2) * EXPORT_RATE), round((stop + 0.2) * EXPORT_RATE) + 1)
    grid = around / EXPORT_RATE
    free = free_feet(played.planted(refiner.plants, grid), grid)
    columns = [np.interp(times, grid, free[:, k]) for k in range(free.shape[1])]
    return np.stack(columns, axis=1) if columns else np.zeros((len(times), 0))


def _padded(lanes: list[_Lane]) -> Problem:
    """Problems of one shape, as many as a bucket holds; padding is never near."""
    moments = bucket_size(max(len(lane.times) for lane in lanes), MOMENTS, 2)
    spheres = bucket_size(len(lanes[0].problem.radii), SPHERE_BUCKET, 8)
    rows = [_pad(lane.problem, moments, spheres) for lane in lanes]
    rows += [rows[-1]] * (bucket_size(len(rows), 1, 4) - len(rows))
    return jax.tree.map(
        lambda axis, *values: values[0] if axis is None else np.stack(values),
        PER_LANE,
        *rows,
        is_leaf=lambda x: x is None,
    )


def _pad(problem: Problem, moments: int, spheres: int) -> Problem:
    def longer(values: np.ndarray) -> np.ndarray:
        near, others = values[:-OTHERS], values[-OTHERS:]
        return np.concatenate([pad_axis(np.asarray(near), moments), others])

    absent = pad_axis(np.asarray(problem.absent), moments - 1, value=1)
    attack = pad_axis(np.asarray(problem.attack), moments)
    return replace(
        problem,
        root=longer(problem.root),
        rotations=longer(problem.rotations),
        basis=longer(problem.basis),
        free=longer(problem.free),
        attack=pad_axis(attack, spheres, axis=1),
        radii=pad_axis(np.asarray(problem.radii), spheres),
        absent=pad_axis(absent, spheres, axis=1, value=1),
    )


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
    )


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
        free = _free(refiner, played, start, stop, frames)
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


