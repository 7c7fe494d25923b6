"""The exact check: forward kinematics of the motion as it is written, swept against the attack."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import BodySpheres, sphere_centres
from mgjax.avoidance.rates import CHECK_RATE, EXPORT_RATE, FAR
from mgjax.avoidance.timing.walk_warps import natural_starts
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion, sample
from mgjax.core.timing.time_warp import TimeWarp
from mgjax.graph.feet.course import FeetState
from mgjax.graph.feet.played import play_walk
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, extend


@dataclass(frozen=True, kw_only=True, eq=False)
class SphereTrajectory:
    """Body spheres over time, from the forward kinematics of a walk."""

    times: Float[np.ndarray, " T"]
    centres: Float[np.ndarray, "T S 3"]


@dataclass(frozen=True, kw_only=True, eq=False)
class WrittenWalk:
    """A walk as it is written.

    Attributes:
        walk: with the edges that its motion needs.
        motion: from now on.
        trace: the body's spheres over that motion.
        clearance: signed distance of attack and body over it, m; None without an attack.
    """

    walk: Walk
    motion: Motion
    trace: SphereTrajectory
    clearance: float | None


def write_walk(
    graph: MotionGraph,
    spheres: BodySpheres,
    walk: Walk,
    seconds: float,
    warp: TimeWarp | None,
    attack: Attack | None,
    begin: FeetState | None = None,
    change: Callable[[Motion], Motion] | None = None,
) -> WrittenWalk:
    """Makes the motion of a walk and checks that very motion.

    Args:
        graph, spheres: the graph and the body.
        walk: first out-edges follow it where the ``warp`` comes to its end earlier.
        seconds: from now until it is over.
        warp: which moment of the walk as captured is shown when; None: as its scales say.
        attack: what it has to be clear of, if anything.
        begin: what the feet are off now, from what was played before; default: nothing.
        change: what is done to the motion before it is checked and written, if anything.
    """
    if warp is not None:
        beyond = float(warp.at(np.array([seconds]))[0] - natural_starts(graph, walk)[-1])
        walk = extend(graph, walk, float(walk.starts(graph)[-1]) + beyond)
    motion = walk_motion(graph, walk, seconds, warp, begin)
    if change is not None:
        motion = change(motion)
    trace = sphere_trajectory(graph, spheres, motion)
    exact = None if attack is None else clearance(attack, trace, spheres.radii)[1]
    return WrittenWalk(walk=walk, motion=motion, trace=trace, clearance=exact)


def walk_motion(
    graph: MotionGraph,
    walk: Walk,
    seconds: float,
    warp: TimeWarp | None = None,
    begin: FeetState | None = None,
) -> Motion:
    """The motion of a walk from now on, at the rate at which it is written, with its feet kept.

    With a ``warp`` that says which moment of the walk as captured is shown when; else as the scales
    of the walk say. ``begin`` is what the feet are off now, from what was played before; without it
    the first frame is as captured.
    """
    count = int(np.ceil(seconds * EXPORT_RATE - 1e-6)) + 1
    times = np.arange(max(count, 2)) / EXPORT_RATE
    if warp is None:
        return play_walk(graph, walk, times, begin=begin)
    captured = Walk(edges=walk.edges, scales=np.ones(len(walk.edges)))
    return play_walk(graph, captured, np.asarray(warp.at(times)), rate=EXPORT_RATE, begin=begin)


def sphere_trajectory(
    graph: MotionGraph,
    spheres: BodySpheres,
    motion: Motion,
    *,
    start: float = 0.0,
    stop: float = float("inf"),
) -> SphereTrajectory:
    """Sphere centres of a motion, at the moments of the check that cover ``start … stop`` (s)."""
    factor = CHECK_RATE / motion.frame_rate
    last = round((motion.num_frames - 1) * factor)
    first = min(max(int(np.floor(start * CHECK_RATE)), 0), last)
    last = int(min(np.ceil(stop * CHECK_RATE), last))
    index = np.arange(first, last + 1)
    fine = sample(motion, index / factor)
    positions, _ = forward(graph.skeleton, fine.root_translation, fine.local_rotations)
    return SphereTrajectory(
        times=index / CHECK_RATE, centres=np.asarray(sphere_centres(spheres, positions))
    )


def clearance(
    attack: Attack, trace: SphereTrajectory, radii: Float[np.ndarray, " S"]
) -> tuple[Float[np.ndarray, " T1"], float]:
    """Least distance of attack and body over each interval of the trace, and over all of it, m.

    Between two moments of the trace, or knots of the attack, both centres move linearly and the
    smallest distance has a closed form; what the attack bends between its knots is taken off.
    Intervals outside the attack's life are far.
    """
    times = trace.times
    result = np.full(len(times) - 1, FAR)
    first, last = max(attack.start, times[0]), min(attack.end, times[-1])
    if first > last or len(times) < 2:
        return result, FAR
    moments = np.unique(np.concatenate([[first, last], times, attack.times]))
    moments = moments[(moments >= first) & (moments <= last)]
    if len(moments) < 2:  # the two only touch in time
        moments = np.array([first, last])
    index = np.clip(np.searchsorted(times, moments, side="right") - 1, 0, len(times) - 2)
    share = (moments - times[index]) / (times[index + 1] - times[index])
    body = trace.centres[index] * (1 - share)[:, None, None]
    body = body + trace.centres[index + 1] * share[:, None, None]
    # The beginning and the end of a sphere's life are knots.
    centres, active = attack.sampled(moments)
    gaps = centres[:, :, None] - body[:, None]  # [T, I, S, 3]
    begin, end = gaps[:-1], gaps[1:]
    move = end - begin
    along = np.sum(move * move, axis=-1)
    share = np.clip(-np.sum(begin * move, axis=-1) / np.maximum(along, 1e-20), 0.0, 1.0)
    near = np.linalg.norm(begin + share[..., None] * move, axis=-1)
    gap = near - attack.radii[:, None] - radii[None, :]
    gap = np.where((active[:-1] & active[1:])[:, :, None], gap, FAR)
    sag = attack.acceleration * np.diff(attack.times).max(initial=0.0) ** 2 / 8
    np.minimum.at(result, index[:-1], gap.min(axis=(1, 2)) - sag)
    return result, float(result.min())
