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
