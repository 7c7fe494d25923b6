"""Which pairs are lowest in their neighbourhood: as float32 sees it, and where it cannot tell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.exact import exact_squared

SLACK = 2e-6
"""Share of the squared length of the longest window by which float32 may be wrong about D²: twice
what was found on capture."""

NO, MAYBE, SURE = 0, 1, 2

Doubts = Sequence[np.ndarray]
"""For each neighbour of a minimum the numbers of the pairs that it may be lower than."""

Around = Callable[[np.ndarray, int, int], tuple[np.ndarray, np.ndarray]]
"""D² of the neighbours, some rows and columns away, of some pairs; and by how much it may be wrong,
m²."""


def judge(
    centre: Float[Array, "*n"],
    others: Sequence[Float[Array, "*n"]],
    limit: Float[Array, ""],
    slack: Float[Array, ""],
) -> UInt8[Array, "*n"]:
    """Whether pairs are local minima below ``limit``: ``NO``, ``MAYBE`` or ``SURE``.

    Args:
        centre: D², beyond the limit where a pair is not allowed, m².
        others: D² of their neighbours.
        limit: m².
        slack: values nearer to each other than this may be in either order, m².
    """
    around = reduce(jnp.minimum, others)
    maybe = (centre - slack <= around) & (centre < limit + slack)
    sure = maybe & (centre + slack < around) & (centre < limit - slack)
    return maybe.astype(jnp.uint8) + sure.astype(jnp.uint8)


def undecided(
    centre: Float[np.ndarray, " N"],
    error: Float[np.ndarray, " N"],
    around: Around,
    reach: int,
) -> tuple[Int[np.ndarray, " M"], Doubts]:
    """Which pairs may be the lowest of their neighbourhood, and what is not known of them.

    Args:
        centre: D² of each, m².
        error: by how much it may be wrong, m².
        around: the same of a neighbour of some of them.
        reach: pairs on each side that a minimum is compared with.

    Returns:
        Their numbers, and for each of :func:`neighbours` which of these may have a lower one there.
    """
    steps = neighbours(reach)
    left = np.arange(len(centre))
    open_: list[np.ndarray] = [left] * len(steps)
    # Across the diagonal distances change the most.
    for number in sorted(range(len(steps)), key=lambda k: -abs(steps[k][0] - steps[k][1])):
        other, wrong = around(left, *steps[number])
        kept = centre[left] - error[left] <= other + wrong
        left, other, wrong = left[kept], other[kept], wrong[kept]
        open_[number] = left[centre[left] + error[left] >= other - wrong]
    place = np.full(len(centre), -1)
    place[left] = np.arange(len(left))
    return left, [each[each >= 0] for each in (place[some] for some in open_)]


def lowest(
    squared: Float[np.ndarray, "K S S"],
    some: Bool[np.ndarray, "K B B"],
    reach: int,
    slack: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Doubts]:
    """Pairs of some blocks that may be lowest in their neighbourhood.

    Args:
        squared: D² of blocks with margins of ``reach`` pairs, m².
        some: which pairs, without the margins, are looked at.
        reach: pairs on each side that a minimum is compared with.
        slack: by how much D² may be wrong, m².

    Returns:
        Block, row and column (margins counted) of each, [M], and the doubts.
    """
    side = squared.shape[-1]
    block, row, column = np.unravel_index(np.flatnonzero(some), some.shape)
    flat = squared.reshape(-1)
    place = (block * side + row + reach) * side + column + reach

    def around(left: np.ndarray, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        return flat[place[left] + i * side + j], error[left]

    error = np.full(len(place), slack, np.float32)
    left, doubts = undecided(flat[place], error, around, reach)
    block, row, column = np.unravel_index(place[left], squared.shape)
    return block, row, column, doubts


def neighbours(reach: int) -> list[tuple[int, int]]:
    """Rows and columns from a pair to each of those it is compared with."""
    steps = range(-reach, reach + 1)
    return [(i, j) for i in steps for j in steps if (i, j) != (0, 0)]


def exchanged(doubts: Doubts, reach: int) -> Doubts:
    """Those of the same pairs with rows and columns exchanged."""
    steps = neighbours(reach)
    numbers = {step: number for number, step in enumerate(steps)}
    return [doubts[numbers[j, i]] for i, j in steps]


def settle(
    axis: Axis,
    rows: Int[np.ndarray, " N"],
    columns: Int[np.ndarray, " N"],
    limit: float,
    doubts: Doubts | None = None,
) -> tuple[Float[np.ndarray, " N"], Bool[np.ndarray, "2 N"]]:
    """D² of allowed pairs exactly, m², and which of them are local minima below ``limit``: as they
    are, and with rows and columns exchanged if the masks of both are the same there.

    A tie goes to the lowest (row, column).

    Args:
        axis: of all clips.
        rows, columns: entries of the axis.
        limit: m².
        doubts: for each of :func:`neighbours` the pairs of which it is not known that they are
            lower; None: of all.
    """
    steps = neighbours(axis.margin)
    open_ = [np.arange(len(rows))] * len(steps) if doubts is None else doubts
    # A window and itself are at distance 0, as are those before them: no need to look closer.
    led = np.zeros(len(rows), bool)
    led[open_[steps.index((-1, -1))]] = True
    led &= (rows == columns) & axis.leave[rows - 1] & axis.arrive[columns - 1]
    centre = np.full(len(rows), np.inf)
    centre[~led] = exact_squared(axis, rows[~led], columns[~led])
    lowest_ = np.tile(centre < limit, (2, 1))
    for (i, j), some in zip(steps, open_, strict=True):
        some = some[lowest_[:, some].any(axis=0)]
        r, c = rows[some] + i, columns[some] + j
        allowed = axis.leave[r] & axis.arrive[c]
        some = some[allowed]
        other, own = exact_squared(axis, r[allowed], c[allowed]), centre[some]
        for half, before in enumerate(((i, j) < (0, 0), (j, i) < (0, 0))):
            lowest_[half, some] &= other > own if before else other >= own
    return centre, lowest_
