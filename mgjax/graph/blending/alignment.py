"""Where the second window of a transition is put on the floor."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.graph.feet.legs import FootChains

SUPPORT = 16.0
"""What a foot that stands in both windows counts for the place, by the whole body."""


def align(
    positions_a: Float[Array, "W J 3"],
    positions_b: Float[Array, "W J 3"],
    weights: Float[Array, "*w J"],
) -> Float[jax.Array, "3"]:
    """The planar transform of the second window that brings it nearest to the first (eq. 1).

    ``weights``: of the joints [J] with the sum 1, or of each joint in each frame [W, J] with any.
    """
    if weights.ndim == 1:
        w = jnp.broadcast_to(weights / positions_a.shape[0], positions_a.shape[:2])
    else:
        w = weights / jnp.sum(weights)
    ca, cb = (jnp.einsum("wj,wjc->c", w, p) for p in (positions_a, positions_b))
    a, b = positions_a - ca[None, None], positions_b - cb[None, None]
    cosine = jnp.sum(w * (a[..., 0] * b[..., 0] + a[..., 2] * b[..., 2]))
    sine = jnp.sum(w * (a[..., 0] * b[..., 2] - a[..., 2] * b[..., 0]))
    turn = jnp.arctan2(sine, cosine)
    turned = planar.apply(jnp.stack([turn, 0 * turn, 0 * turn]), cb)
    return jnp.stack([turn, ca[0] - turned[0], ca[2] - turned[2]])


def align_by_support(
    positions_a: Float[Array, "W J 3"],
    positions_b: Float[Array, "W J 3"],
    weights: Float[Array, " J"],
    chains: FootChains,
    standing: Bool[Array, "W 2"],
) -> Float[jax.Array, "3"]:
    """:func:`align`, in which feet that stand in both windows count more for the place.

    The heading stays that of the whole body, which a foot that points elsewhere would turn.
    """
    turn = align(positions_a, positions_b, weights)[0]
    w = support_weights(weights, chains, standing)
    w = w / jnp.sum(w)
    ca, cb = (jnp.einsum("wj,wjc->c", w, p) for p in (positions_a, positions_b))
    turned = planar.apply(jnp.stack([turn, 0 * turn, 0 * turn]), cb)
    return jnp.stack([turn, ca[0] - turned[0], ca[2] - turned[2]])


def support_weights(
    weights: Float[Array, " J"],
    chains: FootChains,
    standing: Bool[Array, "W 2"],
) -> Float[Array, "W J"]:
    """Weights that add the ball and the ankle of each foot while it stands in both windows.

    Frames count as much as the blend moves in them: 6u(1 − u), most in the middle.

    Args:
        weights: of all joints, with the sum 1.
        chains: the legs.
        standing: whether the left and right foot stand in both windows.
    """
    window = standing.shape[0]
    u = (jnp.arange(window, dtype=weights.dtype) + 0.5) / window
    extra = (0.5 * SUPPORT * 6 * u * (1 - u))[:, None] * standing.astype(weights.dtype)
    result = jnp.broadcast_to(weights, (window, weights.shape[0]))
    for side in range(2):
        joints = jnp.array([chains.balls[side], chains.ankles[side]])
        result = result.at[:, joints].add(extra[:, side, None])
    return result


def same_support(
    plants: Bool[np.ndarray, "F 2"],
    rows: Int[np.ndarray, " M"],
    columns: Int[np.ndarray, " M"],
    window: int,
) -> Float[np.ndarray, " M"]:
    """Share of the frames of two windows in which the same feet stand.

    Args:
        plants: whether the left and right foot stand.
        rows, columns: first frames of the two windows.
        window: frames in a window.
    """
    step = np.arange(window)
    same = plants[rows[:, None] + step] == plants[columns[:, None] + step]
    return same.all(axis=-1).mean(axis=-1)
