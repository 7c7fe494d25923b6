"""The trials of an attack and a motion: which moments and places are tried, as fixed shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.checks.written import SphereTrajectory, clearance
from mgjax.avoidance.parry.contact import Track, way_of
from mgjax.avoidance.parry.course import EARLY_S, FALL_S, RISE_S, STAY_S, rise_start
from mgjax.avoidance.parry.guard import Arm, Guard
from mgjax.avoidance.parry.meet import ArmPose
from mgjax.avoidance.parry.trials import (
    COARSE_RATE,
    DEEPER_M,
    PLACES,
    SWIVELS_DEG,
    Body,
    Trials,
)
from mgjax.avoidance.rates import CHECK_RATE, CLEAR_M, EXPORT_RATE
from mgjax.core.body.capsules import KEPT_OUT
from mgjax.core.body.joint_limits import JointLimits
from mgjax.core.kinematics import forward
from mgjax.core.motion import Motion, sample

ARMS = 2
"""Trials are padded to both arms."""
MOMENTS = 16
"""At so many moments of its way through an arm's reach an attack is met."""
LONGEST_S = 0.5
"""Of an attack that is within reach for longer only the last part of its way is tried."""
SOONEST_S = 0.1
"""No arm is led anywhere sooner, s from now."""
FRAMES = int(np.ceil((RISE_S + EARLY_S + LONGEST_S + STAY_S + FALL_S) * COARSE_RATE)) + 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """Trials of one sphere of an attack.

    Attributes:
        body, trials: as compiled code reads them.
        real: which trials are; the others fill up. [N]
    """

    body: Body
    trials: Trials
    real: Bool[np.ndarray, " N"]


def touching(
    attack: Attack, trace: SphereTrajectory, radii: Float[np.ndarray, " S"]
) -> tuple[int, float] | None:
    """The sphere of an attack that first touches a body, and when, s; None if none does."""
    found: list[tuple[float, int]] = []
    for sphere in range(len(attack.radii)):
        steps, least = clearance(attack.only([sphere]), trace, radii)
        if least < CLEAR_M:
            found.append((float(trace.times[int(np.argmax(steps < CLEAR_M))]), sphere))
    return (min(found)[1], min(found)[0]) if found else None


def lanes_of(
    guard: Guard, motion: Motion, track: Track, trace: SphereTrajectory, attack: Attack, sphere: int
) -> Asked | None:
    """The trials of a sphere that touches a motion; None where no arm reaches it in time.

    Args:
        guard: of the body.
        motion: as written, from now on.
        track, trace: its joints and spheres at the moments of the check.
        attack: its times from now.
        sphere: its number.
    """
    spans = [_in_reach(guard, arm, track, trace, attack, sphere) for arm in guard.arms]
    known = [span for span in spans if span is not None]
    if not known:
        return None
    moments = np.zeros((ARMS, MOMENTS))
    real = np.zeros((ARMS, MOMENTS), bool)
    for row, span in enumerate(spans):
        first, last = span or known[0]
        moments[row] = np.linspace(first, last, MOMENTS)
        real[row] = span is not None
    moments[len(spans) :] = moments[0]
    begin = float(rise_start(moments).min())
    body = _body(guard, motion, begin + np.arange(FRAMES) / COARSE_RATE)
    trials = _trials(guard, motion, attack, sphere, moments)
    return Asked(
        body=body, trials=trials, real=np.repeat(real.ravel(), len(PLACES) * len(SWIVELS_DEG))
    )


def empty_lanes(guard: Guard) -> tuple[Body, Trials]:
    """Trials of nothing, in the shapes of all others."""
    rest = sum(part in KEPT_OUT for part in guard.capsules.parts)
    count = ARMS * MOMENTS * len(PLACES) * len(SWIVELS_DEG)

    def zeros(*shape: int) -> np.ndarray:
        return np.zeros(shape, np.float32)

    def pose(*shape: int) -> ArmPose:
        places = {name: zeros(*shape, 3) for name in ("shoulder", "elbow", "wrist", "tip")}
        turns = {name: zeros(*shape, 4) for name in ("shoulder_turn", "elbow_turn")}
        return ArmPose(**places, **turns)

    body = Body(
        times=zeros(FRAMES),
        arms=pose(ARMS, FRAMES),
        local=zeros(ARMS, FRAMES, 2, 4),
        limits=_filled_limits(guard),
        begins=zeros(FRAMES, rest, 3),
        axes=zeros(FRAMES, rest, 3),
        reach=zeros(rest),
        radii=zeros(3),
        fastest=np.asarray(0, np.float32),
        deeper=np.asarray(0, np.float32),
    )
    trials = Trials(
        arm=np.zeros(count, np.int32),
        contact=zeros(count),
        pose=pose(count),
        centre=zeros(count, 3),
        way=zeros(count, 3),
        place=zeros(count),
        swivel=zeros(count),
        radius=np.asarray(0, np.float32),
    )
    return body, trials


def _filled_limits(guard: Guard) -> JointLimits:
    """Limits of shoulder and elbow of the arms, those of the first again where there is one."""
    rows = np.resize(np.arange(2 * len(guard.arms)), 2 * ARMS)
    return JointLimits(**{name: np.asarray(v)[rows] for name, v in vars(guard.limits).items()})


