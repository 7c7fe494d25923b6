"""From a walk and an attack to a problem of one of few shapes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.batch import SPHERE_BUCKET
from mgjax.avoidance.body.spheres import sphere_centres
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared
from mgjax.avoidance.rates import EXPORT_RATE, FAR
from mgjax.avoidance.refinement.costs import Problem
from mgjax.avoidance.refinement.inside import AIMED, DEPTH_M
from mgjax.avoidance.refinement.played import Played, Refiner, free_at, written_frames
from mgjax.avoidance.refinement.rig import Rig, unit_of
from mgjax.avoidance.refinement.slopes import base_of
from mgjax.avoidance.refinement.splines import basis, size_matrix
from mgjax.core.arrays import Array
from mgjax.core.kinematics import forward
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.types import MotionGraph

MARGIN_M = 0.008
"""Clearance that is aimed at, of an adult."""
LEAD_S = 0.5
"""How long before the first contact the change begins, and after the last one ends."""
SHORTEST_S = 0.3
"""The same where the written motion would end earlier."""
MOMENTS = 32
"""Written frames near the attack that a call is compiled for, and three times as many"""
OTHERS = 16
"""Moments of the whole window at which bounds are looked at."""
MOST_MOMENTS = 96
"""Of longer contacts fewer frames a second are looked at while changing; all in the check."""
UNIT_M = 0.05
UNIT_RAD = float(np.radians(10.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Lane:
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


def last_moment(attack: Attack, config: AvoidanceConfig) -> float:
    """Until when a motion that may be changed because of an attack is needed, s."""
    return attack.end + max(config.settle_s, SHORTEST_S) + 2 / EXPORT_RATE


def lane_of(
    prepared: Prepared, refiner: Refiner, played: Played, attack: Attack, config: AvoidanceConfig
) -> Lane | None:
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
    gone = float(times[touched[-1]])
    stop = min(gone + LEAD_S, max(attack.end + config.settle_s, gone + SHORTEST_S))
    stop = np.ceil(stop * EXPORT_RATE) / EXPORT_RATE
    others = np.round(np.linspace(start, stop, OTHERS + 2)[1:-1] * EXPORT_RATE) / EXPORT_RATE
    rest = played.motion(others)
    moments = np.concatenate([times[rows], others])
    return Lane(
        played=played,
        times=times[rows],
        start=float(start),
        stop=float(stop),
        problem=Problem(
            base=base_of(
                refiner.rig,
                np.concatenate([root[rows], rest.root_translation]),
                np.concatenate([rotations[rows], rest.local_rotations]),
                free_at(refiner, played, start, stop, moments),
            ),
            basis=basis(moments, start, stop).astype(np.float32),
            attack=centres[rows].astype(np.float32),
            radii=attack.radii.astype(np.float32),
            absent=(~attack.lives(times[rows])).astype(np.float32),
            **_settings(refiner.rig, scale, config.refine_max_m, config.refine_max_deg),
        ),
    )


def padded(lane: Lane) -> Problem:
    """The problem in a shape that a call is compiled for; padding is never near."""
    moments = bucket_size(len(lane.times), MOMENTS, 3)
    return _pad(lane.problem, moments, bucket_size(len(lane.problem.radii), SPHERE_BUCKET, 8))


def empty_problem(graph: MotionGraph, rig: Rig, moments: int, spheres: int) -> Problem:
    """A problem of a compiled shape in which nothing is ever near."""
    count = moments + OTHERS
    rows = np.zeros(count, np.int64)
    free = np.zeros((count, len(rig.legs)))
    base = base_of(rig, graph.root_translation[rows], graph.local_rotations[rows], free)
    times = np.linspace(0, 1, count)
    return Problem(
        base=base,
        basis=basis(times, 0.0, 1.0).astype(np.float32),
        attack=np.full((moments, spheres, 3), 100.0, np.float32),
        radii=np.ones(spheres, np.float32),
        absent=np.ones((moments - 1, spheres), np.float32),
        **_settings(rig, 1.0, 0.1, 20.0),
    )


def _settings(rig: Rig, scale: float, max_m: float, max_deg: float) -> dict[str, np.ndarray]:
    """What all problems of a graph have in common, for a body of a scale."""
    return {
        "size": size_matrix().astype(np.float32),
        "unit": unit_of(rig, UNIT_M * scale, UNIT_RAD).astype(np.float32),
        "margin": np.asarray(MARGIN_M * scale, np.float32),
        "max_m": np.asarray(max_m, np.float32),
        "max_rad": np.asarray(np.radians(max_deg), np.float32),
        "deep": np.asarray(AIMED * DEPTH_M * scale, np.float32),
    }


def _pad(problem: Problem, moments: int, spheres: int) -> Problem:
    def longer(values: Array) -> np.ndarray:
        array = np.asarray(values)
        return np.concatenate([pad_axis(array[:-OTHERS], moments), array[-OTHERS:]])

    absent = pad_axis(np.asarray(problem.absent), moments - 1, value=1)
    attack = pad_axis(np.asarray(problem.attack), moments)
    return replace(
        problem,
        base=jax.tree.map(longer, problem.base),
        basis=longer(problem.basis),
        attack=pad_axis(attack, spheres, axis=1),
        radii=pad_axis(np.asarray(problem.radii), spheres),
        absent=pad_axis(absent, spheres, axis=1, value=1),
    )
