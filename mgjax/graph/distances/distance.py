"""Distance of two windows of motion (hybrid paper eq. 1, after Kovar, Gleicher and Pighin 2002).

D² is the weighted mean squared distance of two clouds of joints, minimised over a planar transform
of the second. Everything it needs are sums over a window of products of single frames, so it is
computed as matrix products over joints, followed by sums along diagonals (by doubling: 1, 2, 4, 8
frames and the remainder). The cloud of all windows is never built.

Each frame is taken relative to its own centre on the floor. The part of the centres themselves is
a product of windows about their mean, on a basis of which smooth motion needs few components. So
nothing large is subtracted from something large, and float32 holds to about 1e-6 m², wherever on
the floor the clips are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.core.arrays import Array
from mgjax.core.errors import ConfigError
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.core.xla.pytree import register

ROW_BLOCK = 256
PATH_COMPONENTS = 4
PATH_SLACK = 2e-7
"""By how much squared distances may change where paths are shortened, m²."""


@register()
@dataclass(frozen=True, kw_only=True)
class WindowFeatures:
    """What the distance needs of each frame and each window of one motion.

    Attributes:
        xz: floor coordinates about the frame's centre times √w, x then z. [F, 2J]
        turned: the same turned by a right angle, z then −x. [F, 2J]
        y: heights times √w. [F, J]
        path: the frame centres over the window, about their mean, divided by √W, as components
            on an orthonormal basis; x then z. [R, 2B]
        path_turned: the same turned, z then −x. [R, 2B]
        spread: weighted mean squared distance from the window's centre plus squared height. [R]
    """

    xz: Float[Array, "F K"]
    turned: Float[Array, "F K"]
    y: Float[Array, "F J"]
    path: Float[Array, "R P"]
    path_turned: Float[Array, "R P"]
    spread: Float[Array, " R"]


def window_features(
    positions: Float[np.ndarray, "F J 3"],
    weights: Float[np.ndarray, " J"],
    level: float,
    window: int,
) -> WindowFeatures:
    """Prepares one motion for comparison; R = F − W + 1 window starts.

    ``level`` is a height near that of the bodies, the same for both motions that are compared:
    products of full heights would lose digits. Weights sum to 1.
    """
    return features_about(positions, centre_of(positions, level), weights, window)


def centre_of(positions: Float[np.ndarray, "F J 3"], level: float) -> Float[np.ndarray, "3"]:
    """The mean place of all joints on the floor, at the height ``level``."""
    middle = positions.mean(axis=0, dtype=np.float64).mean(axis=0) * [1, 0, 1] + [0, level, 0]
    return middle.astype(np.float32)


def features_about(
    positions: Float[np.ndarray, "F J 3"],
    centre: Float[np.ndarray, "3"],
    weights: Float[np.ndarray, " J"],
    window: int,
) -> WindowFeatures:
    """:func:`window_features` of a part of motions that are compared, about their common centre."""
    basis = window_basis(window) / np.sqrt(window)
    return _features(positions, centre, weights, basis.astype(np.float32))


@jax.jit
def _features(
    positions: Float[Array, "F J 3"],
    middle: Float[Array, "3"],
    weights: Float[Array, " J"],
    basis: Float[Array, "W B"],
) -> WindowFeatures:
    window = basis.shape[0]
    rows = positions.shape[0] - window + 1
    root = jnp.sqrt(weights)[None, :]
    x, y, z = (positions[..., i] - middle[i] for i in range(3))
    cx, cz = x @ weights, z @ weights
    x, z = (x - cx[:, None]) * root, (z - cz[:, None]) * root
    y = y * root

    def slide(values: Array) -> Array:
        return jnp.stack([values[k : k + rows] for k in range(window)], axis=1)

    px, pz = slide(cx) @ basis, slide(cz) @ basis
    spread = jnp.mean(slide(jnp.sum(x * x + y * y + z * z, axis=1)), axis=1)
    return WindowFeatures(
        xz=jnp.concatenate([x, z], axis=1),
        turned=jnp.concatenate([z, -x], axis=1),
        y=y,
        path=jnp.concatenate([px, pz], axis=1),
        path_turned=jnp.concatenate([pz, -px], axis=1),
        spread=spread + jnp.sum(px * px + pz * pz, axis=1),
    )


def window_basis(window: int) -> np.ndarray:
    """[W, W − 1] orthonormal polynomials without the constant, lowest degree first."""
    x = np.linspace(-1, 1, window) if window > 1 else np.zeros(1)
    return np.linalg.qr(np.polynomial.legendre.legvander(x, window - 1))[0][:, 1:]


def trim_paths(a: WindowFeatures, b: WindowFeatures) -> tuple[WindowFeatures, WindowFeatures]:
    """Leaves out the fast components of both paths where they cannot matter.

    Dropping components changes D² by at most 2·|rest of a|·|rest of b|. The centre of a real body
    moves so smoothly that a few components hold all but 2e-7 m² of it; other data keep all.
    """
    if 2 * path_rest(a) * path_rest(b) > PATH_SLACK:
        return a, b
    return trim_path(a), trim_path(b)


def path_rest(features: WindowFeatures) -> float:
    """Length of what :func:`trim_path` leaves out of a path, the longest of all windows, m."""
    parts = np.asarray(features.path).reshape(len(features.spread), 2, -1)[..., PATH_COMPONENTS:]
    return float(np.sqrt(np.sum(parts**2, axis=(1, 2)).max(initial=0.0)))


def trim_path(features: WindowFeatures) -> WindowFeatures:
    """The features with the slow components of their paths only."""
    size = features.path.shape[1] // 2
    if size <= PATH_COMPONENTS:
        return features
    kept = {
        name: np.asarray(getattr(features, name))
        .reshape(-1, 2, size)[..., :PATH_COMPONENTS]
        .reshape(-1, 2 * PATH_COMPONENTS)
        for name in ("path", "path_turned")
    }
    return replace(features, **kept)


def diagonal_sum(products: Float[Array, "F G"], window: int) -> Float[Array, "R C"]:
    """Sums of ``window`` entries along each diagonal, by doubling."""
    rows, columns = (size - window + 1 for size in products.shape)
    total = None
    done, power, length = 0, products, 1
    remaining = window
    while remaining:
        if remaining & 1:
            part = power[done : done + rows, done : done + columns]
            total = part if total is None else total + part
            done += length
        remaining >>= 1
        if remaining:
            power = power[:-length, :-length] + power[length:, length:]
            length *= 2
    assert total is not None
    return total


def block_distances(a: WindowFeatures, b: WindowFeatures, window: int) -> Float[Array, "R C"]:
    """Squared distances of all window starts of ``a`` to all of ``b``, m²; may be −1e-6."""
    # One product is a third quicker than two where both motions are short.
    both = a.xz @ jnp.concatenate([b.xz, b.turned]).T
    straight, across = jnp.split(both, 2, axis=1)
    cosine = diagonal_sum(straight, window) / window + a.path @ b.path.T
    sine = diagonal_sum(across, window) / window + a.path @ b.path_turned.T
    height = diagonal_sum(a.y @ b.y.T, window) * (2.0 / window)
    aligned = 2 * jnp.sqrt(cosine * cosine + sine * sine)
    return a.spread[:, None] + b.spread[None, :] - height - aligned


@partial(jax.jit, static_argnames=("window",))
def _distance_matrix(a: WindowFeatures, b: WindowFeatures, *, window: int) -> Float[Array, "R C"]:
    """Distances in blocks of rows; the number of rows is a multiple of the block."""

    def one(first: Array) -> Array:
        squared = block_distances(rows_of(a, first, ROW_BLOCK, window), b, window)
        return jnp.sqrt(jnp.maximum(squared, 0.0))

    rows = a.spread.shape[0]
    return jax.lax.map(one, jnp.arange(0, rows, ROW_BLOCK)).reshape(rows, -1)


def rows_of(features: WindowFeatures, first: Array, count: int, window: int) -> WindowFeatures:
    """The part that belongs to the window starts ``first … first + count − 1``."""

    def frames(x: Array) -> Array:
        return jax.lax.dynamic_slice_in_dim(x, first, count + window - 1)

    def starts(x: Array) -> Array:
        return jax.lax.dynamic_slice_in_dim(x, first, count)

    return WindowFeatures(
        xz=frames(features.xz),
        turned=frames(features.turned),
        y=frames(features.y),
        path=starts(features.path),
        path_turned=starts(features.path_turned),
        spread=starts(features.spread),
    )


def distance_matrix(
    positions_a: Float[Array, "F J 3"],
    positions_b: Float[Array, "G J 3"],
    *,
    window: int,
    weights: Float[Array, " J"] | None = None,
) -> Float[np.ndarray, "R C"]:
    """Distance of every window of one motion to every window of another, m RMS.

    Hybrid paper eq. 1 with uniform weights over the frames of a window. Row r is the window of A
    that starts at frame r, column c the window of B that starts at frame c.

    Args:
        positions_a, positions_b: world positions of joints, m.
        window: frames in a window, 1 or more.
        weights: how much each joint counts, 0 or more, not all 0; scaled to the sum 1. Default
            equal.

    Returns:
        [F − window + 1, G − window + 1].

    Raises:
        ConfigError: a window longer than a motion, or weights that cannot be used.
    """
    a, b = (np.asarray(p, dtype=np.float32) for p in (positions_a, positions_b))
    shortest = min(len(a), len(b))
    if not 1 <= window <= shortest:
        raise ConfigError(f"a window of {window} frames, expected 1 … {shortest}")
    scaled = normalised_weights(weights, a.shape[1])
    rows, columns = len(a) - window + 1, len(b) - window + 1
    # Rows to whole blocks and a bucket, so that few shapes are compiled.
    level = float((a[..., 1].mean() + b[..., 1].mean()) / 2)
    features = []
    for p, count in ((a, rows), (b, columns)):
        size = bucket_size(count, ROW_BLOCK) + window - 1
        features.append(window_features(pad_axis(p, size), scaled, level, window))
    trimmed = trim_paths(*features)
    return np.asarray(_distance_matrix(*trimmed, window=window))[:rows, :columns]


def normalised_weights(weights: Float[Array, " J"] | None, joints: int) -> np.ndarray:
    """Weights as float32 with the sum 1; :class:`ConfigError` if they are negative or all zero."""
    if weights is None:
        return np.full(joints, 1 / joints, dtype=np.float32)
    w = np.asarray(weights, dtype=np.float64)
    if w.shape != (joints,) or not np.isfinite(w).all() or (w < 0).any() or w.sum() <= 0:
        raise ConfigError(f"weights {w.tolist()}, expected {joints} numbers ≥ 0, not all 0")
    return (w / w.sum()).astype(np.float32)
