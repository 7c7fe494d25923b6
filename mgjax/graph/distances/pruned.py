"""The same minima from a part of the pairs: those that a bound tells to be far are left out.

Half of the matrix is enough, since it is symmetric.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache, partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, UInt8

from mgjax.core.parallel.run import run_all
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.bounds import open_pairs, upper_half
from mgjax.graph.distances.components import Components, principal
from mgjax.graph.distances.judge import SLACK
from mgjax.graph.distances.tile import Tile
from mgjax.graph.distances.tile_pair import TilePair

TILE = 2048
"""Side of the tiles whose pairs are bounded together; a multiple of the blocks' side."""

_SQUARE = 64
"""Tiles on each side whose pairs are searched one after the other."""

_TILES_KEPT = 2 * _SQUARE + 2
"""Tiles of which is kept what is known; of more it is computed anew."""

_MANY = 1 / 64
"""Share of open pairs from which two tiles are searched near by first."""

_NEAR = 1 / 4
"""Of the limit (m²): near by."""


def search_pruned(
    axis: Axis,
    limit: float,
    pairs: Sequence[tuple[int, int]],
    *,
    limits: Callable[[], Float[np.ndarray, " F"]] | Float[np.ndarray, " F"] | None = None,
    threads: int | None = None,
    components: Components | None = None,
) -> Iterator[tuple[Float[np.ndarray, "3 M"], bool]]:
    """All local minima, one pair of tiles after the other.

    Where limits may go down and many pairs are open, those near by are looked for first, and the
    others later, when most of them need not be looked for any more.

    Args:
        axis: of all clips.
        limit: m², finite.
        pairs: of tiles that are searched, the first no later than the second.
        limits: what a pair has to be below by the frame that its row begins at, m², no more than
            ``limit``. If it may go down, a function that is asked before each pair of tiles. None:
            ``limit``.
        threads: tiles that are searched at the same time; None: as many as there are processors.
        components: of the bounds; None: those of the axis itself.

    Yields:
        Rows, columns and D², m², of the minima, both ways round. Some above their ``limits`` may be
        among them. And whether it is done with these tiles.
    """
    search = _Search(axis, limit, components)
    # Of the thread that asks, for those of the pool.
    device = jax.config.jax_default_device  # pyright: ignore[reportAttributeAccessIssue]
    everywhere = np.full(len(axis.positions), limit)

    def searched(
        pair: tuple[int, int], near: float | None, before: float
    ) -> tuple[np.ndarray, bool]:
        below = limits() if callable(limits) else everywhere if limits is None else limits
        with jax.default_device(device):
            return search.found(*pair, np.where(below <= before, 0.0, below), near)

    near = _NEAR * limit
    steps = ((near, 0.0), (None, near)) if callable(limits) else ((None, 0.0),)
    count = threads or os.cpu_count() or 1
    with ThreadPoolExecutor(count) as pool:
        for until, before in steps:
            later = []
            there = partial(searched, near=until, before=before)
            for number, (found, whole) in run_all(pool, there, pairs, ahead=2 * count):
                if not whole:
                    later.append(pairs[number])
                yield found, whole
            pairs = later


def tile_pairs(axis: Axis) -> list[tuple[int, int]]:
    """All pairs of tiles, the first no later than the second: squares of ``_SQUARE`` tiles whose
    features are kept, those near the diagonal first, and in them likewise, so that all rows meet
    many others early."""
    count = axis.tiles(TILE)
    return [
        (first, first + step)
        for apart in range(0, count, _SQUARE)
        for i in range(0, count - apart, _SQUARE)
        for step in range(max(apart - _SQUARE + 1, 0), apart + _SQUARE)
        for first in range(
            max(i, i + apart - step), min(i + _SQUARE, i + apart + _SQUARE - step, count - step)
        )
    ]


class _Search:
    """What all pairs of tiles have in common."""

    def __init__(self, axis: Axis, limit: float, components: Components | None) -> None:
        self._axis, self._limit = axis, limit
        found = principal(axis) if components is None else components
        self._tile = lru_cache(maxsize=_TILES_KEPT)(
            lambda number: Tile(axis=axis, number=number, size=TILE, components=found)
        )
        rows, longest = [], 0.0
        for number in range(axis.tiles(TILE)):
            tile = self._tile(number)
            rows.append(tile.bound_rows)
            longest = max(longest, tile.longest)
        self._bounds = jnp.asarray(np.concatenate(rows, axis=1))
        self._slack = SLACK * longest

    def found(
        self, first: int, second: int, limits: Float[np.ndarray, " F"], near: float | None
    ) -> tuple[Float[np.ndarray, "3 M"], bool]:
        """Minima of two tiles, both ways round, below ``limits``; where many pairs are open below
        ``near`` only. And whether those are all."""
        tiles = self._tile(first), self._tile(second)
        bits, ends = self._open(*tiles, limits)
        whole = True
        if near is not None and np.bitwise_count(bits).sum() > _MANY * TILE**2:
            whole = False
            bits, ends = self._open(*tiles, np.minimum(limits, near))
        pair = TilePair(
            axis=self._axis,
            first=tiles[0],
            second=tiles[1],
            ends=ends,
            limit=self._limit,
            slack=self._slack,
        )
        return pair.minima(bits), whole

    def _open(
        self, first: Tile, second: Tile, limits: Float[np.ndarray, " F"]
    ) -> tuple[UInt8[np.ndarray, "R8 T"], tuple[np.ndarray, np.ndarray]]:
        """Pairs that bounds leave open, half of those of a tile with itself; and what the entries
        of both tiles have to be below."""
        ends = first.limits(limits), second.limits(limits)
        inner = slice(self._axis.margin, self._axis.margin + TILE)
        places = jnp.int32(first.number * TILE), jnp.int32(second.number * TILE)
        both = jnp.asarray(np.stack([each[inner] for each in ends]), jnp.float32)
        bits = np.asarray(open_pairs(self._bounds, *places, both, tile=TILE))
        return upper_half(bits) if first.number == second.number else bits, ends
