"""Parries by the book: rotation matrices joint by joint, and first contacts by many small steps."""

from __future__ import annotations

import numpy as np

from tests.reference import kinematics


def exponential(vector: np.ndarray) -> np.ndarray:
    """The rotation matrix of a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def arm_turned(
    shoulder: np.ndarray,
    elbow: np.ndarray,
    point: np.ndarray,
    shoulder_turn: np.ndarray,
    elbow_turn: np.ndarray,
    vectors: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Elbow and a point of the forearm after turns of shoulder and elbow in their own frames.

    Places become offsets in the joints' frames, the frames are turned, and all is put together
    again, as forward kinematics does.
    """
    upper, lower = kinematics.matrix(shoulder_turn), kinematics.matrix(elbow_turn)
    local = upper.T @ lower
    to_elbow, to_point = upper.T @ (elbow - shoulder), lower.T @ (point - elbow)
    upper = upper @ exponential(vectors[0])
    lower = upper @ local @ exponential(vectors[1])
    at = shoulder + upper @ to_elbow
    return at, at + lower @ to_point


def to_segment(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """Distance of a point to a segment."""
    axis = b - a
    share = min(max(float((point - a) @ axis) / max(float(axis @ axis), 1e-12), 0.0), 1.0)
    return float(np.linalg.norm(point - a - share * axis))


def touched_first(
    times: np.ndarray,
    positions: np.ndarray,
    bones: np.ndarray,
    radii: np.ndarray,
    centre: np.ndarray,
    radius: float,
) -> tuple[int, int] | None:
    """Moment and number of the first capsule that a sphere touches; None if it touches none.

    Args:
        times, positions: joints at many moments. [M], [M, J, 3]
        bones, radii: of the capsules. [B, 2], [B]
        centre: of the sphere at these moments. [M, 3]
        radius: of the sphere.
    """
    for moment in range(len(times)):
        gaps = [
            to_segment(centre[moment], *positions[moment, bone]) - reach - radius
            for bone, reach in zip(bones, radii, strict=True)
        ]
        if min(gaps) <= 0:
            return moment, int(np.argmin(gaps))
    return None
