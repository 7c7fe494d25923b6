"""A body that stands with hanging arms, and clips in which its arms go about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.core import quaternion
from mgjax.core.body.roles import require_roles
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.graph.types import MotionGraph
from tests.avoidance.refinement.made import still_graph

CONFIG = AvoidanceConfig(T_wide=0.0, refine="off", parry="on")


def guarding_graph() -> MotionGraph:
    """On edge 0 a body stands for 3 s; on edge 1 its arms go through what they are able to."""
    graph = still_graph()
    rotations = graph.local_rotations.copy()
    count = len(rotations)
    times = np.arange(count) / graph.frame_rate
    for side, sign in (("left", 1.0), ("right", -1.0)):
        shoulder, elbow = require_roles(graph.skeleton, (f"{side}_shoulder", f"{side}_elbow"))
        down, ahead, spin, bend = (np.full(count, x) for x in (-75.0, 0.0, 0.0, 15.0))
        moving = times >= times[91]
        since = times[moving] - times[91]
        down[moving] = -20 - 75 * np.cos(2.0 * since)
        ahead[moving] = -55 + 65 * np.cos(2.9 * since)
        spin[moving] = 70 * np.sin(3.7 * since)
        bend[moving] = 70 - 65 * np.cos(3.1 * since)
        turns = quaternion.multiply(about(2, sign * down), about(1, sign * ahead))
        rotations[:, shoulder] = quaternion.multiply(np.asarray(turns), about(0, spin))
        rotations[:, elbow] = about(1, -sign * bend)
    return replace(graph, local_rotations=rotations)


def about(axis: int, degrees: np.ndarray) -> np.ndarray:
    """Rotations about a coordinate axis."""
    return np.asarray(quaternion.from_axis_angle(np.eye(3)[axis][None], np.radians(degrees)))


def one_armed(graph: MotionGraph, sides: tuple[str, ...] = ("right",)) -> MotionGraph:
    """The same body without an arm, or without any."""
    skeleton = graph.skeleton
    first = [require_roles(skeleton, (f"{side}_shoulder",))[0] for side in sides]
    gone = {skeleton.parents[joint] for joint in first}  # from the clavicle on
    for joint, parent in enumerate(skeleton.parents):
        if parent in gone:
            gone.add(joint)
    kept = [joint for joint in range(skeleton.num_joints) if joint not in gone]
    place = {joint: row for row, joint in enumerate(kept)}
    return replace(
        graph,
        skeleton=Skeleton(
            names=tuple(skeleton.names[joint] for joint in kept),
            parents=tuple(place.get(skeleton.parents[joint], -1) for joint in kept),
            offsets=np.asarray(skeleton.offsets)[kept],
            end_joints=tuple(place[joint] for joint in skeleton.end_joints if joint in place),
        ),
        local_rotations=graph.local_rotations[:, kept],
    )


def joints_of(graph: MotionGraph, *roles: str) -> np.ndarray:
    """Where joints are as the body stands, m."""
    places, _ = forward(graph.skeleton, graph.root_translation[:1], graph.local_rotations[:1])
    return np.asarray(places, np.float64)[0, list(require_roles(graph.skeleton, roles))]


def ball_at_chest(graph: MotionGraph, *, side: float = 0.0, **more: float) -> Attack:
    """A ball from ahead at the chest, or beside it, m."""
    (chest,) = joints_of(graph, "chest")
    target = chest + np.array([side, 0.0, 0.0])
    known = {"speed": 10.0, "arrives": 1.2} | more
    return ball_attack(target + np.array([0, 0, 5.0]), target, **known)


def standing(graph: MotionGraph) -> Motion:
    """Two seconds of it."""
    count = 2 * round(EXPORT_RATE)
    return Motion(
        root_translation=np.repeat(graph.root_translation[:1], count, 0),
        local_rotations=np.repeat(graph.local_rotations[:1], count, 0),
        frame_rate=EXPORT_RATE,
    )
