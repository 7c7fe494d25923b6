"""Poses that reach: a key pose, and the poses around it, each found from its neighbour."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Float

from mgjax.core import kinematics, quaternion
from mgjax.core.arrays import Array
from mgjax.core.body.joint_limits import JointLimits, clamp, from_swing_twist
from mgjax.core.body.roles import find_role
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.padding import pad_axis
from mgjax.hybrid.ik import tree_steps as steps
from mgjax.hybrid.ik.limbs import ARMS, Limb, orientation_locked
from mgjax.hybrid.ik.pose import moved_joints
from mgjax.hybrid.ik.rotations import with_local_rotations
from mgjax.hybrid.ik.tree import fabrik_tree

TOLERANCE_M = 3e-4
"""FABRIK's. Small, for what is left of it trembles from frame to frame."""
_STEPS = 24
"""Least-squares steps at most for a key pose, after FABRIK's stages."""
_STEPS_ON = 6
"""Least-squares steps at most for each pose that is found from the one before it."""
_BLOCK = 64
"""Frames that are solved by one compiled call."""
_SHOULDERS_DEG = ((20, 10), (60, 20), (110, 20), (150, 30), (50, -45), (70, 80))
"""Shoulders of the poses that a key pose is looked for from: forward and up, and out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LimbRig:
    """What moves in a reach of some limbs.

    Attributes:
        skeleton: of the body.
        limbs: those that reach.
        limits: of the joints, or None.
        joints: that move, parents first.
        locked: joints that keep their orientation in the world.
        parents, ends: the tree of the joints, as :func:`fabrik_tree` takes it.
    """

    skeleton: Skeleton
    limbs: tuple[Limb, ...]
    limits: JointLimits | None
    joints: tuple[int, ...]
    locked: tuple[int, ...]
    parents: tuple[int, ...]
    ends: tuple[int, ...]

    @property
    def offsets(self) -> Float[np.ndarray, "n 3"]:
        return np.asarray(self.skeleton.offsets, np.float32)[list(self.joints)]


def make_limb_rig(
    skeleton: Skeleton, limbs: tuple[Limb, ...], limits: JointLimits | None
) -> LimbRig:
    """The rig of limbs; limits are of :func:`moved_joints`."""
    joints = moved_joints(limbs)
    above = [skeleton.parents[joint] for joint in joints]
    return LimbRig(
        skeleton=skeleton,
        limbs=limbs,
        limits=limits,
        joints=joints,
        locked=orientation_locked(skeleton, limbs),
        parents=tuple(joints.index(p) if p in joints else -1 for p in above),
        ends=tuple(joints.index(limb.joints[-1]) for limb in limbs),
    )


def starting_poses(rig: LimbRig, local: Float[np.ndarray, "J 4"]) -> Float[np.ndarray, "A n 4"]:
    """Poses from which a key pose is looked for: the walk's, and some with arms raised."""
    own = local[list(rig.joints)][None].astype(np.float32)
    if rig.limits is None:
        return own
    limits = rig.limits
    count = len(rig.joints)
    swing = np.zeros((len(_SHOULDERS_DEG), count, 2), np.float32)
    for arm in ARMS:
        shoulder = find_role(rig.skeleton, arm.role("shoulder"))
        if shoulder in rig.joints:
            forward_out = np.radians(np.array(_SHOULDERS_DEG)) * [1.0, -arm.sign]
            swing[:, rig.joints.index(shoulder)] = forward_out
    raised = from_swing_twist(swing, np.zeros(swing.shape[:2], np.float32), limits)
    return np.concatenate([own, np.asarray(clamp(raised, limits), np.float32)])


@partial(jax.jit, static_argnames=("parents", "ends"))
def _track(
    offsets: Array,
    bases: Array,
    frames: Array,
    targets: Array,
    first: Array,
    limits: JointLimits | None,
    *,
    parents: tuple[int, ...],
    ends: tuple[int, ...],
) -> Array:
    """[F, n, 4]: the poses of one frame after another, each found from the one before."""
    tree = tuple(jnp.asarray(table) for table in steps.tree_tables(steps.Tree(parents, ends)))
    is_end = tree[3][:, None] >= 0

    def step(pose: Array, row: tuple[Array, Array, Array]) -> tuple[Array, Array]:
        rig = steps.TreeProblem(offsets, *row, *tree)

        def more(state: tuple[Array, Array]) -> Array:
            count, pose = state
            return (count < _STEPS_ON) & (jnp.max(steps.residuals(rig, pose)) > TOLERANCE_M)

        def once(state: tuple[Array, Array]) -> tuple[Array, Array]:
            count, pose = state
            return count + 1, jnp.where(
                is_end, pose, steps.damped_least_squares_step(rig, pose, limits)
            )

        solved = lax.while_loop(more, once, (jnp.int32(0), pose))[1]
        return solved, solved

    return lax.scan(step, first, (bases, frames, targets))[1]


