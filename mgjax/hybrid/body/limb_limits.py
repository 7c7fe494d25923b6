"""How far the joints of a reaching body turn: what walking shows, widened to what people can do."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import quaternion
from mgjax.core.body.joint_limits import JointLimits, joint_limits, swing_twist
from mgjax.core.body.roles import find_role, require_roles
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.ik.limbs import ARMS, LIMBS, Limb, find_limb
from mgjax.hybrid.ik.pose import moved_joints

_SPINE_DEG = (-12.0, 32.0, -16.0, 16.0, -18.0, 18.0)
"""A joint of the spine: back, forward, to both sides, turned to both sides."""
_NECK_DEG = (-15.0, 30.0, -15.0, 15.0, -25.0, 25.0)
_CLAVICLE_DEG = (-12.0, 25.0, -18.0, 18.0, -8.0, 8.0)
"""Down, up, and to front and back."""
_SHOULDER_DEG = (-55.0, 172.0, -95.0, 155.0, -75.0, 75.0)
"""Back, forward and up; across the body, out and up; turned in and out. From the hanging arm."""
_ELBOW_DEG = (2.0, 148.0)
_ELBOW_PLAY_DEG = 6.0
_WRIST_DEG = (-35.0, 35.0, -35.0, 35.0, -50.0, 50.0)
_RANGES_DEG = {
    "spine": _SPINE_DEG,
    "neck": _NECK_DEG,
    "clavicle": _CLAVICLE_DEG,
    "shoulder": _SHOULDER_DEG,
    "wrist": _WRIST_DEG,
}
_PLAY = math.radians(3.0)
"""Every captured pose is inside, by so much."""


_END = -1
"""In place of a child: the joint is the end of a limb."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LimbLimits:
    """Limits of all limbs of a body, one row for each bone that a joint turns.

    Attributes:
        joints: that turn. [B]
        children: the next joint on the way to a limb's end; −1 for the end itself. [B]
        limits: of these joints for these bones. [B]
    """

    joints: Int[np.ndarray, " B"]
    children: Int[np.ndarray, " B"]
    limits: JointLimits

    def of(self, limbs: tuple[Limb, ...]) -> JointLimits:
        """The limits of some limbs' joints, in the order of :func:`moved_joints`."""
        bones = list(zip(self.joints.tolist(), self.children.tolist(), strict=True))
        rows = [bones.index((joint, _child(limbs, joint))) for joint in moved_joints(limbs)]
        return JointLimits(
            centre=self.limits.centre[rows],
            bone=self.limits.bone[rows],
            across=self.limits.across[rows],
            swing=self.limits.swing[rows],
            twist=self.limits.twist[rows],
        )


def make_limb_limits(graph: MotionGraph) -> LimbLimits:
    """Limits for the joints of the arms and the head.

    A joint turns about its mean rotation in the graph's clips, which also say about which axis an
    elbow bends and to which side: from nearly straight to 148°, never the other way. How far
    other joints turn is tabulated in this module, and every captured pose is within the limits.

    Deviation:
        Aristidou and Lasenby give limits by hand for one skeleton. Ranges of captured walks alone
        would not let a hand rise above the shoulder.
    """
    skeleton = graph.skeleton
    limbs = tuple(find_limb(skeleton, name) for name in LIMBS)
    bones = sorted(
        {bone for limb in limbs for bone in zip(limb.joints, (*limb.joints[1:], _END), strict=True)}
    )
    stop = int(graph.clip_stops[-1])
    rotations = graph.local_rotations[:stop].astype(np.float64)
    offsets = np.asarray(skeleton.offsets, np.float64)
    rest = rest_positions(skeleton)
    rows = []
    for joint, child in bones:
        bone = np.array([0.0, 1.0, 0.0]) if child == _END else offsets[child]
        rows.append(_limits_of(skeleton, rest, rotations[:, joint], joint, bone))
    centre, along, across, swing, twist = (np.stack(column) for column in zip(*rows, strict=True))
    built = joint_limits(
        along, swing=swing.tolist(), twist=twist.tolist(), across=across.tolist(), centre=centre
    )
    joints, children = np.array(bones).T
    limits = _with_captured(built, rotations[:, joints])
    return LimbLimits(joints=joints, children=children, limits=limits)


def _child(limbs: tuple[Limb, ...], joint: int) -> int:
    """The next joint on the way to an end; of the spine, on the way to the first limb's."""
    for limb in limbs:
        if joint in limb.joints[:-1]:
            return limb.joints[limb.joints.index(joint) + 1]
    return _END


