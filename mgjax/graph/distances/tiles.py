"""All pairs of windows, tile by tile: the plain form, for small inputs and as a reference."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, UInt8

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.distance import (
    WindowFeatures,
    block_distances,
    rows_of,
)
from mgjax.graph.distances.judge import NO, SLACK, SURE, judge, neighbours

TILE = 1024


@partial(jax.jit, static_argnames=("window", "reach", "thinned", "measured"))
def _tile(
    features: WindowFeatures,
    valid: Bool[Array, " R"],
    leave: Bool[Array, " R"],
    arrive: Bool[Array, " R"],
    row: Array,
    column: Array,
    limit: Float[Array, ""],
    slack: Float[Array, ""],
    *,
    window: int,
    reach: int,
    thinned: int,
    measured: bool,
) -> tuple[UInt8[Array, "T T"], Float[Array, ""]]:
    """One tile of pairs: how they are judged, and if it is to be ``measured`` the largest D² of
    all."""
    size = TILE + 2 * reach
    of_rows = rows_of(features, row, size, window)
    of_columns = rows_of(features, column, size, window)
    squared = jnp.maximum(block_distances(of_rows, of_columns, window), 0.0)

    def pairs(rows: Array, columns: Array) -> Array:
        return (
            jax.lax.dynamic_slice_in_dim(rows, row, size)[:, None]
            & jax.lax.dynamic_slice_in_dim(columns, column, size)[None, :]
        )

    inner = slice(reach, reach + TILE)
    largest = jnp.float32(0.0)
    if measured:
        largest = jnp.max(jnp.where(pairs(valid, valid), squared, 0.0)[inner, inner])
    squared = jnp.where(pairs(leave, arrive), squared, jnp.inf)
    centre = squared[inner, inner]
    others = [
        squared[reach + i : reach + i + TILE, reach + j : reach + j + TILE]
        for i, j in neighbours(reach)
    ]
    judged = judge(centre, others, limit, slack)
    if thinned:
        lowest = (centre < limit) & _lowest_of_blocks(centre, thinned)
        judged = jnp.where(lowest, jnp.uint8(SURE), judged)
    return judged, largest


def _lowest_of_blocks(squared: Float[Array, "T T"], size: int) -> Bool[Array, "T T"]:
    """Which are the lowest of their block of ``size`` × ``size`` entries; blocks at the ends may be
    smaller."""
    count = -(-TILE // size)
    pad = count * size - TILE
    blocks = jnp.pad(squared, (0, pad), constant_values=jnp.inf).reshape(count, size, count, size)
    lowest = blocks.min(axis=(1, 3))
    spread = jnp.repeat(jnp.repeat(lowest, size, axis=0), size, axis=1)
    return squared <= spread[:TILE, :TILE]


def search_tiles(
    axis: Axis,
    limit: float,
    *,
    thinned: int,
    watched: Callable[[list[tuple[int, int]]], Iterable[tuple[int, int]]],
) -> tuple[np.ndarray, float]:
    """Every pair that may be a local minimum, or is the lowest of its block.

    Args:
        axis: of all clips.
        limit: m².
        thinned: side of a block; 0: none.
        watched: goes through the tiles, and tells how far it is.

    Returns:
        Rows, columns and judgements, [3, M], and the largest D² of any pair where the limit is
        infinite, m². The lowest of a block are ``SURE``.
    """
    reach = axis.margin
    count = axis.tiles(TILE)
    features = axis.features(0, count * TILE + 2 * reach)
    valid = np.zeros(len(features.spread), bool)
    valid[: len(axis)] = axis.valid
    leave, arrive = axis.masks(TILE)
    slack = jnp.float32(SLACK * features.spread.max(where=valid, initial=0.0))
    found = [np.zeros((3, 0), np.int64)]
    largest = 0.0
    for row, column in watched([(i, j) for i in range(count) for j in range(count)]):
        judged, highest = _tile(
            features,
            jnp.asarray(valid),
            leave,
            arrive,
            jnp.int32(row * TILE),
            jnp.int32(column * TILE),
            jnp.float32(min(limit, 1e36)),
            slack,
            window=axis.window,
            reach=reach,
            thinned=thinned,
            measured=bool(np.isinf(limit)),
        )
        largest = max(largest, float(highest))
        r, c = np.nonzero(np.asarray(judged) != NO)
        place = [r + row * TILE + reach, c + column * TILE + reach]
        found.append(np.stack([*place, np.asarray(judged)[r, c].astype(np.int64)]))
    return np.concatenate(found, axis=1), largest
