"""The exact check of a parry, on the motion as it is written."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.checks.written import SphereTrajectory, clearance
from mgjax.avoidance.parry.contact import Contact, Track, first_contact, least_gap
from mgjax.avoidance.parry.guard import PARTS, Arm, Guard
from mgjax.avoidance.parry.trials import ALONG, APART_M, DEEPER_M, LIMIT_RAD, SQUARE
from mgjax.avoidance.rates import CHECK_RATE, CLEAR_M, EXPORT_RATE
from mgjax.avoidance.refinement.rig import outside
from mgjax.core.body.capsules import arm_clearance
from mgjax.core.body.joint_limits import JointLimits
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion, sample


@dataclass(frozen=True, kw_only=True, eq=False)
class Met:
    """What a motion does to an attack that it meets.

    Attributes:
        limb: ``left_forearm``, ``left_hand``, ``right_forearm`` or ``right_hand``.
        contact: where and when.
        clearance: of what is left of the attack to the rest of the body, m.
    """

    limb: str
    contact: Contact
    clearance: float


def track_of(guard: Guard, motion: Motion) -> tuple[Track, SphereTrajectory]:
    """Joints and spheres of a written motion at the moments of the check."""
    factor = CHECK_RATE / motion.frame_rate
    index = np.arange(round((motion.num_frames - 1) * factor) + 1)
    fine = sample(motion, index / factor)
    places = np.asarray(
        forward(guard.skeleton, fine.root_translation, fine.local_rotations)[0], np.float64
    )
    times = index / CHECK_RATE
    spheres = guard.spheres
    share = spheres.share[:, None].astype(np.float64)
    centres = places[:, spheres.first] * (1 - share) + places[:, spheres.second] * share
    return Track(times=times, positions=places), SphereTrajectory(times=times, centres=centres)


def met(
    guard: Guard,
    arm: Arm,
    track: Track,
    trace: SphereTrajectory,
    attack: Attack,
    sphere: int,
) -> Met | None:
    """Whether a forearm or hand is the first and the only thing that a sphere touches.

    It is taken to be turned away there: it ends at the contact, and the other spheres of the attack
    go on. Until then every other capsule of the body is ``APART_M`` away, and every sphere of the
    room's body is clear but those of this forearm and hand. It presses on the limb squarely, and
    the limb lies across its way: what is only grazed would go on. Every other sphere of the attack
    is clear of the body.

    Args:
        guard: of the body.
        arm: the arm.
        track, trace: of the motion.
        attack: its times as those of the track.
        sphere: the one that is met.
    """
    contact = first_contact(guard.capsules, track, attack, sphere)
    if contact is None or contact.square < SQUARE or contact.along > ALONG:
        return None
    limbs = {part: guard.limb(arm, part) for part in PARTS}
    part = next((name for name, own in limbs.items() if own[contact.capsule]), None)
    if part is None:
        return None
    if least_gap(guard.capsules, track, attack, sphere, ~limbs[part], contact.time) < APART_M:
        return None
    ended = attack.only([sphere]).ended(0, contact.time)
    rest = guard.rest(arm)
    body = SphereTrajectory(times=trace.times, centres=trace.centres[:, rest])
    gap = clearance(ended, body, guard.spheres.radii[rest])[1]
    others = [k for k in range(len(attack.radii)) if k != sphere]
    if others:
        gap = min(gap, clearance(attack.only(others), trace, guard.spheres.radii)[1])
    if gap < CLEAR_M:
        return None
    return Met(limb=f"{arm.side}_{part}", contact=contact, clearance=gap)


def keeps_limits(
    guard: Guard, arm: Arm, before: Motion, after: Motion, old: Track, new: Track
) -> bool:
    """Whether an arm keeps what its body is captured with: joint limits, speed, and solidity.

    Joints go no farther out of their captured range than they were; the hand is no faster than any
    captured one, or than it was; forearm and hand are no deeper in trunk, neck and head than they
    were, and 1 cm of an adult.
    """
    number = guard.arms.index(arm)
    own = JointLimits(
        **{k: np.asarray(v)[2 * number : 2 * number + 2] for k, v in vars(guard.limits).items()}
    )
    joints = [arm.shoulder, arm.elbow]
    beyond, was = (outside(np.asarray(m.local_rotations)[:, joints], own) for m in (after, before))
    if (beyond - was).max() > LIMIT_RAD:
        return False
    fast, speed = (_speed(guard, arm, track) for track in (old, new))
    if speed > max(fast, guard.fastest):
        return False
    was_deep, deep = (
        arm_clearance(guard.capsules, track.positions, arm.side) for track in (old, new)
    )
    deeper: Float[np.ndarray, " T"] = np.minimum(was_deep, 0.0) - deep
    return bool(deeper.max() <= DEEPER_M * guard.scale)


def _speed(guard: Guard, arm: Arm, track: Track) -> float:
    """Largest speed of a hand from written frame to written frame, m/s."""
    frames = track.positions[:: round(CHECK_RATE / EXPORT_RATE), arm.tip]
    return float(np.linalg.norm(np.diff(frames, axis=0), axis=-1).max(initial=0.0) * EXPORT_RATE)
