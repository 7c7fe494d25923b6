"""Changes of motion in plain float64 NumPy, one pose and one joint at a time."""

from __future__ import annotations

import numpy as np


def spline(knot: int, degree: int, at: float) -> float:
    """A B-spline with knots at the whole numbers from ``knot`` on, by Cox and de Boor."""
    if degree == 0:
        return 1.0 if knot <= at < knot + 1 else 0.0
    left = (at - knot) / degree * spline(knot, degree - 1, at)
    right = (knot + degree + 1 - at) / degree * spline(knot + 1, degree - 1, at)
    return left + right


def turn_matrix(vector: np.ndarray) -> np.ndarray:
    """The rotation about a vector by its length, by Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def matrix_of(q: np.ndarray) -> np.ndarray:
    """The rotation of a unit quaternion."""
    w, x, y, z = np.asarray(q, np.float64)
    return turn_matrix(2 * np.arctan2(np.linalg.norm([x, y, z]), w) * _unit(np.array([x, y, z])))


def _unit(vector: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-12 else vector


def upper_places(
    parents: tuple[int, ...],
    offsets: np.ndarray,
    root: np.ndarray,
    rotations: np.ndarray,
    vectors: dict[int, np.ndarray],
    shift: np.ndarray,
) -> np.ndarray:
    """Places of all joints after some turn by rotation vectors in their own frames; legs stiff.

    Args:
        parents, offsets: the skeleton.
        root, rotations: the pose, local quaternions.
        vectors: by joint, rad.
        shift: of the root, m.
    """
    places, world = [], []
    for joint, parent in enumerate(parents):
        own = matrix_of(rotations[joint]) @ turn_matrix(vectors.get(joint, np.zeros(3)))
        if parent < 0:
            places.append(np.asarray(root, np.float64) + shift)
            world.append(own)
            continue
        places.append(places[parent] + world[parent] @ np.asarray(offsets[joint], np.float64))
        world.append(world[parent] @ own)
    return np.array(places)


def knee_place(
    hip: np.ndarray, knee: np.ndarray, ankle: np.ndarray, target: np.ndarray
) -> np.ndarray:
    """Where a knee is when its ankle is put at a target, by the law of cosines.

    The knee opens in the plane of the leg until hip and ankle are as far apart as hip and target;
    then the leg swings from the one direction to the other by the smallest rotation.
    """
    a, b = np.linalg.norm(knee - hip), np.linalg.norm(ankle - knee)
    far = np.linalg.norm(target - hip)
    angle = np.arccos((a * a - b * b + far * far) / (2 * a * far))
    normal = _unit(np.cross(knee - hip, ankle - knee))
    opened = turn_matrix(angle * normal) @ _unit(knee - hip)
    wanted = _unit(target - hip)
    axis = np.cross(opened, wanted)
    swing = np.arctan2(np.linalg.norm(axis), opened @ wanted)
    return hip + turn_matrix(swing * _unit(axis)) @ (knee - hip)
