"""Geometry in float64 with rotation matrices, one joint and one frame at a time.

Written from the conventions alone (Y up, right-handed, quaternions wxyz, a planar transform is a
turn about +Y and then a translation on the floor). It shares no code with the package.
"""

from __future__ import annotations

import numpy as np


def matrix(q) -> np.ndarray:
    """Rotation matrix of the quaternion w + xi + yj + zk, from v → q v q⁻¹ (any length but 0)."""
    w, x, y, z = np.asarray(q, np.float64) / np.linalg.norm(np.asarray(q, np.float64))
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def axis_rotation(letter: str, angle: float) -> np.ndarray:
    """Right-handed rotation about a coordinate axis: about Z, x turns towards y."""
    c, s = np.cos(angle), np.sin(angle)
    i = "XYZ".index(letter)
    j, k = (i + 1) % 3, (i + 2) % 3
    result = np.eye(3)
    result[j, j], result[j, k] = c, -s
    result[k, j], result[k, k] = s, c
    return result


def euler(angles, order: str) -> np.ndarray:
    """Product of the axis rotations from left to right."""
    result = np.eye(3)
    for angle, letter in zip(angles, order, strict=True):
        result = result @ axis_rotation(letter, angle)
    return result


def angle_of(rotation: np.ndarray) -> float:
    """Angle of a rotation matrix, 0 … π; accurate also near 0 and π."""
    skew = np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    return float(np.arctan2(0.5 * np.linalg.norm(skew), 0.5 * (np.trace(rotation) - 1)))


def turn_about(axis, angle: float) -> np.ndarray:
    """Rodrigues: rotation about a unit vector."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], np.float64)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def slerp(a, b, t: float) -> np.ndarray:
    """Rotation matrix that is the share t of the way from a to b along the shortest arc."""
    start, end = matrix(a), matrix(b)
    between = end @ start.T
    angle = angle_of(between)
    if angle < 1e-9:
        return start
    values, vectors = np.linalg.eigh(0.5 * (between + between.T))
    axis = vectors[:, np.argmax(values)]
    if angle_of(turn_about(axis, angle) @ between.T) > angle_of(
        turn_about(-axis, angle) @ between.T
    ):
        axis = -axis
    return turn_about(axis, t * angle) @ start


def forward(parents, offsets, root, rotations) -> tuple[np.ndarray, np.ndarray]:
    """Positions [J,3] and rotation matrices [J,3,3] of one pose, joint by joint.

    A joint stands at its parent's place plus its offset turned by the parent's world rotation.
    """
    count = len(parents)
    positions = np.zeros((count, 3))
    turns = np.zeros((count, 3, 3))
    for joint, parent in enumerate(parents):
        local = matrix(rotations[joint])
        if parent < 0:
            positions[joint] = np.asarray(root, np.float64)
            turns[joint] = local
        else:
            positions[joint] = positions[parent] + turns[parent] @ np.asarray(
                offsets[joint], np.float64
            )
            turns[joint] = turns[parent] @ local
    return positions, turns


def global_positions(parents, offsets, roots, rotations) -> np.ndarray:
    """[F,J,3]; offsets [J,3], or [F,J,3] where bones are not rigid."""
    return np.array(
        [
            forward(parents, offsets[f] if np.ndim(offsets) == 3 else offsets, root, rot)[0]
            for f, (root, rot) in enumerate(zip(roots, rotations, strict=True))
        ]
    )


def planar_apply(transform, point) -> np.ndarray:
    """A turn about +Y by θ, then a translation on the floor."""
    theta, x0, z0 = (float(v) for v in transform)
    return axis_rotation("Y", theta) @ np.asarray(point, np.float64) + np.array([x0, 0.0, z0])


def heading(left_hip, right_hip) -> float:
    """Angle about +Y of (left hip − right hip) × up, measured from +Z towards +X."""
    ahead = np.cross(np.asarray(left_hip, np.float64) - right_hip, [0.0, 1.0, 0.0])
    return float(np.arctan2(ahead[0], ahead[2]))
