"""Discs that hold the root wherever a walk goes: the lower bound of the path search."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from mgjax.core import csr


def look_ahead(
    first: Int[np.ndarray, " N1"],
    target: Int[np.ndarray, " K"],
    frames: Int[np.ndarray, " K"],
    end: Float[np.ndarray, "K 3"],
    track: Float[np.ndarray, "K C W"],
    delta: int,
) -> Float[np.ndarray, "N 4 T"]:
    """A disc for each stop and each of the 2 Δ frames after it that holds the root of every walk.

    The discs of the first Δ frames hold the macro edges from the stop, those of the second Δ also
    the discs of the stops at which these end.

    Args:
        first: the macro edges from stop n are first[n] … first[n+1] − 1. [N + 1]
        target, frames, end, track: see :class:`mgjax.hybrid.macro.macro_edges.MacroEdges`; of the
            track the first three columns are read. [K], [K], [K, 3], [K, 3…, W]
        delta: frames that a macro edge lasts at least, Δ.

    Returns:
        x, z, arc length so far, and the radius, m. [N, 4, 2 Δ]
    """
    discs = np.concatenate([track[:, :3, :delta], np.zeros((len(track), 1, delta))], axis=1)
    near = _enclosed(discs, first)
    step = np.arange(delta, 2 * delta)
    inside = step < frames[:, None]
    own = np.pad(track[:, :3], ((0, 0), (0, 0), (0, 1)), mode="edge")[:, :, delta:]
    later = near[target[:, None], :, np.clip(step - frames[:, None], 0, delta - 1)]
    c, s = np.cos(end[:, :1]), np.sin(end[:, :1])
    moved = np.stack(
        [
            later[..., 0] * c + later[..., 1] * s + end[:, 1:2],
            later[..., 1] * c - later[..., 0] * s + end[:, 2:],
            later[..., 2] + track[:, 2, -1:],
            later[..., 3],
        ],
        axis=1,
    )
    own = np.concatenate([own, np.zeros((len(own), 1, delta))], axis=1)
    far = _enclosed(np.where(inside[:, None], own, moved), first)
    return np.concatenate([near, far], axis=2)


def _enclosed(discs: np.ndarray, first: np.ndarray) -> np.ndarray:
    """A disc for each stop around the discs [K, (x, z, arc, radius), T] of its macro edges.

    The radius also holds half the spread of the arc: P(s) moves no farther than s does.
    """
    low = np.minimum.reduceat(discs[:, :3], first[:-1], axis=0)
    high = np.maximum.reduceat(discs[:, :3], first[:-1], axis=0)
    middle = 0.5 * (low + high)
    owner, _ = csr.expand(np.diff(first))
    off = discs[:, :3] - middle[owner]
    reach = np.linalg.norm(off[:, :2], axis=1) + np.abs(off[:, 2]) + discs[:, 3]
    radius = np.maximum.reduceat(reach, first[:-1], axis=0) + 1e-5
    return np.concatenate([middle, radius[:, None]], axis=1)
