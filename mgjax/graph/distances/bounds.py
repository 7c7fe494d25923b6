"""Lower bounds of the distance of all windows to all others, from the first few components of each
(:mod:`mgjax.graph.distances.components`):

    D² ≥ ‖u‖² + ‖u'‖² + ‖y‖² + ‖y'‖² − 2 |⟨Pu, Pu'⟩| − 2 ⟨Qy, Qy'⟩ − 2 (r r' + s s').
"""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, UInt8

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.components import Components, parts_of, principal

FLAT = 6
"""Complex components of the horizontal part."""
RISE = 4
"""Components of heights."""
ROWS = 2 * FLAT + RISE + 3

TOGETHER = 8
"""Rows that one piece of code compares at once: their columns are then read once."""

_CLEAR = 1e-5
"""m². Added to the limit for the rounding of the bound itself."""
_NEVER = 1e6
"""m². Squared length of what is no window: it is near nothing."""


def project(
    axis: Axis, size: int, tile: int, components: Components | None = None
) -> tuple[Float[np.ndarray, "C R"], float, Components]:
    """What the bounds need of each entry of an axis.

    Args:
        axis: of all clips.
        size: entries, with room for the last tile.
        tile: entries that are projected together.
        components: None: those of the axis itself.

    Returns:
        The rows of :func:`open_pairs`, the squared length of the longest window, m², and the
        components.
    """
    components = principal(axis) if components is None else components
    few = components[0][..., :FLAT], components[1][:, :RISE], components[2]
    rows = np.zeros((ROWS, size), np.float32)
    rows[-1] = _NEVER
    longest = 0.0
    for first in range(0, len(axis), tile):
        valid = np.flatnonzero(axis.valid[first : first + tile])
        features = axis.features(first, tile)
        parts = parts_of(features, few, axis.window)
        longest = max(longest, float(np.asarray(features.spread)[valid].max(initial=0.0)))
        flat = [np.real(parts.flat), np.imag(parts.flat)]
        columns = [*flat, parts.rise, parts.rest, parts.spread[:, None]]
        rows[:, first + valid] = np.concatenate(columns, axis=1)[valid].T
    return rows, longest, components


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
        rows: of :func:`project`: FLAT real and FLAT imaginary components, RISE of heights, the two
            rests, and the squared length of the whole.
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
