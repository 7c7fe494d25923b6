"""How far the joints of a reaching body turn: what walking shows, widened to what people can do."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from mgjax.core import quaternion
from mgjax.core.skeleton import Skeleton, find_role, rest_positions
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.ik.joint_limits import JointLimits, joint_limits, swing_twist
from mgjax.hybrid.ik.limbs import LIMBS, Limb, find_limb
from mgjax.hybrid.ik.pose import moved_joints

_SPINE_DEG = (-12.0, 32.0, -16.0, 16.0, -18.0, 18.0)
"""Of each joint of the spine: back, forward, to both sides, turned to both sides."""
_NECK_DEG = (-15.0, 30.0, -15.0, 15.0, -25.0, 25.0)
_CLAVICLE_DEG = (-12.0, 25.0, -18.0, 18.0, -8.0, 8.0)
"""Down, up, and to front and back."""
_SHOULDER_DEG = (-55.0, 172.0, -95.0, 155.0, -75.0, 75.0)
"""Back, forward and up; across the body, out and up; turned in and out. From the hanging arm."""
_ELBOW_DEG = (2.0, 148.0)
_ELBOW_PLAY_DEG = 6.0
_WRIST_DEG = (-35.0, 35.0, -35.0, 35.0, -50.0, 50.0)
_PLAY = math.radians(3.0)
"""Every captured pose is inside, by so much."""


@lru_cache(maxsize=32)
def reach_limits(graph: MotionGraph, limbs: tuple[Limb, ...]) -> JointLimits:
    """Limits for the joints of limbs, in the order of :func:`moved_joints`.

    A joint turns about its mean rotation in the graph's clips, which also say about which axis an
    elbow bends and to which side: from nearly straight to 148°, never the other way. How far
    other joints turn is tabulated in this module, and every captured pose is within the limits.

    Deviation:
        Aristidou and Lasenby give limits by hand for one skeleton. Ranges of captured walks alone
        would not let a hand rise above the shoulder.
    """
    skeleton = graph.skeleton
    joints = moved_joints(limbs)
    stop = int(graph.clip_stops[-1])
    rotations = graph.local_rotations[:stop].astype(np.float64)
    offsets = np.asarray(skeleton.offsets, np.float64)
    rest = rest_positions(skeleton)
    rows = []
    for joint in joints:
        child = _child(limbs, joint)
        bone = offsets[child] if child is not None else np.array([0.0, 1.0, 0.0])
        rows.append(_limits_of(skeleton, rest, rotations[:, joint], joint, bone))
    centre, bones, across, swing, twist = (np.stack(column) for column in zip(*rows, strict=True))
    built = joint_limits(
        bones, swing=swing.tolist(), twist=twist.tolist(), across=across.tolist(), centre=centre
    )
    return _with_captured(built, rotations[:, list(joints)])


def _child(limbs: tuple[Limb, ...], joint: int) -> int | None:
    """The next joint on the way to an end; of the spine, on the way to the first limb's."""
    for limb in limbs:
        if joint in limb.joints[:-1]:
            return limb.joints[limb.joints.index(joint) + 1]
    return None


def _limits_of(
    skeleton: Skeleton, rest: np.ndarray, rotations: np.ndarray, joint: int, bone: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Centre, bone, first axis, swing and twist of one joint."""
    centre = np.linalg.eigh(np.einsum("fi,fj->ij", rotations, rotations))[1][:, -1]
    part, side = _part(skeleton, joint)
    if part == "elbow":
        return _hinge(skeleton, rotations, joint, bone)
    # Axes in the parent's frame, which has the world's directions in the rest pose.
    left_hip, right_hip = (find_role(skeleton, f"{s}_hip") for s in ("left", "right"))
    assert left_hip is not None
    assert right_hip is not None
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
    table = {
        "spine": _SPINE_DEG,
        "neck": _NECK_DEG,
        "clavicle": _CLAVICLE_DEG,
        "shoulder": _SHOULDER_DEG,
        "wrist": _WRIST_DEG,
    }[part]
    angles = np.radians(np.array(table))
    swing = angles[:4].copy()
    # The second axis, bone × first: a hanging arm turns about it towards the right.
    if side == "left":
        swing[2:] = -angles[3:1:-1]
    return centre, bone, np.asarray(across), swing, angles[4:]


def _part(skeleton: Skeleton, joint: int) -> tuple[str, str]:
    """What a joint is, and on which side."""
    for side in ("left", "right"):
        shoulder, elbow = (find_role(skeleton, f"{side}_{part}") for part in ("shoulder", "elbow"))
        limb = find_limb(skeleton, f"{side}_hand").joints
        if joint in limb:
            if joint == elbow:
                return "elbow", side
            if joint == shoulder:
                return "shoulder", side
            if elbow is not None and joint > elbow:
                return "wrist", side
            others = [
                x for n in LIMBS if n != f"{side}_hand" for x in find_limb(skeleton, n).joints
            ]
            if joint not in others:
                return "clavicle", side
    arms = [x for s in ("left", "right") for x in find_limb(skeleton, f"{s}_hand").joints]
    return ("spine" if joint in arms else "neck"), ""


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
