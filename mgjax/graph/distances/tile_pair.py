"""Minima between the windows of two tiles.

What a bound leaves open is compared by components where it is little, pair by pair, and by blocks
where it is much. A pair of the other half of the matrix is judged with the masks of rows and
columns exchanged.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.bounds import FAR, open_counts, open_places
from mgjax.graph.distances.components import Parts, nearly
from mgjax.graph.distances.distance import (
    WindowFeatures,
    block_distances,
    rows_of,
)
from mgjax.graph.distances.judge import Doubts, exchanged, lowest, neighbours, settle, undecided
from mgjax.graph.distances.tile import Tile

BLOCK = 64
"""Side of the blocks all pairs of which are compared where many are open."""

_FEW = 150
"""Open pairs of a block up to which comparing them one by one takes less time."""

_CHUNK = 64
"""Most blocks that one call compares."""

Way = Literal["straight", "turned", "both"]
"""Pairs with the first tile as rows, with the second as rows, or both at once, which do not differ
where the same entries count as rows and as columns."""


@partial(jax.jit, static_argnames=("window", "reach"))
def _block_distances(
    a: WindowFeatures,
    b: WindowFeatures,
    numbers: Int[Array, "2 N"],
    below: tuple[Float[Array, " T"], Float[Array, " T"]],
    slack: Float[Array, ""],
    count: Array,
    *,
    window: int,
    reach: int,
) -> tuple[Float[Array, "N S S"], Bool[Array, "N B B"]]:
    """D² of the first ``count`` blocks of pairs with their margins, m², S = BLOCK + 2 reach; and
    which pairs may be below a limit and no higher than those next to them.

    Args:
        a, b: the tiles.
        numbers: of the blocks, by rows and by columns.
        below: what the entries of both tiles have to be below, without the margins, m²; the larger
            one holds.
        slack: by how much D² may be wrong, m².
        count: of blocks.
        window: frames in a window.
        reach: pairs on each side.
    """
    size = BLOCK + 2 * reach

    def measure(k: Array, out: Array) -> Array:
        rows = rows_of(a, numbers[0, k] * BLOCK, size, window)
        columns = rows_of(b, numbers[1, k] * BLOCK, size, window)
        squared = jnp.maximum(block_distances(rows, columns, window), 0.0)
        return jax.lax.dynamic_update_index_in_dim(out, squared, k, 0)

    def choose(k: Array, out: Array) -> Array:
        def moved(i: int, j: int) -> Array:
            return squared[k, reach + i : size - reach + i, reach + j : size - reach + j]

        rows, columns = (
            jax.lax.dynamic_slice_in_dim(limits, place * BLOCK, BLOCK)
            for limits, place in zip(below, numbers[:, k], strict=True)
        )
        low = moved(0, 0) - 2 * slack
        some = low + slack < jnp.maximum(rows[:, None], columns[None, :])
        for step in nearest:
            some &= low <= moved(*step)
        return jax.lax.dynamic_update_index_in_dim(out, some, k, 0)

    # In two loops: one that carries both results copies them.
    nearest = [step for step in neighbours(reach) if max(map(abs, step)) == 1]
    room = jnp.full((numbers.shape[1], size, size), FAR, jnp.float32)
    squared = jax.lax.fori_loop(0, count, measure, room)
    room = jnp.zeros((numbers.shape[1], BLOCK, BLOCK), bool)
    return squared, jax.lax.fori_loop(0, count, choose, room)


@dataclass(frozen=True, kw_only=True)
class TilePair:
    """Two tiles that are compared.

    Attributes:
        axis: of all clips.
        first, second: the tiles; the first no later than the second.
        ends: of the entries of both, what a pair has to be below, m²; the larger one holds.
        limit: of all pairs, m².
        slack: by how much float32 may be wrong about D², m².
    """

    axis: Axis
    first: Tile
    second: Tile
    ends: tuple[Float[np.ndarray, " S"], Float[np.ndarray, " S"]]
    limit: float
    slack: float

    def minima(self, bits: UInt8[np.ndarray, "R8 T"]) -> Float[np.ndarray, "3 M"]:
        """Minima among the open pairs, both ways round.

        Args:
            bits: of the pairs of entries, margins not counted, as
                :func:`mgjax.graph.distances.bounds.open_pairs` has them; of a tile with itself half
                of them.

        Returns:
            Rows, columns and D², m².
        """
        full = open_counts(bits, BLOCK) > _FEW
        rows, columns = open_places(np.where(_spread(full, bits.shape), np.uint8(0), bits))
        found = [np.zeros((3, 0))]
        for way, some in self._ways(full):
            if some.any():
                found += self._of_blocks(some, way)
        for way, some in self._ways_of_pairs(rows, columns):
            if some.size:
                found += self._of_pairs(some, way)
        return np.concatenate(found, axis=1)

    @property
    def _same(self) -> bool:
        return self.first.number == self.second.number

    @property
    def _places(self) -> tuple[int, int]:
        """Where the tiles begin, with their margins."""
        return self.first.number * self.first.size, self.second.number * self.second.size

    def _ways(self, chosen: Bool[np.ndarray, "B B"]) -> list[tuple[Way, Bool[np.ndarray, "B B"]]]:
        """Which blocks are searched in which ways."""
        alike = [tile.alike.reshape(-1, BLOCK).all(axis=1) for tile in (self.first, self.second)]
        both = alike[0][:, None] & alike[1][None, :]
        # A block on the diagonal has both halves in it already.
        still = np.eye(len(chosen), dtype=bool) & self._same
        twice = chosen & ~both & ~still
        ways: list[tuple[Way, np.ndarray]] = [("both", chosen & both & ~still)]
        return [*ways, ("straight", twice | (chosen & still)), ("turned", twice)]

    def _ways_of_pairs(
        self, rows: np.ndarray, columns: np.ndarray
    ) -> list[tuple[Way, Int[np.ndarray, "2 N"]]]:
        """Which pairs, of rows and columns of two tiles, are searched in which ways."""
        pairs = np.stack([rows, columns])
        same = (rows == columns) & self._same
        alike = self.first.alike, self.second.alike
        both = alike[0][rows] & alike[1][columns] & ~same
        ways: list[tuple[Way, np.ndarray]] = [("both", both), ("straight", ~both)]
        return [(way, pairs[:, some]) for way, some in [*ways, ("turned", ~both & ~same)]]

    def _of_blocks(self, chosen: np.ndarray, way: Way) -> list[np.ndarray]:
        """Minima of blocks, all pairs of which are compared."""
        reach, turned = self.axis.margin, way == "turned"
        blocks = np.stack(np.nonzero(chosen)).astype(np.int32)
        found: list[np.ndarray] = []
        a, b = self.first.features[turned], self.second.features[not turned]
        inner = slice(reach, reach + self.first.size)
        below = tuple(jnp.asarray(each[inner], jnp.float32) for each in self.ends)
        for begin in range(0, blocks.shape[1], _CHUNK):
            part = blocks[:, begin : begin + _CHUNK]
            padded = np.pad(part, ((0, 0), (0, _CHUNK - part.shape[1])))
            squared, some = _block_distances(
                a,
                b,
                jnp.asarray(padded),
                below,
                jnp.float32(self.slack),
                jnp.int32(part.shape[1]),
                window=self.axis.window,
                reach=reach,
            )
            block, r, c, doubts = lowest(np.asarray(squared), np.asarray(some), reach, self.slack)
            row = self._places[0] + part[0, block] * BLOCK + r
            column = self._places[1] + part[1, block] * BLOCK + c
            found += self._minima(row, column, doubts, way)
        return found

    def _of_pairs(self, pairs: Int[np.ndarray, "2 N"], way: Way) -> list[np.ndarray]:
        """Minima among single pairs."""
        reach, turned = self.axis.margin, way == "turned"
        a, b = self.first.parts[turned], self.second.parts[not turned]
        r, c = pairs + reach
        squared, error = self._nearly(a, r, b, c)
        near = np.flatnonzero(squared - error < np.maximum(self.ends[0][r], self.ends[1][c]))
        r, c = r[near], c[near]

        def around(left: np.ndarray, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
            return self._nearly(a, r[left] + i, b, c[left] + j)

        left, doubts = undecided(squared[near], error[near], around, reach)
        return self._minima(self._places[0] + r[left], self._places[1] + c[left], doubts, way)

    def _nearly(
        self, a: Parts, rows: np.ndarray, b: Parts, columns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        squared, error = nearly(a, rows, b, columns)
        return squared, error + np.float32(self.slack)

    def _minima(
        self, rows: np.ndarray, columns: np.ndarray, doubts: Doubts, way: Way
    ) -> list[np.ndarray]:
        """Those of some pairs of entries that are minima: as they are, exchanged, or both."""
        if way == "turned":
            rows, columns, doubts = columns, rows, exchanged(doubts, self.axis.margin)
        squared, lowest_ = settle(self.axis, rows, columns, self.limit, doubts)
        found = [np.stack([rows, columns, squared])[:, lowest_[0]]]
        if way == "both":
            found.append(np.stack([columns, rows, squared])[:, lowest_[1]])
        return found


def _spread(blocks: Bool[np.ndarray, "B B"], shape: tuple[int, ...]) -> Bool[np.ndarray, "R8 T"]:
    """What holds of blocks, of each number of bits in them."""
    rows, columns = (size // len(blocks) for size in shape)
    return np.repeat(np.repeat(blocks, rows, axis=0), columns, axis=1)
