"""The same minima from a part of the pairs: blocks that a bound tells to be far are left out.

Half of the matrix is enough, since it is symmetric: a pair of the other half is judged with the
masks of rows and columns exchanged.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache, partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int, UInt8

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.bounds import BLOCK, Components, open_blocks, project
from mgjax.graph.distances.distance import (
    WindowFeatures,
    block_distances,
    rows_of,
)
from mgjax.graph.distances.judge import SLACK, judge, neighbours

TILE = 2048
"""Side of the tiles whose blocks are bounded together; a multiple of BLOCK."""

_CHUNK = 256
"""Most blocks that one call compares."""

_FAR = 1e6
"""m². Squared length of what may not be used: it is near nothing."""

_TILES_KEPT = 64
"""Tiles whose features are kept; those of more are computed anew."""


@partial(jax.jit, static_argnames=("window", "reach"))
def _blocks(
    a: WindowFeatures,
    b: WindowFeatures,
    numbers: Int[Array, "2 N"],
    count: Array,
    limit: Float[Array, ""],
    slack: Float[Array, ""],
    *,
    window: int,
    reach: int,
) -> tuple[UInt8[Array, " P"], Float[Array, " P"]]:
    """The first ``count`` blocks of pairs with their margins, judged, and their D²;
    P = N · (BLOCK + 2 reach)².

    ``numbers``: of the blocks, by rows and by columns.
    """
    size = BLOCK + 2 * reach

    def one(k: Array, out: Array) -> Array:
        rows = rows_of(a, numbers[0, k] * BLOCK, size, window)
        columns = rows_of(b, numbers[1, k] * BLOCK, size, window)
        squared = jnp.maximum(block_distances(rows, columns, window), 0.0)
        return jax.lax.dynamic_update_index_in_dim(out, squared, k, 0)

    room = jnp.full((numbers.shape[1], size, size), _FAR, jnp.float32)
    flat = jax.lax.fori_loop(0, count, one, room).reshape(-1)
    # In one line a neighbour is a shift of all of it; of short rows the compiler makes slow code.
    # What is nearer to the border than ``reach`` is judged by what happens to lie there.
    first = reach * (size + 1)
    inner = flat.shape[0] - 2 * first
    shifted = [flat[first + i * size + j :][:inner] for i, j in [(0, 0), *neighbours(reach)]]
    return jnp.pad(judge(shifted[0], shifted[1:], limit, slack), first), flat


def _allowed(axis: Axis, number: int, *, rows: bool) -> np.ndarray:
    """Which entries of a tile count as rows, or as columns. [TILE + 2 reach]"""
    mask, size = axis.leave if rows else axis.arrive, TILE + 2 * axis.margin
    known = mask[number * TILE : number * TILE + size]
    return np.pad(known, (0, size - len(known)))


def _features(axis: Axis, number: int) -> tuple[WindowFeatures, WindowFeatures]:
    """Of a tile as rows and as columns; what is not allowed there is far from everything."""
    plain = axis.features(number * TILE, TILE + 2 * axis.margin)
    plain = jax.tree.map(jnp.asarray, plain)
    masks = [_allowed(axis, number, rows=rows) for rows in (True, False)]
    rows, columns = (
        replace(plain, spread=jnp.where(mask, plain.spread, jnp.float32(_FAR))) for mask in masks
    )
    return rows, columns


def _alike(axis: Axis, number: int) -> np.ndarray:
    """Blocks of a tile whose entries count as rows where they count as columns. [TILE / BLOCK]"""
    rows, columns = (_allowed(axis, number, rows=rows) for rows in (True, False))
    size = BLOCK + 2 * axis.margin
    firsts = range(0, TILE, BLOCK)
    return np.array([np.array_equal(rows[k : k + size], columns[k : k + size]) for k in firsts])


def search_pruned(
    axis: Axis,
    limit: float,
    *,
    watched: Callable[[list[tuple[int, int]]], Iterable[tuple[int, int]]],
    threads: int | None = None,
    pairs: Sequence[tuple[int, int]] | None = None,
    components: Components | None = None,
) -> np.ndarray:
    """Every pair that may be a local minimum.

    Args:
        axis: of all clips.
        limit: m², finite.
        watched: goes through pairs of tiles, and tells how far it is.
        threads: tiles that are searched at the same time; None: as many as there are processors.
        pairs: of tiles that are searched, the first no later than the second; None: all.
        components: of the bounds; None: those of the axis itself.

    Returns:
        Rows, columns, judgements and D², m². [4, M]
    """
    reach, window = axis.margin, axis.window
    side = BLOCK + 2 * reach
    count = axis.tiles(TILE)
    # Bounds begin behind the margin, where the first block does.
    projected, longest = project(axis, count * TILE + reach, TILE, components)
    bounds = jnp.asarray(projected[:, reach:])
    features = lru_cache(maxsize=_TILES_KEPT)(partial(_features, axis))
    # Of the thread that asks, for those of the pool.
    device = jax.config.jax_default_device  # pyright: ignore[reportAttributeAccessIssue]

    def compare(first: int, second: int, numbers: np.ndarray, rows: bool) -> np.ndarray:
        """Pairs of blocks: as rows and columns, or as columns and rows. [4, M]"""
        found = [np.zeros((4, 0))]
        a, b = features(first)[not rows], features(second)[rows]
        for begin in range(0, numbers.shape[1], _CHUNK):
            part = numbers[:, begin : begin + _CHUNK]
            judged, squared = (
                np.asarray(values)
                for values in _blocks(
                    a,
                    b,
                    jnp.asarray(np.pad(part, ((0, 0), (0, _CHUNK - part.shape[1])))),
                    jnp.int32(part.shape[1]),
                    jnp.float32(limit),
                    jnp.float32(SLACK * longest),
                    window=window,
                    reach=reach,
                )
            )
            where = np.flatnonzero(judged)
            block, r, c = np.unravel_index(where, (_CHUNK, side, side))
            inner = (np.minimum(r, c) >= reach) & (np.maximum(r, c) < reach + BLOCK)
            where, block, r, c = (x[inner] for x in (where, block, r, c))
            row = first * TILE + part[0, block] * BLOCK + r
            column = second * TILE + part[1, block] * BLOCK + c
            each = (row, column, judged[where], squared[where])
            found.append(np.stack([values.astype(float) for values in each]))
        return np.concatenate(found, axis=1)

    def search(pair: tuple[int, int]) -> np.ndarray:
        first, second = pair
        places = jnp.int32(first * TILE), jnp.int32(second * TILE)
        opened = np.asarray(open_blocks(bounds, *places, jnp.float32(limit), tile=TILE))
        if first == second:
            opened = np.triu(opened)
        alike = _alike(axis, first)[:, None] & _alike(axis, second)[None, :]
        diagonal = np.eye(len(opened), dtype=bool) & (first == second)
        # A block on the diagonal has both halves in it already.
        once, twice, still = (
            opened & alike & ~diagonal,
            opened & ~alike & ~diagonal,
            opened & diagonal,
        )
        chosen = [np.stack(np.nonzero(x)).astype(np.int32) for x in (once, twice, still)]
        both = compare(first, second, chosen[0], True)
        return np.concatenate(
            [
                both,
                both[[1, 0, 2, 3]],
                compare(first, second, chosen[1], True),
                compare(first, second, chosen[1], False)[[1, 0, 2, 3]],
                compare(first, second, chosen[2], True),
            ],
            axis=1,
        )

    def there(pair: tuple[int, int]) -> np.ndarray:
        with jax.default_device(device):
            return search(pair)

    if pairs is None:
        pairs = [(i, j) for i in range(count) for j in range(i, count)]
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        futures = [pool.submit(there, pair) for pair in pairs]
        try:
            found = [futures[k].result() for k, _ in enumerate(watched(list(pairs)))]
            return np.concatenate([np.zeros((4, 0)), *found], axis=1)
        finally:
            for future in futures:
                future.cancel()
