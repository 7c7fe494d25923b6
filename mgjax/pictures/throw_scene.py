"""What the pictures of one throw share: the body, the balls, and when they are nearest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.checks.written import SphereTrajectory, clearance
from mgjax.avoidance.choice.selection import Selection
from mgjax.avoidance.timing.walk_warps import part_moments
from mgjax.core.kinematics import global_positions
from mgjax.graph.types import MotionGraph


@dataclass(frozen=True, kw_only=True, eq=False)
class Throw:
    """One attack and the answer to it."""

    attack: Attack
    selection: Selection


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """What the panels share, in the planar frame of the start pose."""

    throw: Throw
    positions: np.ndarray  # [F, J, 3]
    rate: float
    scale: float  # of the body
    bones: np.ndarray  # [B, 2]
    gaps: np.ndarray  # clearance per interval of the trace
    radii: np.ndarray
    t_begin: float | None
    t_end: float | None
    t_pass: float
    ball: int  # the sphere of the attack that is nearest to the body at t_pass
    side: np.ndarray  # unit vector along its flight, on the floor
    kind: str


def throw_scene(graph: MotionGraph, throw: Throw) -> Scene:
    """Reads a throw for its pictures."""
    chosen, attack = throw.selection, throw.attack
    skeleton = graph.skeleton
    spheres = preset_spheres(skeleton)
    gaps, _ = clearance(attack, chosen.trace, spheres.radii)
    t_pass = float(chosen.trace.times[int(np.argmin(gaps))])
    ball = _nearest_ball(attack, chosen.trace, spheres.radii, t_pass)
    track = track_of(attack, ball)
    flight = track[-1] - track[0]
    flat = np.array([flight[0], 0.0, flight[2]])
    side = flat / np.linalg.norm(flat) if np.linalg.norm(flat) > 1e-6 else np.array([0, 0, 1.0])
    begin = end = None
    kind = ""
    if chosen.part is not None:
        moments = part_moments(graph, chosen.walk, chosen.path_length, chosen.part)
        begin, _, end = chosen.timing.when(moments).tolist()
        kind = f"{graph.label_kind[chosen.part]} {graph.label_direction[chosen.part]}".strip()
    bones = [(p, j) for j, p in enumerate(skeleton.parents) if p >= 0]
    return Scene(
        throw=throw,
        positions=np.asarray(global_positions(skeleton, chosen.motion)),
        rate=chosen.motion.frame_rate,
        scale=graph.body_scale,
        bones=np.array(bones),
        gaps=gaps,
        radii=spheres.radii,
        t_begin=begin,
        t_end=end,
        t_pass=t_pass,
        ball=ball,
        side=side,
        kind=kind,
    )


def _nearest_ball(attack: Attack, trace: SphereTrajectory, radii: np.ndarray, time: float) -> int:
    """The sphere of an attack that is nearest to the body; of those that are there, if any is."""
    body = trace.centres[int(np.searchsorted(trace.times, time))]
    now = np.array([time])
    gaps = np.linalg.norm(attack.at(now)[0][:, None] - body, axis=-1) - radii
    gaps = gaps.min(axis=1) - attack.radii
    active = attack.active(now)[0]
    return int(np.argmin(np.where(active, gaps, np.inf) if active.any() else gaps))


def track_of(attack: Attack, ball: int) -> np.ndarray:
    """Where a sphere is at the knots at which it is there, m. [K, 3]"""
    return attack.centres[attack.active(attack.times)[:, ball], ball]


def pose_at(scene: Scene, time: float) -> np.ndarray:
    """Joints of the written frame nearest to a time, m. [J, 3]"""
    index = round(time * scene.rate)
    return scene.positions[min(max(index, 0), len(scene.positions) - 1)]


def passing_ball(scene: Scene) -> np.ndarray:
    """Where the ball is that is nearest to the body when it passes, m. [3]"""
    return scene.throw.attack.at(np.array([scene.t_pass]))[0, scene.ball]


def balls_at(scene: Scene, time: float) -> list[tuple[np.ndarray, float]]:
    """Places and radii of the spheres of the attack that are there."""
    attack, now = scene.throw.attack, np.array([time])
    active = attack.active(now)[0]
    return list(zip(attack.at(now)[0, active], attack.radii[active].tolist(), strict=True))
