"""Parrying: one arm is led to meet an attack that nothing avoids."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.parry.checked import Met, keeps_limits, met, track_of
from mgjax.avoidance.parry.course import FALL_S, STAY_S, course, turn_arm
from mgjax.avoidance.parry.guard import guard_of
from mgjax.avoidance.parry.lanes import Asked, empty_lanes, lanes_of, touching
from mgjax.avoidance.parry.trials import try_jitted
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.refinement import JointChange
from mgjax.core import quaternion
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph

CHECKS = 32
"""Trials that are checked exactly, at most."""
AFTER_S = STAY_S + FALL_S + 2 / EXPORT_RATE
"""How long a motion goes on after the latest contact that is tried, at least."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Parry(JointChange):
    """How an arm meets an attack.

    Its ``values`` are rotation vectors by which shoulder and elbow turn in their own frames, rad:
    zero with their first two derivatives at both ends. [W, 6] Its ``clearance_m`` is that to all
    but the forearm and hand that meet the attack; the sphere that they meet ends at the contact.

    Attributes:
        limb: what meets it, such as ``"left_forearm"``.
        sphere: number of the sphere of the attack that it meets.
        time: of the contact, s from now.
        place: of the contact, in the frame of the attack, m. [3]
        square: cosine between the way of the attack and the direction in which it presses: 1 head
            on.
    """

    limb: str
    sphere: int
    time: float
    place: Float[np.ndarray, "3"]
    square: float

    @property
    def side(self) -> str:
        """Of the arm."""
        return self.limb.split("_")[0]

    def left_of(self, attack: Attack) -> Attack:
        """What is left of the attack: the sphere that is met ends at the contact."""
        return attack.ended(self.sphere, self.time)


def find_parry(
    graph: MotionGraph,
    motion: Motion,
    attack: Attack,
    config: AvoidanceConfig,
    clearance_m: float,
) -> tuple[Parry, Motion] | None:
    """The least offset of an arm that meets an attack, and the motion with it; None where none is.

    Both arms are tried at moments of the attack's way through their reach, before it touches the
    rest of the body, with several places of forearm and hand and several ways for the elbow to
    lie. Those that turn shoulder and elbow least come first, and the first that passes the exact
    check of the written motion is taken.

    The limits ``refine_max_m`` and ``refine_max_deg`` are for a body that gets out of the way:
    10 cm do not bring a hanging arm to any ball. They hold here for all but that arm, which does
    not move at all. Of the arm, shoulder and elbow turn as far as the graph's clips show them to,
    its hand is no faster than these show, and it keeps out of the body.

    Args:
        graph: of the motion's body.
        motion: as it is written, from now on; frames ``AFTER_S`` after a contact belong to it.
        attack: its times from now, in the frame of the motion.
        config: settings of this graph's body (:func:`~mgjax.avoidance.config.for_body`).
        clearance_m: of both, for the record.
    """
    guard = guard_of(graph)
    if not guard.arms:
        return None
    track, trace = track_of(guard, motion)
    first = touching(attack, trace, guard.spheres.radii)
    if first is None or attack.radii[first[0]] > config.parry_radius_m:
        return None
    sphere = first[0]
    asked = lanes_of(guard, motion, track, trace, attack, sphere)
    if asked is None:
        return None
    times = np.arange(motion.num_frames) / EXPORT_RATE
    for number, contact, turns in _in_order(asked):
        arm = guard.arms[number]
        start, values = course(contact, turns)
        after = turn_arm(motion, arm, times, values, start)
        new, spheres = track_of(guard, after)
        found = met(guard, arm, new, spheres, attack, sphere)
        if found is not None and keeps_limits(guard, arm, motion, after, track, new):
            parry = _parry(graph, motion, after, found, sphere, start, values, clearance_m)
            return parry, after
    return None


def compile_parrying(graph: MotionGraph) -> None:
    """Tries nothing, so that no later call compiles."""
    guard = guard_of(graph)
    if guard.arms:
        try_jitted(*empty_lanes(guard))


def _in_order(asked: Asked) -> list[tuple[int, float, Float[np.ndarray, "2 3"]]]:
    """Arm, moment and turns of the good trials, those of least effort first."""
    tried = jax.tree.map(np.asarray, try_jitted(asked.body, asked.trials))
    good = np.flatnonzero(tried.good & asked.real & np.isfinite(tried.effort))
    best = good[np.argsort(tried.effort[good], kind="stable")][:CHECKS]
    arms, contacts = np.asarray(asked.trials.arm), np.asarray(asked.trials.contact)
    return [(int(arms[k]), float(contacts[k]), tried.turns[k]) for k in best.tolist()]


def _parry(
    graph: MotionGraph,
    before: Motion,
    after: Motion,
    found: Met,
    sphere: int,
    start: float,
    values: Float[np.ndarray, "W 6"],
    clearance_m: float,
) -> Parry:
    old, new = (
        np.asarray(forward(graph.skeleton, m.root_translation, m.local_rotations)[0])
        for m in (before, after)
    )
    moved = np.linalg.norm(new - old, axis=-1).max(axis=0)
    turned = quaternion.angle_between(before.local_rotations, after.local_rotations)
    degrees = np.degrees(np.asarray(turned).max(axis=0))
    some = np.flatnonzero((moved > 1e-5) | (degrees > 0.1))
    return Parry(
        limb=found.limb,
        sphere=sphere,
        time=found.contact.time,
        place=found.contact.place,
        square=found.contact.square,
        start=start,
        values=values,
        joints=tuple(graph.skeleton.names[j] for j in some),
        moved_m=tuple(moved[some].tolist()),
        turned_deg=tuple(degrees[some].tolist()),
        clearance_before_m=clearance_m,
        clearance_m=found.clearance,
    )
