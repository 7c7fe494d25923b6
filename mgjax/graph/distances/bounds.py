"""Lower bounds of the distance of all windows to all others, from the first few components of each
(:mod:`mgjax.graph.distances.components`):

    D² ≥ ‖u‖² + ‖u'‖² + ‖y‖² + ‖y'‖² − 2 |⟨Pu, Pu'⟩| − 2 ⟨Qy, Qy'⟩ − 2 (r r' + s s').
"""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from mgjax.core.arrays import Array
from mgjax.graph.distances.components import Parts

FLAT = 6
"""Complex components of the horizontal part."""
RISE = 4
"""Components of heights."""
ROWS = 2 * FLAT + RISE + 3

TOGETHER = 8
"""Rows that one piece of code compares at once: their columns are then read once."""

_CLEAR = 1e-5
"""m². Added to the limit for the rounding of the bound itself."""
FAR = 1e6
"""m². Squared length of what may not be used: it is near nothing."""


def bound_rows(parts: Parts, used: Bool[np.ndarray, " N"]) -> Float[np.ndarray, "C N"]:
    """What the bounds need of windows, those that are ``used``: FLAT real and FLAT imaginary
    components, RISE of heights, the lengths of the two rests, the squared length of the whole."""
    flat, rise = parts.flat[:, :FLAT], parts.rise[:, :RISE]
    left = [np.abs(parts.flat[:, FLAT:]), parts.rise[:, RISE:]]
    beyond = np.stack([np.vecdot(each, each) for each in left], axis=1)
    rest = np.sqrt(parts.rest**2 + beyond)
    spread = np.where(used, parts.spread, np.float32(FAR))[:, None]
    return np.concatenate([np.real(flat), np.imag(flat), rise, rest, spread], axis=1).T


@partial(jax.jit, static_argnames=("tile",))
def open_pairs(
    rows: Float[Array, "C R"],
    first: Array,
    second: Array,
    limits: Float[Array, "2 T"],
    *,
    tile: int,
) -> UInt8[Array, "R8 T"]:
    """Which pairs may have a distance below a limit: one bit each, the lowest of a number that of
    the first of ``TOGETHER`` rows.

    Args:
        rows: of :func:`bound_rows`.
        first, second: where the rows and the columns of the tile of pairs begin.
        limits: of the entries of its rows and of those of its columns, m². The larger one holds.
        tile: its side, a multiple of ``TOGETHER``.
    """
    a, b = (jax.lax.dynamic_slice_in_dim(rows, start, tile, axis=1) for start in (first, second))
    columns = [each[None, :] for each in b]
    of_rows, of_columns = limits + _CLEAR
    bits = jnp.zeros((tile // TOGETHER, tile), jnp.uint8)
    for k in range(TOGETHER):
        limit = jnp.maximum(of_rows[k::TOGETHER, None], of_columns[None, :])
        below = _below([each[k::TOGETHER, None] for each in a], columns, limit)
        bits = bits | jnp.where(below, jnp.uint8(1 << k), jnp.uint8(0))
    return bits


def _below(a: list[Array], b: list[Array], limit: Array) -> Array:
    """Whether the bound of D² is below the limit: with g what it would be without |⟨Pu, Pu'⟩|,
    g < limit + 2 |⟨Pu, Pu'⟩|."""

    def product(x: list[Array], y: list[Array]) -> Array:
        return sum((p * q for p, q in zip(x[1:], y[1:], strict=True)), x[0] * y[0])

    real, imaginary, rest = slice(0, FLAT), slice(FLAT, 2 * FLAT), slice(2 * FLAT, -1)
    cosine = product(a[real], b[real]) + product(a[imaginary], b[imaginary])
    sine = product(a[real], b[imaginary]) - product(a[imaginary], b[real])
    beyond = a[-1] + b[-1] - limit - 2 * product(a[rest], b[rest])
    return (beyond < 0) | (beyond * beyond < 4 * (cosine * cosine + sine * sine))


def open_places(bits: UInt8[np.ndarray, "R8 T"]) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the pairs that :func:`open_pairs` says."""
    some = np.flatnonzero(bits != 0)
    values = bits.reshape(-1)[some]
    row, column = np.divmod(some, bits.shape[1])
    rows, columns = [], []
    for k in range(TOGETHER):
        here = (values >> k) & 1 != 0
        rows.append(row[here] * TOGETHER + k)
        columns.append(column[here])
    return np.concatenate(rows), np.concatenate(columns)


def open_counts(bits: UInt8[np.ndarray, "R8 T"], side: int) -> Int[np.ndarray, "B B"]:
    """How many pairs of each block of ``side`` × ``side`` are open."""
    count = bits.shape[1] // side
    ones = np.bitwise_count(bits).reshape(count, side // TOGETHER, count, side)
    return ones.sum(axis=(1, 3), dtype=np.int64)


def upper_half(bits: UInt8[np.ndarray, "R8 T"]) -> UInt8[np.ndarray, "R8 T"]:
    """Of pairs of a tile with itself those whose row is no later than their column."""
    rows = np.arange(bits.shape[0])[:, None] * TOGETHER
    columns = np.arange(bits.shape[1])[None, :]
    kept = np.clip(columns - rows + 1, 0, TOGETHER)  # rows of a number up to the column
    return bits & ((1 << kept) - 1).astype(np.uint8)
