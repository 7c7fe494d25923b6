"""What of a body can parry: its arms, how far and how fast they go, and what may be touched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from mgjax.avoidance.body.spheres import BodySpheres, preset_spheres
from mgjax.avoidance.refinement.rig import captured_limits
from mgjax.core.body.capsules import Capsules, make_capsules
from mgjax.core.body.joint_limits import JointLimits
from mgjax.core.body.roles import SIDES, find_role
from mgjax.core.skeleton import Skeleton
from mgjax.graph.cache import cached
from mgjax.graph.types import MotionGraph

PARTS = ("forearm", "hand")
"""Parts of an arm that may meet an attack."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Arm:
    """One arm.

    Attributes:
        side: ``"left"`` or ``"right"``.
        shoulder, elbow, wrist: joints.
        tip: where the fingers begin, or the next joint after the wrist; the wrist without one.
    """

    side: str
    shoulder: int
    elbow: int
    wrist: int
    tip: int

    @property
    def joints(self) -> tuple[int, int, int, int]:
        """Shoulder, elbow, wrist and tip."""
        return self.shoulder, self.elbow, self.wrist, self.tip


@dataclass(frozen=True, kw_only=True, eq=False)
class Guard:
    """What parrying with the body of a graph takes.

    Attributes:
        skeleton: the body.
        arms: those that it has.
        capsules: its surface; an attack is met by those of a forearm or a hand.
        spheres: as attacks are checked against everywhere in this room.
        limits: of shoulder and elbow of each arm in turn, as the captured clips show them.
        fastest: largest speed of a hand in these clips, m/s.
        scale: of the body.
    """

    skeleton: Skeleton
    arms: tuple[Arm, ...]
    capsules: Capsules
    spheres: BodySpheres
    limits: JointLimits
    fastest: float
    scale: float

    def arm(self, side: str) -> Arm:
        """The arm of a side."""
        return next(arm for arm in self.arms if arm.side == side)

    def limb(self, arm: Arm, part: str) -> Bool[np.ndarray, " B"]:
        """The capsules of a part of an arm."""
        pairs = zip(self.capsules.parts, self.capsules.arms, strict=True)
        return np.array([pair == (part, arm.side) for pair in pairs], bool)

    def rest(self, arm: Arm) -> Bool[np.ndarray, " S"]:
        """The spheres that are not those of an arm's forearm and hand."""
        own = tuple(f"{arm.side}_{joint}-" for joint in ("elbow", "wrist"))
        return np.array([not name.startswith(own) for name in self.spheres.names], bool)

    @property
    def note(self) -> str | None:
        """A sentence on what is not there to parry with; None where both arms are."""
        missing = [side for side in SIDES if side not in {arm.side for arm in self.arms}]
        if not missing:
            return None
        return f"the body has no {' and no '.join(missing)} arm to parry with"


def guard_of(graph: MotionGraph) -> Guard:
    """The guard of a graph, made once."""
    return cached(graph, ("avoidance", "guard"), lambda: _make(graph))


def _make(graph: MotionGraph) -> Guard:
    skeleton = graph.skeleton
    arms = find_arms(skeleton)
    turning = [joint for arm in arms for joint in (arm.shoulder, arm.elbow)]
    # Without an arm nothing asks for limits.
    limits = captured_limits(graph, turning or [0])
    return Guard(
        skeleton=skeleton,
        arms=arms,
        capsules=make_capsules(skeleton),
        spheres=preset_spheres(skeleton),
        limits=limits,
        fastest=captured_speed(graph, arms),
        scale=graph.body_scale,
    )


def find_arms(skeleton: Skeleton) -> tuple[Arm, ...]:
    """The arms of a body that have a shoulder, an elbow and a wrist."""
    arms: list[Arm] = []
    for side in SIDES:
        found = [find_role(skeleton, f"{side}_{part}") for part in ("shoulder", "elbow", "wrist")]
        joints = [joint for joint in found if joint is not None]
        if len(joints) == 3:
            shoulder, elbow, wrist = joints
            hand = find_role(skeleton, f"{side}_hand")
            below = [j for j, parent in enumerate(skeleton.parents) if parent == wrist]
            tip = hand if hand is not None else next(iter(below), wrist)
            arms.append(Arm(side=side, shoulder=shoulder, elbow=elbow, wrist=wrist, tip=tip))
    return tuple(arms)


def captured_speed(graph: MotionGraph, arms: tuple[Arm, ...]) -> float:
    """Largest speed of any hand over the captured clips of a graph, m/s; 0 without a hand."""
    tips = [arm.tip for arm in arms]
    largest = 0.0
    for start, stop in zip(graph.clip_starts, graph.clip_stops, strict=True):
        steps = np.diff(graph.positions[start:stop, tips], axis=0)
        speeds = np.linalg.norm(steps, axis=-1) * graph.frame_rate
        largest = max(largest, float(speeds.max(initial=0.0)))
    return largest
