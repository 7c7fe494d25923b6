"""BVH files of one motion, written in the ways of different makers."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.motion import Motion, cut
from mgjax.core.skeleton import Skeleton

Y_TO_Z = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
"""Turns Y up to Z up."""


def walk(frames: int = 40) -> tuple[Skeleton, Motion]:
    """A piece of a procedural walk."""
    clip = next(c for c in synthetic_clips(seed=0)[0] if "walk" in c.name)
    return clip.skeleton, cut(clip.motion, 0, frames)


@dataclass(frozen=True, kw_only=True)
class Maker:
    """How a file is written.

    Attributes:
        scale: numbers per metre.
        world: turn of the world.
        turn_rest: whether the rest pose is turned with the world.
        along_x: all bones lie along x in the rest pose.
        floor: height of the floor in the file, m.
        names: new names of joints.
        floor_root: a joint on the floor above the hips, which moves under them.
    """

    scale: float = 100.0
    world: np.ndarray = field(default_factory=lambda: np.eye(3))
    turn_rest: bool = True
    along_x: bool = False
    floor: float = 0.0
    names: dict[str, str] = field(default_factory=dict)
    floor_root: bool = False


def write(path: Path, skeleton: Skeleton, motion: Motion, maker: Maker) -> None:
    """Writes the motion as a BVH file of that maker, with plain rotation matrices."""
    parents = skeleton.parents
    joints = skeleton.num_joints
    offsets = np.asarray(skeleton.offsets, np.float64)
    local = np.asarray(motion.local_rotations, np.float64)
    turns = Rotation.from_quat(local[..., [1, 2, 3, 0]].reshape(-1, 4)).as_matrix()
    turns = turns.reshape(*local.shape[:2], 3, 3)
    world = np.zeros_like(turns)
    for j, p in enumerate(parents):
        world[:, j] = turns[:, j] if p < 0 else world[:, p] @ turns[:, j]
    root = np.asarray(motion.root_translation, np.float64) + np.array([0, maker.floor, 0])
    world, root = maker.world @ world, root @ maker.world.T
    # The frame of joint j is turned by R: its bones become R · o, its rotation W · G · Rᵀ.
    rest = np.tile(maker.world if maker.turn_rest else np.eye(3), (joints, 1, 1))
    if maker.along_x:
        rest = np.stack([_to_x(offsets, parents, j) for j in range(joints)])
    turned = np.stack([rest[max(p, 0)] @ offsets[j] for j, p in enumerate(parents)])
    world = world @ np.swapaxes(rest, -1, -2)
    lines = ["HIERARCHY"]
    columns: list[np.ndarray] = []
    children = [[j for j, p in enumerate(parents) if p == k] for k in range(joints)]

    def angles(matrices: np.ndarray) -> np.ndarray:
        with warnings.catch_warnings():  # where the middle angle is 90°, the others share a turn
            warnings.filterwarnings("ignore", "Gimbal lock")
            return Rotation.from_matrix(matrices).as_euler("ZXY", degrees=True)

    def emit(j: int, pad: str) -> None:
        name = maker.names.get(skeleton.names[j], skeleton.names[j])
        if j in skeleton.end_joints:
            lines.append(f"{pad}End Site")
        else:
            top = j == 0 and not maker.floor_root
            lines.append(f"{pad}{'ROOT' if top else 'JOINT'} {name}")
        place = turned[j] * maker.scale if j else np.zeros(3)
        lines.append(f"{pad}{{")
        lines.append(f"{pad} OFFSET {' '.join(f'{v:.6f}' for v in place)}")
        if j not in skeleton.end_joints:
            moves = "Xposition Yposition Zposition " if j == 0 else ""
            count = 6 if j == 0 else 3
            lines.append(f"{pad} CHANNELS {count} {moves}Zrotation Xrotation Yrotation")
            p = parents[j]
            here = world[:, j] if p < 0 else np.swapaxes(world[:, p], -1, -2) @ world[:, j]
            if j == 0:
                under = root * [1, 0, 1] if maker.floor_root else 0.0
                columns.append((root - under) * maker.scale)
            columns.append(angles(here))
        for child in children[j]:
            emit(child, pad + " ")
        lines.append(f"{pad}}}")

    if maker.floor_root:
        lines += ["ROOT Reference", "{", " OFFSET 0 0 0"]
        lines.append(" CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation")
        columns += [root * [1, 0, 1] * maker.scale, np.zeros((len(root), 3))]
        emit(0, " ")
        lines.append("}")
    else:
        emit(0, "")
    rows = np.concatenate(columns, axis=1)
    lines += ["MOTION", f"Frames: {len(rows)}", f"Frame Time: {1 / motion.frame_rate:.8f}"]
    lines += [" ".join(f"{v:.6f}" for v in row) for row in rows]
    path.write_text("\n".join(lines) + "\n")


def _to_x(offsets: np.ndarray, parents: tuple[int, ...], joint: int) -> np.ndarray:
    """A rotation that brings the bone from a joint to its first child along x."""
    child = next((j for j, p in enumerate(parents) if p == joint and offsets[j].any()), None)
    if child is None:
        return np.eye(3)
    bone = offsets[child] / np.linalg.norm(offsets[child])
    return Rotation.align_vectors([[1.0, 0, 0]], [bone])[0].as_matrix()
