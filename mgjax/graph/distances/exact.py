"""Squared distances of single pairs of windows in float64, where float32 cannot tell."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis

_CHUNK = 1024


def exact_squared(
    axis: Axis, rows: Int[np.ndarray, " N"], columns: Int[np.ndarray, " N"]
) -> Float[np.ndarray, " N"]:
    """D² of pairs of windows, hybrid paper eq. 1, in float64, m²; the same both ways round.

    Values are multiples of the axis's grain, so that equal windows are as far from all others.

    Args:
        axis: of all clips.
        rows, columns: entries of the axis that are windows.
    """
    pairs = np.stack([np.minimum(rows, columns), np.maximum(rows, columns)])
    out = np.zeros(pairs.shape[1])
    with jax.enable_x64(True):
        weights = jnp.asarray(axis.weights, jnp.float64)
        for first in range(0, len(out), _CHUNK):
            part = axis.frames[pairs[:, first : first + _CHUNK]]
            count = part.shape[1]
            padded = np.pad(part, ((0, 0), (0, _CHUNK - count)), mode="edge")
            windows = axis.positions[padded[..., None] + np.arange(axis.window)]
            out[first : first + count] = np.asarray(_squared(windows, weights))[:count]
    out[rows == columns] = 0.0
    return np.maximum(np.round(out / axis.grain) * axis.grain, 0.0)


@jax.jit
def _squared(windows: Float[Array, "2 N W J 3"], weights: Float[Array, " J"]) -> Float[Array, " N"]:
    places = windows.astype(jnp.float64)
    share = weights / places.shape[2]
    floor = places[..., ::2]
    floor = floor - jnp.einsum("pnwjk,j->pnk", floor, share)[:, :, None, None]
    (ax, az), (bx, bz) = jnp.moveaxis(floor, -1, 1)
    rise = places[0, ..., 1] - places[1, ..., 1]

    def total(values: Array) -> Array:
        return jnp.einsum("nwj,j->n", values, share)

    spread = total(ax * ax + az * az + bx * bx + bz * bz + rise * rise)
    return spread - 2 * jnp.hypot(total(ax * bx + az * bz), total(ax * bz - az * bx))