def _limits_of(
    skeleton: Skeleton,
    rest: Float[np.ndarray, "J 3"],
    rotations: Float[np.ndarray, "F 4"],
    joint: int,
    bone: Float[np.ndarray, "3"],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Centre, bone, first axis, swing and twist of one joint."""
    centre = np.linalg.eigh(np.einsum("fi,fj->ij", rotations, rotations))[1][:, -1]
    part, side = _part(skeleton, joint)
    if part == "elbow":
        return _hinge(skeleton, rotations, joint, bone)
    # Axes in the parent's frame, which has the world's directions in the rest pose.
    left_hip, right_hip = require_roles(skeleton, ("left_hip", "right_hip"))
    left = rest[left_hip] - rest[right_hip]
    left[1] = 0.0
    left /= np.linalg.norm(left)
    # Forward and up is a turn about the left for a bone that points up, about the right for an arm
    # that hangs.
    first = -left if part == "shoulder" else left
    if part == "clavicle":  # it points to the side, and rises by a turn about the front or the back
        first = np.cross(left, [0.0, 1.0, 0.0]) * (1.0 if side == "left" else -1.0)
    if part == "wrist":  # of an arm that points to the side
        first = np.array([0.0, 1.0, 0.0])
    across = quaternion.rotate(quaternion.conjugate(centre), first)
    angles = np.radians(np.array(_RANGES_DEG[part]))
    swing = angles[:4].copy()
    # The second axis, bone × first: a hanging arm turns about it towards the right.
    if side == "left":
        swing[2:] = -angles[3:1:-1]
    return centre, bone, np.asarray(across), swing, angles[4:]


def _part(skeleton: Skeleton, joint: int) -> tuple[str, str]:
    """What a joint of a limb is, and on which side."""
    chains = {name: find_limb(skeleton, name).joints for name in LIMBS}
    for arm in ARMS:
        if joint not in chains[arm.name]:
            continue
        shoulder, elbow = (find_role(skeleton, arm.role(part)) for part in ("shoulder", "elbow"))
        if joint == elbow:
            return "elbow", arm.side
        if joint == shoulder:
            return "shoulder", arm.side
        if elbow is not None and joint > elbow:
            return "wrist", arm.side
        if not any(joint in chain for name, chain in chains.items() if name != arm.name):
            return "clavicle", arm.side
    in_an_arm = any(joint in chains[arm.name] for arm in ARMS)
    return ("spine" if in_an_arm else "neck"), ""


def _hinge(
    skeleton: Skeleton, rotations: np.ndarray, joint: int, bone: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """An elbow: from straight into the direction in which it bends in the clips."""
    offset = np.asarray(skeleton.offsets, np.float64)[joint]
    upper, lower = offset / np.linalg.norm(offset), bone / np.linalg.norm(bone)
    bent = quaternion.rotate(rotations, np.broadcast_to(lower, (len(rotations), 3)))
    normals = np.cross(np.broadcast_to(upper, bent.shape), bent)
    # Nearly straight elbows say little about the axis, and count little.
    axis = normals.sum(axis=0)
    axis = axis - (axis @ lower) * lower
    axis /= np.linalg.norm(axis)
    straight = np.asarray(quaternion.from_two_vectors(lower, upper))
    middle = math.radians(sum(_ELBOW_DEG) / 2)
    half = math.radians(_ELBOW_DEG[1] - _ELBOW_DEG[0]) / 2
    centre = quaternion.multiply(
        np.asarray(quaternion.from_axis_angle(axis, np.array(middle))), straight
    )
    own = np.asarray(quaternion.rotate(quaternion.conjugate(centre), axis))
    play = math.radians(_ELBOW_PLAY_DEG)
    return (
        np.asarray(centre),
        bone,
        own,
        np.array([-half, half, -play, play]),
        np.array([-play, play]),
    )


def _with_captured(limits: JointLimits, rotations: np.ndarray) -> JointLimits:
    """The limits, widened where a captured pose is outside.

    The ranges lie in ellipses; a pose outside widens the box until its ellipse holds it.
    """
    spread, turn = swing_twist(rotations, limits)
    swing = np.asarray(limits.swing, np.float64).copy()
    for axis in range(2):
        for side, sign in ((0, -1.0), (1, 1.0)):
            column = 2 * axis + side
            other = spread[..., 1 - axis]
            across = np.where(other < 0, -swing[:, 2 * (1 - axis)], swing[:, 2 * (1 - axis) + 1])
            used = np.clip(np.abs(other) / np.maximum(across, 1e-6), 0.0, 0.8)
            need = sign * spread[..., axis] / np.sqrt(1 - used**2)
            need = np.where(need > 0, need + _PLAY, 0.0).max(axis=0)
            swing[:, column] = sign * np.minimum(np.maximum(sign * swing[:, column], need), math.pi)
    low = np.minimum(limits.twist[:, 0], turn.min(axis=0) - _PLAY)
    high = np.maximum(limits.twist[:, 1], turn.max(axis=0) + _PLAY)
    return JointLimits(
        centre=limits.centre,
        bone=limits.bone,
        across=limits.across,
        swing=swing.astype(np.float32),
        twist=np.stack([low, high], axis=-1).astype(np.float32),
    )
