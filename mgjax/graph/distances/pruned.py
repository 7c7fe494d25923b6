"""The same minima from a part of the pairs: blocks that a bound tells to be far are left out.

Half of the matrix is enough, since it is symmetric: a pair of the other half is judged with the
masks of rows and columns exchanged.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache, partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.core.parallel.run import run_all
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.bounds import BLOCK, Components, open_blocks, project
from mgjax.graph.distances.distance import (
    WindowFeatures,
    block_distances,
    rows_of,
)
from mgjax.graph.distances.judge import SLACK, lowest

TILE = 2048
"""Side of the tiles whose blocks are bounded together; a multiple of BLOCK."""

_CHUNK = 64
"""Most blocks that one call compares."""

_FAR = 1e6
"""m². Squared length of what may not be used: it is near nothing."""

_SQUARE = 24
"""Tiles on each side whose pairs are searched one after the other."""

_TILES_KEPT = 2 * _SQUARE + 2
"""Tiles whose features are kept; those of more are computed anew."""


@partial(jax.jit, static_argnames=("window", "reach"))
def _block_distances(
    a: WindowFeatures,
    b: WindowFeatures,
    numbers: Int[Array, "2 N"],
    count: Array,
    *,
    window: int,
    reach: int,
) -> Float[Array, "N S S"]:
    """D² of the first ``count`` blocks of pairs with their margins, m²; S = BLOCK + 2 reach.

    ``numbers``: of the blocks, by rows and by columns.
    """
    size = BLOCK + 2 * reach

    def one(k: Array, out: Array) -> Array:
        rows = rows_of(a, numbers[0, k] * BLOCK, size, window)
        columns = rows_of(b, numbers[1, k] * BLOCK, size, window)
        squared = jnp.maximum(block_distances(rows, columns, window), 0.0)
        return jax.lax.dynamic_update_index_in_dim(out, squared, k, 0)

    room = jnp.full((numbers.shape[1], size, size), _FAR, jnp.float32)
    return jax.lax.fori_loop(0, count, one, room)


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
    pairs: Sequence[tuple[int, int]],
    *,
    limits: Callable[[], Float[np.ndarray, " F"]] | None = None,
    threads: int | None = None,
    components: Components | None = None,
) -> Iterator[Float[np.ndarray, "4 M"]]:
    """Every pair that may be a local minimum, one pair of tiles after the other.

    Args:
        axis: of all clips.
        limit: m², finite.
        pairs: of tiles that are searched, the first no later than the second.
        limits: what a pair has to be below by the frame that its row begins at, m², no more than
            ``limit``; asked before each pair of tiles, since it may go down. None: ``limit``.
        threads: tiles that are searched at the same time; None: as many as there are processors.
        components: of the bounds; None: those of the axis itself.

    Yields:
        Rows, columns, judgements and D², m². Pairs above their ``limits`` may be among them.
    """
    search = _Search(axis, limit, limits, components)
    # Of the thread that asks, for those of the pool.
    device = jax.config.jax_default_device  # pyright: ignore[reportAttributeAccessIssue]

    def there(pair: tuple[int, int]) -> np.ndarray:
        with jax.default_device(device):
            return search.found(*pair)

    count = threads or os.cpu_count() or 1
    with ThreadPoolExecutor(count) as pool:
        for _, found in run_all(pool, there, pairs, ahead=2 * count):
            yield found


def tile_pairs(axis: Axis) -> list[tuple[int, int]]:
    """All pairs of tiles, the first no later than the second: squares of ``_SQUARE`` tiles whose
    features are kept, those near the diagonal first, so that all rows are met early."""
    count = axis.tiles(TILE)
    return [
        (first, second)
        for apart in range(0, count, _SQUARE)
        for i in range(0, count - apart, _SQUARE)
        for first in range(i, min(i + _SQUARE, count))
        for second in range(max(first, i + apart), min(i + apart + _SQUARE, count))
    ]


class _Search:
    """What all pairs of tiles have in common."""

    def __init__(
        self,
        axis: Axis,
        limit: float,
        limits: Callable[[], np.ndarray] | None,
        components: Components | None,
    ) -> None:
        self._axis, self._limit, self._limits = axis, limit, limits
        # Bounds begin behind the margin, where the first block does.
        size = axis.tiles(TILE) * TILE + axis.margin
        projected, longest = project(axis, size, TILE, components)
        self._bounds = jnp.asarray(projected[:, axis.margin :])
        self._slack = SLACK * longest
        self._features = lru_cache(maxsize=_TILES_KEPT)(partial(_features, axis))

    def found(self, first: int, second: int) -> Float[np.ndarray, "4 M"]:
        """Pairs of two tiles that may be minima, both ways round."""
        axis, limits = self._axis, self._limits() if self._limits else None
        of_rows, of_columns = (self._tile_limits(number, limits) for number in (first, second))
        inner = slice(axis.margin, axis.margin + TILE)
        places = jnp.int32(first * TILE), jnp.int32(second * TILE)
        both = jnp.asarray(np.stack([of_rows[inner], of_columns[inner]]), jnp.float32)
        opened = np.asarray(open_blocks(self._bounds, *places, both, tile=TILE))
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
        found = [self._compare(first, second, once, of_rows, of_columns)]
        found.append(found[0][[1, 0, 2, 3]])
        found.append(self._compare(first, second, twice, of_rows, of_columns))
        back = self._compare(first, second, twice, of_rows, of_columns, turned=True)
        found.append(back[[1, 0, 2, 3]])
        found.append(self._compare(first, second, still, of_rows, of_columns))
        return np.concatenate(found, axis=1)

    def _tile_limits(self, number: int, limits: np.ndarray | None) -> Float[np.ndarray, " T"]:
        """Of the entries of a tile with its margins, m²; 0 where no window begins."""
        size = TILE + 2 * self._axis.margin
        frames = self._axis.frames[number * TILE : number * TILE + size]
        known = np.full(len(frames), self._limit) if limits is None else limits[frames]
        return np.pad(np.where(frames >= 0, known, 0.0), (0, size - len(frames)))

    def _compare(
        self,
        first: int,
        second: int,
        chosen: np.ndarray,
        of_rows: np.ndarray,
        of_columns: np.ndarray,
        *,
        turned: bool = False,
    ) -> np.ndarray:
        """Pairs of the chosen blocks: as rows and columns, or as columns and rows. [4, M]"""
        reach = self._axis.margin
        blocks = np.stack(np.nonzero(chosen)).astype(np.int32)
        found = [np.zeros((4, 0))]
        a, b = self._features(first)[turned], self._features(second)[not turned]
        highest = [_highest(each, reach) for each in (of_rows, of_columns)]
        for begin in range(0, blocks.shape[1], _CHUNK):
            part = blocks[:, begin : begin + _CHUNK]
            padded = np.pad(part, ((0, 0), (0, _CHUNK - part.shape[1])))
            squared = _block_distances(
                a,
                b,
                jnp.asarray(padded),
                jnp.int32(part.shape[1]),
                window=self._axis.window,
                reach=reach,
            )
            below = np.maximum(highest[0][part[0]], highest[1][part[1]])
            block, r, c, judged, values = lowest(
                np.asarray(squared)[: part.shape[1]], reach, self._limit, self._slack, below
            )
            row = first * TILE + part[0, block] * BLOCK + r
            column = second * TILE + part[1, block] * BLOCK + c
            found.append(np.stack([row, column, judged, values]).astype(float))
        return np.concatenate(found, axis=1)


def _highest(limits: np.ndarray, reach: int) -> np.ndarray:
    """Of each block of a tile. [TILE / BLOCK]"""
    return limits[reach : reach + TILE].reshape(-1, BLOCK).max(axis=1)
