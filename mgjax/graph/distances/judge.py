"""Which pairs are lowest in their neighbourhood: as float32 sees it, and where it cannot tell."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int, UInt8

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.exact import exact_squared

SLACK = 2e-6
"""Share of the squared length of the longest window by which float32 may be wrong about D²: twice
what was found on capture."""

NO, MAYBE, SURE = 0, 1, 2


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


def lowest(
    squared: Float[np.ndarray, "K S S"],
    reach: int,
    limit: float,
    slack: float,
    below: Float[np.ndarray, " K"],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What :func:`judge` says of the pairs of some blocks that it does not call ``NO``.

    Few pairs are left after two neighbours, so those are looked at one by one, on the host.

    Args:
        squared: D² of blocks with margins of ``reach`` pairs, m².
        reach: pairs on each side that a minimum is compared with.
        limit, slack: as there.
        below: of each block, no more than ``limit``, m²: others than those below are not looked
            for.

    Returns:
        Block, row and column (margins counted), judgement and D² of each, m². 5 × [M]
    """
    side = squared.shape[-1]
    # Across the diagonal distances change the most.
    first, second, *others = sorted(neighbours(reach), key=lambda step: -abs(step[0] - step[1]))

    def moved(i: int, j: int) -> np.ndarray:
        return squared[:, reach + i : side - reach + i, reach + j : side - reach + j]

    low = moved(0, 0) - np.float32(slack)
    some = low < below.astype(np.float32)[:, None, None]
    for step in (first, second):
        some &= low <= moved(*step)
    block, row, column = np.unravel_index(np.flatnonzero(some), some.shape)
    flat = squared.reshape(-1)
    place = (block * side + row + reach) * side + column + reach
    centre = flat[place]
    sure = centre < np.float32(limit - slack)
    for i, j in (first, second, *others):
        other = flat[place + i * side + j]
        kept = centre - np.float32(slack) <= other
        sure = (sure & (centre + np.float32(slack) < other))[kept]
        place, centre = place[kept], centre[kept]
    block, row, column = np.unravel_index(place, squared.shape)
    return block, row, column, np.where(sure, SURE, MAYBE), centre


def neighbours(reach: int) -> list[tuple[int, int]]:
    """Rows and columns from a pair to each of those it is compared with."""
    steps = range(-reach, reach + 1)
    return [(i, j) for i in steps for j in steps if (i, j) != (0, 0)]


def settle(
    axis: Axis, rows: Int[np.ndarray, " N"], columns: Int[np.ndarray, " N"], limit: float
) -> Float[np.ndarray, " N"]:
    """D² of the allowed pairs that are local minima below ``limit``, exactly, m²; others infinite.

    A tie goes to the lowest (row, column).
    """
    # A window and itself are at distance 0, as are those before them: no need to look closer.
    led = (rows == columns) & axis.leave[rows - 1] & axis.arrive[columns - 1]
    centre = np.full(len(rows), np.inf)
    centre[~led] = exact_squared(axis, rows[~led], columns[~led])
    kept = np.flatnonzero(centre < limit)
    for i, j in neighbours(axis.margin):
        r, c = rows[kept] + i, columns[kept] + j
        lost = np.zeros(len(kept), bool)
        allowed = axis.leave[r] & axis.arrive[c]
        other = exact_squared(axis, r[allowed], c[allowed])
        own = centre[kept[allowed]]
        lost[allowed] = other <= own if (i, j) < (0, 0) else other < own
        kept = kept[~lost]
    out = np.full(len(rows), np.inf)
    out[kept] = centre[kept]
    return out
