"""An attack by the limb of another character."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import (
    MAX_SECONDS,
    Attack,
    validate_attack,
)
from mgjax.avoidance.body.spheres import preset_spheres, sphere_centres
from mgjax.core import planar
from mgjax.core.errors import AttackError
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion, sample, validate_motion
from mgjax.core.skeleton import Skeleton

LIMBS: dict[str, tuple[str, ...]] = {
    f"{side}_{end}": (f"{side}_{inner}-", f"{side}_{outer}-")
    for side in ("left", "right")
    for end, inner, outer in (("hand", "elbow", "wrist"), ("foot", "knee", "ankle"))
}
"""For each limb that may strike, how the names of its body spheres begin, inner part first."""
LIMB_RATE = 240.0
"""Least knots per second of a limb; the frames of its motion are always among them."""


def limb_attack(
    skeleton: Skeleton,
    motion: Motion,
    *,
    limb: str,
    hit_s: float,
    arrives: float,
    place: Float[np.ndarray, "3"] | Sequence[float] | None = None,
    target: Float[np.ndarray, "2"] | Sequence[float] | None = None,
    side: float = 0.0,
    before_s: float = 0.4,
    after_s: float = 0.3,
) -> Attack:
    """The spheres of an attacker's forearm and hand, or shin and foot, around a hit.

    They are those of the body preset, scaled to the attacker's skeleton, inner part first; the last
    one is the limb's end. Where the attacker stands at the hit is given by ``place``, or else so
    chosen that the limb's end is over the floor point ``target`` then; how high it is there is the
    motion's affair.

    Args:
        skeleton: the attacker's.
        motion: a clip, or a walk from :func:`mgjax.avoidance.checks.written.walk_motion`.
        limb: ``left_hand``, ``right_hand``, ``left_foot`` or ``right_foot``.
        hit_s: moment of the hit in the motion, s.
        arrives: when the hit happens, s from now, more than 0.
        place: planar frame (θ, x, z) of the attacker's body at the hit, in the defender's:
            (π, 0, 1) faces a defender who stands at the origin from 1 m in front.
        target: (x, z) in the defender's frame, m.
        side: with ``target``: where the attacker's root is as seen from there, rad; 0 is +Z (the
            defender's front), π/2 is +X (the defender's left).
        before_s, after_s: what part of the motion before and after the hit counts, s; shorter
            where the motion begins or ends, and nothing before now.

    Raises:
        AttackError: no such limb, a number out of range, or not one of ``place`` and ``target``.
        SkeletonError: the attacker lacks a joint.
        MotionError: the motion does not fit the skeleton.
    """
    if limb not in LIMBS:
        raise AttackError(f"got limb {limb!r:.60}, expected one of {', '.join(LIMBS)}")
    validate_motion(skeleton, motion)
    rate = float(motion.frame_rate)
    last = (motion.num_frames - 1) / rate
    for name, value, high in (
        ("hit_s", hit_s, last),
        ("before_s", before_s, MAX_SECONDS),
        ("after_s", after_s, MAX_SECONDS),
    ):
        if not 0 <= value <= high + 1e-9:
            raise AttackError(f"got {name} = {value:g}, expected 0 … {high:g} s")
    if not 0 < arrives <= MAX_SECONDS:
        raise AttackError(f"got arrival {arrives:g}, expected more than 0 and at most 60")
    hit = min(hit_s, last)
    begin = max(hit - min(before_s, arrives), 0.0)
    end = min(hit + min(after_s, MAX_SECONDS - arrives), last)
    times = _knots(begin, hit, end, rate)
    wanted = np.flatnonzero(
        [name.startswith(LIMBS[limb]) for name in preset_spheres(skeleton).names]
    )
    # The middle of each interval says how far the limb is off the straight line there.
    moments = np.sort(np.concatenate([times, 0.5 * (times[1:] + times[:-1])]))
    centres, frames = _limb_centres(skeleton, motion, moments * rate, wanted)
    at_hit = 2 * int(np.searchsorted(times, hit))
    inverse = np.asarray(planar.inverse(frames[at_hit]))
    local_end = np.asarray(planar.apply(inverse, centres[at_hit, -1]))
    stands = _stands(local_end, place, target, side)
    move = np.asarray(planar.compose(stands, inverse))
    centres = np.asarray(planar.apply(move, centres))
    bend = np.zeros(1)
    if len(times) > 1:
        middle = 0.5 * (centres[:-2:2] + centres[2::2])
        off = np.linalg.norm(centres[1::2] - middle, axis=-1).max(axis=1)
        bend = 8 * off / np.diff(times) ** 2
        # A sliver of an interval would turn rounding into an acceleration.
        bend = np.where(off < 1e-7, 0.0, bend)
    attack = Attack(
        times=times - hit + arrives,
        centres=centres[::2],
        radii=preset_spheres(skeleton).radii[wanted].astype(np.float64),
        acceleration=float(bend.max()),
    )
    validate_attack(attack)
    return attack


def _knots(begin: float, hit: float, end: float, rate: float) -> np.ndarray:
    """Begin, hit and end, the frames between, and evenly spaced times between those."""
    parts = max(1, math.ceil(LIMB_RATE / rate - 1e-9))
    step = 1 / (rate * parts)
    inner = np.arange(math.ceil(begin / step), math.floor(end / step) + 1) * step
    fixed = np.unique([begin, hit, end])
    separate = np.abs(inner[:, None] - fixed).min(axis=1) > 1e-6
    inner = inner[separate & (inner > begin) & (inner < end)]
    return np.sort(np.concatenate([fixed, inner]))


def _limb_centres(
    skeleton: Skeleton, motion: Motion, frames: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the wanted spheres at fractional frames, and the planar frames of the body."""
    exact = replace(
        motion,
        root_translation=np.asarray(motion.root_translation, dtype=np.float64),
        local_rotations=np.asarray(motion.local_rotations, dtype=np.float64),
        joint_offsets=None
        if motion.joint_offsets is None
        else np.asarray(motion.joint_offsets, dtype=np.float64),
    )
    poses = sample(exact, frames)
    solid = replace(skeleton, offsets=np.asarray(skeleton.offsets, dtype=np.float64))
    positions, _ = forward(
        solid, poses.root_translation, poses.local_rotations, poses.joint_offsets
    )
    spheres = preset_spheres(skeleton)
    centres = np.asarray(sphere_centres(spheres, positions))[:, wanted]
    return centres, np.asarray(planar_frames(skeleton, positions))


def _stands(
    limb_end: np.ndarray,
    place: np.ndarray | Sequence[float] | None,
    target: np.ndarray | Sequence[float] | None,
    side: float,
) -> np.ndarray:
    """Planar frame of the attacker at the hit; ``limb_end`` is in the attacker's own."""
    if (place is None) == (target is None):
        raise AttackError("got both or none of place and target, expected one of them")
    chosen, count, name = (place, 3, "place") if target is None else (target, 2, "target")
    values = np.asarray(chosen, dtype=np.float64)
    if values.shape != (count,) or not (np.abs(values) <= 1000).all():
        raise AttackError(
            f"got {name} {values.tolist()!s:.60}, expected {count} numbers within 1000"
        )
    if not abs(side) <= 1000:
        raise AttackError(f"got side {side:g}, expected an angle in rad")
    if target is None:
        return values
    x, _, z = limb_end
    # A limb that ends over the root comes from nowhere in particular: then the attacker faces it.
    toward_root = math.atan2(-x, -z) if math.hypot(x, z) > 0.01 else math.pi
    turned = np.array([side - toward_root, 0.0, 0.0])
    reach = np.asarray(planar.apply(turned, limb_end))
    return np.array([turned[0], values[0] - reach[0], values[1] - reach[2]])
