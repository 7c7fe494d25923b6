"""Blends of transitions in float64 loops, one joint and one frame at a time.

Written from the definitions alone; it shares no code with the package.
"""

from __future__ import annotations

import numpy as np

from tests.reference import kinematics
from tests.reference.graph import alpha, multiply


def share(form: str, p: int, window: int) -> float:
    """The first window's share in frame p of a crossfade."""
    u = p / window
    if form == "paper":
        return alpha(p, window) if p < window else 0.0
    if form == "smooth":
        return 1 - 10 * u**3 + 15 * u**4 - 6 * u**5
    return 1 - 3 * u**2 + 2 * u**3


def quintic(window: int) -> np.ndarray:
    """[2, W+1] curves from value 1, slope 0 and from value 0, slope 1 per frame, to rest at 0."""
    n = float(window)
    powers = np.arange(6)
    rows = [
        np.eye(6)[0],
        np.eye(6)[1],
        2 * np.eye(6)[2],
        n**powers,
        [k * n ** (k - 1) if k else 0.0 for k in range(6)],
        [k * (k - 1) * n ** (k - 2) if k > 1 else 0.0 for k in range(6)],
    ]
    coefficients = np.linalg.solve(np.array(rows, float), np.eye(6)[:, :2])
    return (np.arange(window + 1.0)[:, None] ** powers @ coefficients).T


def offsets(form: str, differences) -> np.ndarray:
    """[W+1, …] what is left of the differences [W+1, …] of two windows."""
    differences = np.asarray(differences, np.float64)
    window = len(differences) - 1
    left = np.zeros_like(differences)
    for p in range(window + 1):
        if form == "inertial":
            value, slope = quintic(window)[:, p]
            left[p] = value * differences[0] + slope * (differences[1] - differences[0])
        else:
            left[p] = share(form, p, window) * differences[p]
    return left


def turn_vectors(rotations_a, rotations_b) -> np.ndarray:
    """[W+1,3] rotation vectors of b⁻¹a of one joint, by angles that never jump by half a turn."""
    vectors = []
    last = None
    for a, b in zip(rotations_a, rotations_b, strict=True):
        q = multiply(np.array([b[0], -b[1], -b[2], -b[3]]), a)
        if last is not None and q @ last < 0:
            q = -q
        vectors.append(q)
        last = q
    if vectors[len(vectors) // 2][0] < 0:
        vectors = [-q for q in vectors]
    result = []
    for q in vectors:
        length = np.linalg.norm(q[1:])
        angle = 2 * np.arctan2(length, q[0])
        result.append(q[1:] * (angle / length if length > 1e-12 else 2.0))
    return np.array(result)


def blend(form: str, root_a, rotations_a, root_b, rotations_b, transform):
    """Roots [W+1,3] and local rotation matrices [W+1,J,3,3], b mapped by the transform first."""
    count, joints = np.shape(rotations_a)[:2]
    mapped = np.array([kinematics.planar_apply(transform, p) for p in root_b])
    roots = mapped + offsets(form, np.asarray(root_a, np.float64) - mapped)
    turn = (np.cos(transform[0] / 2), 0.0, np.sin(transform[0] / 2), 0.0)
    turns = np.zeros((count, joints, 3, 3))
    for joint in range(joints):
        b = np.asarray(rotations_b, np.float64)[:, joint]
        if joint == 0:
            b = np.array([multiply(turn, q) for q in b])
        left = offsets(form, turn_vectors(np.asarray(rotations_a, np.float64)[:, joint], b))
        for p in range(count):
            angle = np.linalg.norm(left[p])
            axis = left[p] / angle if angle > 1e-12 else np.array([1.0, 0, 0])
            turns[p, joint] = kinematics.matrix(b[p]) @ kinematics.turn_about(axis, angle)
    return roots, turns


def led(form: str, roots, balls, balls_a, balls_b, standing) -> np.ndarray:
    """Roots moved by what the standing balls of the feet ask for; balls [W+1,2,3]."""
    stands = [np.mean([bool(frame[side]) for frame in standing]) for side in range(2)]
    whole = max(sum(stands), 0.5)
    result = np.array(roots, np.float64)
    a, b = np.asarray(balls_a, np.float64), np.asarray(balls_b, np.float64)
    for side in range(2):
        wanted = b[:, side] + offsets(form, a[:, side] - b[:, side])
        result[1:-1] += (stands[side] / whole * (wanted - balls[:, side]))[1:-1]
    return result
