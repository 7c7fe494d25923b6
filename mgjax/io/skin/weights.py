"""Which joints a vertex moves with: those of the shapes it lies on or near, smoothed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int, Integer
from scipy.sparse import coo_array, csr_array

from mgjax.core.skeleton import Skeleton
from mgjax.io.skin.field import Shape, capsule_distance

_REACH = 0.016
"""A shape that lies so much farther than the nearest counts by 1/e; of a usual body, m."""
_ROUNDS = 3


def skin_weights(
    skeleton: Skeleton,
    shapes: Sequence[Shape],
    vertices: Float[np.ndarray, "V 3"],
    triangles: Int[np.ndarray, "T 3"],
    scale: float,
) -> tuple[Int[np.ndarray, "V 4"], Integer[np.ndarray, "V 4"]]:
    """Joints of each vertex and their shares times 255, the largest first; they add up to 255."""
    joints = sorted({shape.capsule.joint for shape in shapes})
    column = {joint: i for i, joint in enumerate(joints)}
    near = np.full((len(vertices), len(joints)), np.inf)
    for shape in shapes:
        values = near[:, column[shape.capsule.joint]]
        np.minimum(values, capsule_distance(shape.capsule, vertices).distance, out=values)
    nearest = near.argmin(axis=1)
    allowed = _neighbours(skeleton, joints)
    off = near - near[np.arange(len(near)), nearest][:, None]
    weights = np.where(allowed[nearest], np.exp(-off / (_REACH * scale)), 0.0)
    weights /= weights.sum(axis=1, keepdims=True)
    mean = _mean_around(triangles, len(vertices))
    for _ in range(_ROUNDS):
        weights = 0.5 * weights + 0.5 * (mean @ weights)
    return _largest(weights, np.array(joints))


def _neighbours(skeleton: Skeleton, joints: list[int]) -> np.ndarray:
    """Which of some joints follow one another in the tree, with none of them between. [K,K]"""
    column = {joint: i for i, joint in enumerate(joints)}
    allowed = np.eye(len(joints), dtype=bool)
    for joint in joints:
        above = skeleton.parents[joint]
        while above >= 0 and above not in column:
            above = skeleton.parents[above]
        if above >= 0:
            allowed[column[joint], column[above]] = allowed[column[above], column[joint]] = True
    return allowed


def _mean_around(triangles: np.ndarray, count: int) -> csr_array:
    """The mean over the vertices at the other ends of a vertex' edges, as a sparse matrix."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    number = np.bincount(ends[:, 0], minlength=count)
    share = 1.0 / number[ends[:, 0]]
    return coo_array((share, (ends[:, 0], ends[:, 1])), shape=(count, count)).tocsr()


def _largest(weights: np.ndarray, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    most = min(4, weights.shape[1])
    order = np.argsort(-weights, axis=1, kind="stable")[:, :most]
    shares = np.take_along_axis(weights, order, axis=1)
    shares = np.rint(255 * shares / shares.sum(axis=1, keepdims=True)).astype(np.int64)
    shares[:, 0] += 255 - shares.sum(axis=1)
    chosen = np.where(shares > 0, joints[order], 0)
    pad = ((0, 0), (0, 4 - most))
    return np.pad(chosen, pad), np.pad(shares, pad).astype(np.uint8)