def key_poses(
    rig: LimbRig,
    root: Float[np.ndarray, "S 3"],
    local: Float[np.ndarray, "S J 4"],
    targets: Float[np.ndarray, "S E 3"],
) -> Float[np.ndarray, "S A n 4"]:
    """Key poses for poses of the body, each from all :func:`starting_poses` of the first."""
    start = starting_poses(rig, local[0])
    settings, poses = len(root), len(start)
    each = [np.repeat(x, poses, axis=0) for x in (*_bases(rig, root, local), targets)]
    solved, _ = fabrik_tree(
        rig.offsets, each[0], np.tile(start, (settings, 1, 1)), each[2].astype(np.float32),
        parents=rig.parents, ends=rig.ends, frame=each[1], limits=rig.limits,
        tolerance=TOLERANCE_M, max_steps=_STEPS, max_starts=1,
    )  # fmt: skip
    return np.asarray(solved).reshape(settings, *start.shape)


def track_targets(
    rig: LimbRig,
    root: Float[np.ndarray, "F 3"],
    local: Float[np.ndarray, "F J 4"],
    targets: Float[np.ndarray, "F E 3"],
    key: int,
    pose: Float[np.ndarray, "n 4"],
) -> Float[np.ndarray, "F n 4"]:
    """Poses of all frames of a span, found one after another from a key pose on, both ways."""
    base, frame = _bases(rig, root, local)
    count = len(root)
    shape = {"parents": rig.parents, "ends": rig.ends}

    def run(rows: np.ndarray) -> np.ndarray:
        solved = [pose[None].astype(np.float32)]
        for begin in range(0, len(rows), _BLOCK):
            chunk = rows[begin : begin + _BLOCK]
            rows_ = (base[chunk], frame[chunk], targets[chunk])
            arrays = [pad_axis(x.astype(np.float32), _BLOCK) for x in rows_]
            block = _track(rig.offsets, *arrays, solved[-1][-1], rig.limits, **shape)
            solved.append(np.asarray(block)[: len(chunk)])
        return np.concatenate(solved[1:])

    after = run(np.arange(key, count))
    before = run(np.arange(key, -1, -1))[::-1]
    return np.concatenate([before[:-1], after])


def full_pose(
    rig: LimbRig, root: np.ndarray, local: np.ndarray, solved: Float[np.ndarray, "F n 4"]
) -> Float[np.ndarray, "F J 4"]:
    """The body's local rotations with those found, and the locked joints locked."""
    local = local.astype(np.float32)
    _, turns = kinematics.forward(rig.skeleton, root.astype(np.float32), local)
    new: dict[int, Array] = {joint: solved[:, i] for i, joint in enumerate(rig.joints)}
    return np.asarray(with_local_rotations(rig.skeleton, local, turns, new, rig.locked))


def _bases(rig: LimbRig, root: np.ndarray, local: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place of the limbs' base, and world rotation of what it hangs on."""
    turn = local[:, 0].astype(np.float32)
    offset = np.asarray(rig.skeleton.offsets, np.float32)[rig.joints[0]]
    base = root + quaternion.rotate(turn, np.broadcast_to(offset, root.shape))
    return np.asarray(base, np.float32), turn


def pose_cost(
    rig: LimbRig, local: Float[np.ndarray, "J 4"], solved: Float[np.ndarray, "P n 4"]
) -> Float[np.ndarray, " P"]:
    """How far poses are from the walk's: turning the torso counts most, then an elbow held high."""
    turned = quaternion.angle_between(
        solved, np.broadcast_to(local[list(rig.joints)], solved.shape)
    )
    arms = {joint for limb in rig.limbs if limb.is_arm for joint in limb.joints}
    shoulders = [find_role(rig.skeleton, arm.role("shoulder")) for arm in ARMS]
    first = min((s for s in shoulders if s in arms and s is not None), default=math.inf)
    weight = np.where(np.array(rig.joints) < first, 3.0, 0.3)
    return np.sum(weight * np.asarray(turned) ** 2, axis=-1)
