"""Lower bounds of the distance of windows, from a few components of each.

With u the horizontal part of a window as complex numbers about its centre, and y its heights,

    D² = ‖u‖² + ‖u'‖² − 2 |⟨u, u'⟩| + ‖y − y'‖²,

since the best turn about the vertical only takes the phase out of the product. A projection P on a
few complex components commutes with that phase, so with r = ‖u − Pu‖, and for heights with Q and s,

    |⟨u, u'⟩| ≤ |⟨Pu, Pu'⟩| + r r',        ‖y − y'‖² ≥ ‖Qy − Qy'‖² + (s − s')².

Any orthonormal components give a bound; principal ones of the motion itself give a close one.
"""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.distance import WindowFeatures, window_basis

FLAT = 6
"""Complex components of the horizontal part."""
RISE = 4
"""Components of heights."""
ROWS = 2 * FLAT + RISE + 3

_SAMPLE = 1024
"""Windows from which the components are found."""
_POWERS, _SPARE = 3, 6
"""Powers of the covariance, and components more than are used, by which they are found."""
_ROUNDING = 1e-6
"""m². What float32 may have lost of a squared length."""
_CLEAR = 1e-5
"""m². Added to the limit for the rounding of the bound itself."""
_UNROLLED = 4
"""Rows that one piece of code compares at once: their columns are then read once."""
_NEVER = 1e6
"""m². Squared length of what is no window: it is near nothing."""
BLOCK = 64
"""Side of the blocks of pairs that are opened or not."""


Components = tuple[Float[np.ndarray, "2 V K"], Float[np.ndarray, "Y Q"], Float[np.ndarray, " Y"]]
"""Components of the horizontal part, real and imaginary; those of the heights; the mean of those.
Bounds hold with any, and are close with those of motion that is alike."""


def project(
    axis: Axis, size: int, tile: int, components: Components | None = None
) -> tuple[Float[np.ndarray, "C R"], float]:
    """What the bounds need of each entry of an axis.

    Args:
        axis: of all clips.
        size: entries, with room for the last tile.
        tile: entries that are projected together.
        components: None: those of the axis itself.

    Returns:
        The rows of :func:`open_blocks`, and the squared length of the longest window, m².
    """
    flat, rise, mean = principal(axis) if components is None else components
    rows = np.zeros((ROWS, size), np.float32)
    rows[-1] = _NEVER
    longest = 0.0
    for first in range(0, len(axis), tile):
        valid = axis.valid[first : first + tile]
        features = axis.features(first, tile)
        part = np.asarray(_project(features, flat, rise, mean, window=axis.window))
        part = part[:, : len(valid)]
        spread = np.asarray(features.spread)[: len(valid)]
        longest = max(longest, float(spread.max(where=valid, initial=0.0)))
        rows[:, first : first + tile][:, : len(valid)] = np.where(
            valid, part, rows[:, first : first + len(valid)]
        )
    return rows, longest


def principal(axis: Axis) -> Components:
    """Principal components of a sample of the windows."""
    starts = np.flatnonzero(axis.valid)
    starts = starts[:: max(1, -(-len(starts) // _SAMPLE))]
    windows = axis.positions[axis.frames[starts][:, None] + np.arange(axis.window)]
    windows = windows - np.array([axis.centre[0], 0, axis.centre[2]], np.float32)
    share = axis.weights / axis.window
    root = np.sqrt(share)
    flat = windows[..., 0] + np.complex64(1j) * windows[..., 2]
    # As the features have it: each frame about its own centre, then the centres of the frames.
    centres = flat @ axis.weights
    about = ((flat - centres[..., None]) * root).reshape(len(starts), -1)
    level = ((windows[..., 1] - axis.centre[1]) * root).reshape(len(starts), -1)
    basis = window_basis(axis.window) / np.sqrt(axis.window)
    whole = np.concatenate([about, centres @ basis], axis=1)
    mean = level.mean(axis=0)
    lead = _leading(whole, FLAT)
    return (
        np.stack([np.real(lead), np.imag(lead)]).astype(np.float32),
        _leading(level - mean, RISE).astype(np.float32),
        mean.astype(np.float32),
    )


def _leading(vectors: np.ndarray, count: int) -> np.ndarray:
    """Orthonormal components [V, K] that hold most of vectors [N, V], by a few powers of their
    covariance; 0 beyond as many as exist."""
    size = vectors.shape[1]
    kept = min(count, size)
    covariance = vectors.conj().T @ vectors
    components = np.random.default_rng(0).normal(size=(size, min(size, count + _SPARE)))
    for _ in range(_POWERS):
        components = np.linalg.qr(covariance @ components)[0]
    values, turned = np.linalg.eigh(components.conj().T @ covariance @ components)
    best = components @ turned[:, np.argsort(-values)[:kept]]
    return np.pad(best, ((0, 0), (0, count - kept)))


@partial(jax.jit, static_argnames=("window",))
def _project(
    features: WindowFeatures,
    flat: Float[Array, "2 V K"],
    rise: Float[Array, "Y Q"],
    mean: Float[Array, " Y"],
    *,
    window: int,
) -> Float[Array, "C R"]:
    count = features.spread.shape[0]

    def slide(values: Array) -> Array:
        frames = jnp.stack([values[k : k + count] for k in range(window)], axis=1)
        return frames.reshape(count, -1) / np.float32(np.sqrt(window))

    x, z = (
        jnp.concatenate([slide(about), path], axis=1)
        for about, path in zip(
            jnp.split(features.xz, 2, axis=1), jnp.split(features.path, 2, axis=1), strict=True
        )
    )
    y = slide(features.y) - mean[None]
    real, imaginary = x @ flat[0] - z @ flat[1], x @ flat[1] + z @ flat[0]
    high = y @ rise
    whole, heights = (x * x + z * z).sum(axis=1), (y * y).sum(axis=1)
    rests = [
        total - sum((part * part).sum(axis=1) for part in parts)
        for total, parts in ((heights, [high]), (whole, [real, imaginary]))
    ]
    left = [jnp.sqrt(jnp.maximum(rest, 0.0) + _ROUNDING)[:, None] for rest in rests]
    return jnp.concatenate([real, imaginary, high, *left, (whole + heights)[:, None]], axis=1).T


@partial(jax.jit, static_argnames=("tile",))
def open_blocks(
    rows: Float[Array, "C R"],
    first: Array,
    second: Array,
    limits: Float[Array, "2 T"],
    *,
    tile: int,
) -> Bool[Array, "B B"]:
    """Which blocks of ``BLOCK`` × ``BLOCK`` pairs may have a distance below a limit.

    Args:
        rows: of :func:`project`: FLAT real and FLAT imaginary components, RISE of heights, the two
            rests, and the squared length of the whole.
        first, second: where the rows and the columns of the tile of pairs begin.
        limits: of the entries of its rows and of those of its columns, m². The larger one holds.
        tile: its side, a multiple of BLOCK.
    """
    a, b = (jax.lax.dynamic_slice_in_dim(rows, start, tile, axis=1) for start in (first, second))
    columns = [each[None, :] for each in b]
    of_rows, of_columns = limits + _CLEAR
    some = None
    for k in range(_UNROLLED):
        limit = jnp.maximum(of_rows[k::_UNROLLED, None], of_columns[None, :])
        below = _below([each[k::_UNROLLED, None] for each in a], columns, limit)
        some = below if some is None else some | below
    assert some is not None
    side, count = BLOCK // _UNROLLED, tile // BLOCK
    return jax.lax.optimization_barrier(some).reshape(count, side, count, BLOCK).any(axis=(1, 3))


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
