"""Windows as a few principal components each, and what those leave out.

With u the horizontal part of a window as complex numbers about its centre, and y its heights,

    D² = ‖u‖² + ‖u'‖² − 2 |⟨u, u'⟩| + ‖y − y'‖²,

since the best turn about the vertical only takes the phase out of the product. A projection P on
complex components commutes with that phase. With Q for heights, r = ‖u − Pu‖ and s = ‖y − Qy‖,

    | D² − (‖u‖² + ‖u'‖² + ‖y‖² + ‖y'‖² − 2 |⟨Pu, Pu'⟩| − 2 ⟨Qy, Qy'⟩) | ≤ 2 (r r' + s s').

Any orthonormal components do; principal ones of the motion itself leave little out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Complex, Float, Int

from mgjax.core.arrays import Array
from mgjax.graph.distances.axis import Axis
from mgjax.graph.distances.distance import WindowFeatures, window_basis

FLAT = 48
"""Complex components of the horizontal part."""
RISE = 40
"""Components of heights: feet and hands go up and down more abruptly than to the side."""

_SAMPLE = 1024
"""Windows from which the components are found."""
_POWERS, _SPARE = 3, 6
"""Powers of the covariance, and components more than are used, by which they are found."""
_ROUNDING = 1e-6
"""m². What float32 may have lost of a squared length."""
_CHUNK = 4096
"""Pairs whose components are copied at a time: what they take stays in the cache."""

Components = tuple[Float[np.ndarray, "2 V K"], Float[np.ndarray, "Y Q"], Float[np.ndarray, " Y"]]
"""Components of the horizontal part, real and imaginary; those of the heights; the mean of those.
In descending order of what they hold."""


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Parts:
    """Windows by their components.

    Attributes:
        flat: components of the horizontal part, m. [N, K]
        rise: those of the heights, about their mean, m. [N, Q]
        rest: lengths of what they leave out, of the horizontal part and of the heights, m. [N, 2]
        spread: squared length of the whole, m²; far larger where a window may not be used. [N]
    """

    flat: Complex[np.ndarray, "N K"]
    rise: Float[np.ndarray, "N Q"]
    rest: Float[np.ndarray, "N 2"]
    spread: Float[np.ndarray, " N"]


def parts_of(features: WindowFeatures, components: Components, window: int) -> Parts:
    """The windows of some features in all or in the first of the components."""
    found = _project(features, *components, window=window)
    real, imaginary, rise, rest, spread = (np.asarray(each) for each in found)
    flat = np.empty(real.shape, np.complex64)
    flat.real, flat.imag = real, imaginary
    return Parts(flat=flat, rise=rise, rest=rest, spread=spread)


def nearly(
    a: Parts, rows: Int[np.ndarray, " N"], b: Parts, columns: Int[np.ndarray, " N"]
) -> tuple[Float[np.ndarray, " N"], Float[np.ndarray, " N"]]:
    """D² of pairs of windows from their components, m², and by how much it may be wrong; what
    float32 loses comes on top of that."""
    squared, error = np.empty((2, len(rows)), np.float32)
    for first in range(0, len(rows), _CHUNK):
        part = slice(first, first + _CHUNK)
        r, c = rows[part], columns[part]
        aligned = np.abs(np.vecdot(a.flat[r], b.flat[c])) + np.vecdot(a.rise[r], b.rise[c])
        squared[part] = a.spread[r] + b.spread[c] - 2 * aligned
        error[part] = 2 * np.vecdot(a.rest[r], b.rest[c])
    return squared, error


@partial(jax.jit, static_argnames=("window",))
def _project(
    features: WindowFeatures,
    flat: Float[Array, "2 V K"],
    rise: Float[Array, "Y Q"],
    mean: Float[Array, " Y"],
    *,
    window: int,
) -> tuple[Array, Array, Array, Array, Array]:
    """The parts of :class:`Parts`, real and imaginary components apart."""
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
        for total, parts in ((whole, [real, imaginary]), (heights, [high]))
    ]
    left = jnp.stack([jnp.sqrt(jnp.maximum(rest, 0.0) + _ROUNDING) for rest in rests], axis=1)
    return real, imaginary, high, left, whole + heights
