"""Writing BVH files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.core import quaternion
from mgjax.core.errors import MotionError, SkeletonError
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton, validate_skeleton
from mgjax.io.bvh.read import MARK
from mgjax.io.output import replace_file
from mgjax.io.text import (
    quoted,
    split_braces,
)


def save_bvh(path: str | Path, skeleton: Skeleton, motion: Motion) -> None:
    """Writes a BVH file in centimetres, rotation channels Z Y X; reading it back gives the motion.

    Angles go on from frame to frame. The root has no OFFSET, since some tools add it to the
    position and others do not. The first line says, in blanks at its end, that unit, up axis and
    floor are known.

    Raises:
        SkeletonError: the skeleton is not valid, or has a name that BVH cannot hold.
        MotionError: the motion does not fit the skeleton or is not finite.
        OutputError: the file cannot be written.
    """
    validate_skeleton(skeleton)
    validate_motion(skeleton, motion)
    for name in skeleton.names:
        if not name or name != " ".join(split_braces(name)) or set(name) & set("{}"):
            raise SkeletonError(f"joint name {quoted(name)}, expected one without braces or breaks")
    offsets = np.asarray(skeleton.offsets, dtype=np.float64) * 100
    offsets[0] = 0
    if motion.joint_offsets is not None and skeleton.end_joints:
        ends = list(skeleton.end_joints)
        places = np.asarray(motion.joint_offsets, dtype=np.float64)[:, ends]
        if (np.ptp(places, axis=0) > 1e-6).any():
            raise MotionError("an end joint moves in its parent's frame; BVH cannot say so")
        offsets[ends] = places[0] * 100
    lines = [MARK]
    columns: list[np.ndarray] = []
    children: dict[int, list[int]] = {}
    for joint, parent in enumerate(skeleton.parents):
        children.setdefault(parent, []).append(joint)
    angles = quaternion.to_euler_zyx(np.asarray(motion.local_rotations, np.float64))
    degrees = np.rad2deg(_continuous(np.asarray(angles)))
    end_joints = set(skeleton.end_joints)

    def write(joint: int, indent: str) -> None:
        is_end = joint in end_joints and joint not in children
        kind = "ROOT" if joint == 0 else "JOINT"
        lines.append(f"{indent}End Site" if is_end else f"{indent}{kind} {skeleton.names[joint]}")
        lines.append(f"{indent}{{")
        lines.append(f"{indent}  OFFSET {' '.join(f'{v:.6f}' for v in offsets[joint])}")
        if not is_end:
            channels = "Zrotation Yrotation Xrotation"
            if joint == 0 or motion.joint_offsets is not None:
                places = motion.root_translation if joint == 0 else motion.joint_offsets[:, joint]  # type: ignore[index]
                channels = f"Xposition Yposition Zposition {channels}"
                columns.append(np.asarray(places, dtype=np.float64) * 100)
            lines.append(f"{indent}  CHANNELS {len(channels.split())} {channels}")
            columns.append(degrees[:, joint])
        for child in children.get(joint, []):
            write(child, indent + "  ")
        lines.append(f"{indent}}}")

    write(0, "")
    rows = np.concatenate(columns, axis=1) + 0.0  # no "-0.000000"
    lines += ["MOTION", f"Frames: {motion.num_frames}", f"Frame Time: {1 / motion.frame_rate:.10f}"]
    form = " ".join(["%.6f"] * rows.shape[1])
    lines += [form % tuple(row) for row in rows.tolist()]
    replace_file(path, "\n".join(lines) + "\n")


def _continuous(angles: np.ndarray) -> np.ndarray:
    """Angles Z Y X that go on from frame to frame. [F,J,3], rad

    A rotation has two forms, (z, y, x) and (z + π, π − y, x + π), each up to whole turns. From a
    frame to the next, the nearer form is taken: whether to change forms depends on both frames, and
    which form each frame has on how many changes came before.
    """
    turn = 2 * np.pi
    other = np.stack([angles[..., 0] + np.pi, np.pi - angles[..., 1], angles[..., 2] + np.pi], -1)

    def far(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.abs((a - b + np.pi) % turn - np.pi).sum(axis=-1)

    changes = far(other[1:], angles[:-1]) < far(angles[1:], angles[:-1])
    odd = np.concatenate(
        [np.zeros((1, angles.shape[1]), bool), np.cumsum(changes, axis=0) % 2 == 1]
    )
    return np.unwrap(np.where(odd[..., None], other, angles), axis=0)
