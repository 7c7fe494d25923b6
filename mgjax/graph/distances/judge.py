"""Which pairs are lowest in their neighbourhood: as float32 sees it, and where it cannot tell."""

from __future__ import annotations


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
    squared: Float[Array, " P"],
    columns: int,
    limit: Float[Array, ""],
    slack: Float[Array, ""],
    reach: int,
) -> UInt8[Array, " P"]:
    """Whether pairs are local minima below ``limit``: ``NO``, ``MAYBE`` or ``SURE``.

    Args:
        squared: D² row by row, beyond the limit where a pair is not allowed. In one line, for a neighbour
            is then a shift of all of it; of slices of short rows the compiler makes slow code.
        columns: in a row.
        limit: m².
        slack: values nearer to each other than this may be in either order, m².
        reach: pairs so many rows and columns away are compared. What is nearer to the border than
            this is judged by what happens to lie there, and means nothing.
    """
    first = reach * (columns + 1)
    size = squared.shape[0] - 2 * first
    around = None
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            if (i, j) != (0, 0):
                start = first + i * columns + j
                other = squared[start : start + size]
                around = other if around is None else jnp.minimum(around, other)
    centre = squared[first : first + size]
    maybe = (centre - slack <= around) & (centre < limit + slack)
    sure = maybe & (centre + slack < around) & (centre < limit - slack)
    return jnp.pad(maybe.astype(jnp.uint8) + sure.astype(jnp.uint8), first)


def settle(
    axis: Axis, rows: Int[np.ndarray, " N"], columns: Int[np.ndarray, " N"], limit: float
) -> Float[np.ndarray, " N"]:
    """D² of the allowed pairs that are local minima below ``limit``, exactly, m²; others infinite.

    A tie goes to the lowest (row, column).
    """
    reach = axis.margin
    # A window and itself are at distance 0, as are those before them: no need to look closer.
    led = (rows == columns) & axis.leave[rows - 1] & axis.arrive[columns - 1]
    centre = np.full(len(rows), np.inf)
    centre[~led] = exact_squared(axis, rows[~led], columns[~led])
    kept = np.flatnonzero(centre < limit)
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            if (i, j) == (0, 0) or not len(kept):
                continue
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