def _in_reach(
    guard: Guard,
    arm: Arm,
    track: Track,
    trace: SphereTrajectory,
    attack: Attack,
    sphere: int,
) -> tuple[float, float] | None:
    """From when to when an arm can be led to a sphere before it touches the rest of the body, s."""
    one = attack.only([sphere])
    own = tuple(f"{arm.side}_{joint}-" for joint in ("shoulder", "elbow", "wrist"))
    rest = np.array([not name.startswith(own) for name in guard.spheres.names])
    others = SphereTrajectory(times=trace.times, centres=trace.centres[:, rest])
    steps, _ = clearance(one, others, guard.spheres.radii[rest])
    touched = np.flatnonzero(steps < CLEAR_M)
    last = trace.times[touched[0]] if len(touched) else trace.times[-1]
    last = min(float(last), track.times[-1] - STAY_S - FALL_S)
    joints = track.positions[:, list(arm.joints)]
    length = np.linalg.norm(np.diff(joints, axis=1), axis=-1).sum(axis=1)
    centres, active = one.sampled(track.times)
    gap = np.linalg.norm(centres[:, 0] - joints[:, 0], axis=-1) - one.radii[0]
    near = active[:, 0] & (gap < length) & (track.times >= SOONEST_S) & (track.times <= last)
    within = track.times[near]
    if not len(within):
        return None
    stop = float(within[-1])
    within = within[within >= stop - LONGEST_S]
    return float(within[0]), max(stop - 0.5 / CHECK_RATE, float(within[0]))


def _body(guard: Guard, motion: Motion, times: Float[np.ndarray, " T"]) -> Body:
    """The motion at some moments, as compiled code reads it."""
    poses = sample(motion, np.clip(times * EXPORT_RATE, 0, motion.num_frames - 1))
    places, turns = _forward(guard, poses)
    capsules = guard.capsules
    rest = np.array([part in KEPT_OUT for part in capsules.parts])
    a, b = (x[:, rest] for x in capsules.ends(places))
    return Body(
        times=times.astype(np.float32),
        arms=_stacked([_pose(arm, places, turns) for arm in _filled(guard)]),
        local=np.stack(
            [
                np.asarray(poses.local_rotations, np.float32)[:, [arm.shoulder, arm.elbow]]
                for arm in _filled(guard)
            ]
        ),
        limits=_filled_limits(guard),
        begins=a.astype(np.float32),
        axes=(b - a).astype(np.float32),
        reach=capsules.radii[rest].astype(np.float32),
        radii=_radii(guard),
        fastest=np.asarray(guard.fastest, np.float32),
        deeper=np.asarray(DEEPER_M * guard.scale, np.float32),
    )


def _trials(
    guard: Guard,
    motion: Motion,
    attack: Attack,
    sphere: int,
    moments: Float[np.ndarray, "A M"],
) -> Trials:
    """A trial for each arm, moment, place and swivel, in this order."""
    order = np.argsort(moments.ravel(), kind="stable")
    back = np.argsort(order, kind="stable")
    frames = np.clip(moments.ravel()[order] * EXPORT_RATE, 0, motion.num_frames - 1)
    poses = sample(motion, frames)
    places, turns = _forward(guard, poses)
    each = len(PLACES) * len(SWIVELS_DEG)
    rows = np.repeat(back, each)  # of every trial its pose
    arms = np.repeat(np.arange(ARMS), MOMENTS * each)
    by_arm = _stacked([_pose(arm, places, turns) for arm in _filled(guard)])
    flat = moments.ravel()
    centres = attack.at(flat[order])[back, sphere]
    ways = np.stack([way_of(attack, sphere, float(t)) for t in flat])
    place, swivel = np.meshgrid(PLACES, np.radians(SWIVELS_DEG), indexing="ij")
    count = ARMS * MOMENTS
    return Trials(
        arm=arms.astype(np.int32),
        contact=np.repeat(flat, each).astype(np.float32),
        pose=ArmPose(**{k: v[arms, rows] for k, v in vars(by_arm).items()}),
        centre=np.repeat(centres, each, axis=0).astype(np.float32),
        way=np.repeat(ways, each, axis=0).astype(np.float32),
        place=np.tile(place.ravel(), count).astype(np.float32),
        swivel=np.tile(swivel.ravel(), count).astype(np.float32),
        radius=np.asarray(attack.radii[sphere], np.float32),
    )


def _filled(guard: Guard) -> list[Arm]:
    """The arms, the first again where there is only one."""
    return [guard.arms[k % len(guard.arms)] for k in range(ARMS)]


def _forward(guard: Guard, poses: Motion) -> tuple[np.ndarray, np.ndarray]:
    found = forward(
        guard.skeleton, np.asarray(poses.root_translation), np.asarray(poses.local_rotations)
    )
    return np.asarray(found[0]), np.asarray(found[1])


def _pose(arm: Arm, places: np.ndarray, turns: np.ndarray) -> ArmPose:
    """An arm in some poses."""
    shoulder, elbow, wrist, tip = (places[:, j].astype(np.float32) for j in arm.joints)
    return ArmPose(
        shoulder=shoulder,
        elbow=elbow,
        wrist=wrist,
        tip=tip,
        shoulder_turn=turns[:, arm.shoulder].astype(np.float32),
        elbow_turn=turns[:, arm.elbow].astype(np.float32),
    )


def _stacked(poses: list[ArmPose]) -> ArmPose:
    return ArmPose(**{k: np.stack([vars(pose)[k] for pose in poses]) for k in vars(poses[0])})


def _radii(guard: Guard) -> Float[np.ndarray, "3"]:
    """Of upper arm, forearm and hand, m."""
    parts, radii = guard.capsules.parts, guard.capsules.radii
    known = [
        next((r for p, r in zip(parts, radii, strict=True) if p == part), 0.0)
        for part in ("upper arm", "forearm", "hand")
    ]
    return np.array(known, np.float32)
