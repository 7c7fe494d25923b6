"""Whether a limb gets to its target at a place on a walk: the key pose of a reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core.body.capsules import arm_clearance
from mgjax.core.body.roles import require_roles
from mgjax.core.kinematics import forward
from mgjax.hybrid.body.rig import (
    LimbRig,
    full_pose,
    key_poses,
    pose_cost,
    track_targets,
)
from mgjax.hybrid.config import ReachConfig
from mgjax.hybrid.ik.limbs import Limb
from mgjax.hybrid.reaching.placements import Placement
from mgjax.hybrid.reaching.sampled_walk import SampledWalk
from mgjax.hybrid.reaching.targets import Target

_DROPS = 7
"""Depths of the pelvis that are tried."""


@dataclass(frozen=True, kw_only=True, eq=False)
class KeyPose:
    """A pose that reaches.

    Attributes:
        place: where on the walk.
        rig: of the limbs.
        pose: of the rig's joints. [n, 4]
        drop_m: how far the pelvis is down.
        error_m: largest distance of an end to its target over the hold.
        clearance_m: of the arm to the body, at least over the hold; negative inside.
    """

    place: Placement
    rig: LimbRig
    pose: Float[np.ndarray, "n 4"]
    drop_m: float
    error_m: float
    clearance_m: float


def find_key_pose(
    sampled: SampledWalk,
    limbs: tuple[Limb, ...],
    targets: list[Target],
    place: Placement,
    config: ReachConfig,
) -> KeyPose:
    """The best pose that reaches targets at a place, or the one that comes nearest.

    Poses are found from the walk's own and from raised arms, with the pelvis at several depths;
    of those that arrive the one is best that least turns the torso, lowers the pelvis, and brings
    the arm near the body. It must also stay on the targets over the whole hold.
    """
    rig = sampled.body.rig(limbs, config)
    rate = sampled.graph.frame_rate
    steps = round(max(target.hold_s for target in targets) * rate)
    rows = np.full(steps + 1, place.frame)
    if not place.stop:
        rows = np.minimum(rows + np.arange(steps + 1), sampled.frames)
    points = np.stack([t.at(np.arange(steps + 1) / rate) for t in targets], axis=1)
    root, local = (
        np.asarray(x, np.float32)[rows]
        for x in (sampled.motion.root_translation, sampled.motion.local_rotations)
    )
    middle = steps // 2
    drops, scale = np.linspace(0, config.drop_m, _DROPS), sampled.body.scale
    down = drops[:, None] * np.array([[0.0, -1.0, 0.0]])
    solved = key_poses(
        rig,
        root[middle] + down,
        np.repeat(local[middle][None], _DROPS, axis=0),
        np.repeat(points[middle][None], _DROPS, axis=0),
    )
    starts = solved.shape[1]
    roots = np.repeat(root[middle] + down, starts, axis=0)
    poses = solved.reshape(-1, *solved.shape[2:])
    cost = _costs(sampled, rig, roots, local[middle], points[middle], poses, config)
    depth, number = divmod(int(np.argmin(cost + np.repeat(4.0 * drops / scale, starts))), starts)
    lowered = root + down[depth]
    poses = track_targets(rig, lowered, local, points, middle, solved[depth, number])
    positions = _positions(rig, lowered, local, poses)
    ends = positions[:, [limb.joints[-1] for limb in limbs]]
    arms = [limb.type for limb in limbs if limb.is_arm]
    clear = [arm_clearance(sampled.body.capsules, positions, arm.side).min() for arm in arms]
    return KeyPose(
        place=place,
        rig=rig,
        pose=poses[middle],
        drop_m=float(drops[depth]),
        error_m=float(np.linalg.norm(ends - points, axis=-1).max()),
        clearance_m=float(min(clear, default=np.inf)),
    )


def _positions(rig: LimbRig, root: np.ndarray, local: np.ndarray, poses: np.ndarray) -> np.ndarray:
    pose = full_pose(rig, root, local, poses)
    return np.asarray(forward(rig.skeleton, root.astype(np.float32), pose)[0], np.float64)


def _costs(
    sampled: SampledWalk,
    rig: LimbRig,
    roots: Float[np.ndarray, "P 3"],
    local: Float[np.ndarray, "J 4"],
    points: Float[np.ndarray, "E 3"],
    poses: Float[np.ndarray, "P n 4"],
    config: ReachConfig,
) -> Float[np.ndarray, " P"]:
    scale = sampled.body.scale
    positions = _positions(rig, roots, np.repeat(local[None], len(poses), axis=0), poses)
    cost = pose_cost(rig, local, poses)
    for limb, point in zip(rig.limbs, points, strict=True):
        miss = np.linalg.norm(positions[:, limb.joints[-1]] - point, axis=-1)
        # Missing by the tolerance or by a metre: both are worse than any pose that arrives.
        cost = cost + np.where(miss > 0.5 * config.hold_m, 100.0 + 100.0 * miss / scale, 0.0)
        if limb.is_arm:
            clear = arm_clearance(sampled.body.capsules, positions, limb.type.side)
            cost = cost + 40.0 * np.maximum(0.01 - clear / scale, 0.0)
            roles = (limb.type.role("shoulder"), limb.type.role("elbow"))
            joints = require_roles(rig.skeleton, roles)
            shoulder, elbow = (positions[:, joint, 1] for joint in joints)
            above = elbow - np.maximum(shoulder, point[1])
            cost = cost + 4.0 * np.maximum(above / scale, 0.0)
    return cost
