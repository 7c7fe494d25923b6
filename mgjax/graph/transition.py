"""Transition clips: two windows aligned and blended (hybrid paper eqs 2–5)."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.core import planar, quaternion
from mgjax.core.arrays import Array
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.core.timing.easing import smoothstep
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.feet import FootChains, keep_plants
from mgjax.graph.plants import inherited_frames

CHUNK = 256
"""Transitions blended in one call; the last call is padded."""

FRAMES = 1024
"""Smallest number of frames that the axis is padded to."""


def blend_weights(window: int) -> Float[np.ndarray, " W"]:
    """α(p) = 2((p+1)/L)³ − 3((p+1)/L)² + 1 for p = 0 … L−1 (eq. 5): the share of the first clip."""
    return (1 - np.asarray(smoothstep((np.arange(window) + 1) / window))).astype(np.float32)


def align(
    positions_a: Float[Array, "W J 3"],
    positions_b: Float[Array, "W J 3"],
    weights: Float[Array, " J"],
) -> Float[Array, "3"]:
    """The planar transform of the second window that brings it nearest to the first (eq. 1)."""

    def centre(p: Array) -> Array:
        return jnp.einsum("wjc,j->c", p, weights) / p.shape[0]

    ca, cb = centre(positions_a), centre(positions_b)
    a, b = positions_a - ca[None, None], positions_b - cb[None, None]
    w = weights[None, :]
    cosine = jnp.sum(w * (a[..., 0] * b[..., 0] + a[..., 2] * b[..., 2]))
    sine = jnp.sum(w * (a[..., 0] * b[..., 2] - a[..., 2] * b[..., 0]))
    turn = jnp.arctan2(sine, cosine)
    turned = planar.apply(jnp.stack([turn, 0 * turn, 0 * turn]), cb)
    return jnp.stack([turn, ca[0] - turned[0], ca[2] - turned[2]])


def blend(
    root_a: Float[Array, "W 3"],
    rotations_a: Float[Array, "W J 4"],
    root_b: Float[Array, "W 3"],
    rotations_b: Float[Array, "W J 4"],
    transform: Float[Array, "3"],
    alpha: Float[Array, " W"],
) -> tuple[Float[Array, "W 3"], Float[Array, "W J 4"]]:
    """Root linear, rotations by slerp on the shortest arc, B first mapped by ``transform``.

    Deviation: the paper prints slerp(A, B, α), which would turn from B to A while the root runs
    from A to B; here both run from A to B.
    """
    root, turned = planar.apply_pose(transform, root_b, rotations_b[:, 0])
    rotations = jnp.concatenate([turned[:, None], rotations_b[:, 1:]], axis=1)
    share = alpha[:, None]
    return (
        share * root_a + (1 - share) * root,
        quaternion.slerp(rotations_a, rotations, 1 - share),
    )


def build_transitions(
    skeleton: Skeleton,
    root: Float[np.ndarray, "F 3"],
    rotations: Float[np.ndarray, "F J 4"],
    positions: Float[np.ndarray, "F J 3"],
    plants: Bool[np.ndarray, "F 2"],
    chains: FootChains | None,
    rows: Int[np.ndarray, " M"],
    columns: Int[np.ndarray, " M"],
    weights: Float[np.ndarray, " J"],
    window: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Blends many transitions at once.

    Args:
        skeleton: of all motion.
        root, rotations, positions: all clips on one axis of frames.
        plants: whether the left and right foot are planted, on the same axis.
        chains: the legs, for foot clean-up; None leaves feet as blended.
        rows, columns: first frames of the two windows of each transition.
        weights: of all joints, with the sum 1.
        window: frames in a window.

    Returns:
        root [M, W+1, 3] and rotations [M, W+1, J, 4] in the coordinates of the clip that is left,
        the last frame being the pose of arrival; the planar transforms [M, 3]; and metres that
        planted feet travel per frame, before and after clean-up [M, 2].
    """

    size = bucket_size(len(root), FRAMES)
    axis = [jnp.asarray(pad_axis(x, size)) for x in (root, rotations, positions, plants)]
    share, alpha = jnp.asarray(weights), jnp.asarray(blend_weights(window))
    parts: list[tuple[np.ndarray, ...]] = []
    for first in range(0, len(rows), CHUNK):
        chunk = [x[first : first + CHUNK].astype(np.int32) for x in (rows, columns)]
        count = len(chunk[0])
        padded = (pad_axis(x, CHUNK) for x in chunk)
        result = _build_chunk(skeleton, *axis, *padded, share, alpha, chains=chains)
        parts.append(tuple(np.asarray(x)[:count] for x in result))
    if not parts:
        shape = (0, window + 1, skeleton.num_joints, 4)
        return np.zeros((0, window + 1, 3)), np.zeros(shape), np.zeros((0, 3)), np.zeros((0, 2))
    joined = [np.concatenate(x) for x in zip(*parts, strict=True)]
    return joined[0], joined[1], joined[2], joined[3]


@partial(jax.jit, static_argnames=("chains",))
def _build_chunk(
    skeleton: Skeleton,
    root: Float[Array, "F 3"],
    rotations: Float[Array, "F J 4"],
    positions: Float[Array, "F J 3"],
    plants: Bool[Array, "F 2"],
    rows: Int[Array, " M"],
    columns: Int[Array, " M"],
    weights: Float[Array, " J"],
    alpha: Float[Array, " W"],
    *,
    chains: FootChains | None,
) -> tuple[Array, ...]:
    """The four results of :func:`build_transitions`; the window is as long as ``alpha``."""
    window = alpha.shape[0]

    def take(x: Array, first: Array, count: int) -> Array:
        return jax.lax.dynamic_slice_in_dim(x, first, count)

    def one(row: Array, column: Array) -> tuple[Array, ...]:
        transform = align(take(positions, row, window), take(positions, column, window), weights)
        mixed_root, mixed = blend(
            take(root, row, window),
            take(rotations, row, window),
            take(root, column, window),
            take(rotations, column, window),
            transform,
            alpha,
        )
        last_root, last_turn = planar.apply_pose(
            transform, root[column + window], rotations[column + window, 0]
        )
        last = rotations[column + window].at[0].set(last_turn)
        mixed_root = jnp.concatenate([mixed_root, last_root[None]])
        mixed = jnp.concatenate([mixed, last[None]])
        if chains is None:
            return mixed_root, mixed, transform, jnp.zeros(2)
        # One frame before and after.
        inherited = inherited_frames(row, column, jnp.arange(-1, window + 1), window)
        planted = plants[inherited]
        before = positions[row - 1]
        mixed, slide = keep_plants(skeleton, chains, mixed_root, mixed, planted, before)
        return mixed_root, mixed, transform, slide

    return jax.vmap(one)(rows, columns)


def frame_positions(
    skeleton: Skeleton, root: np.ndarray, rotations: np.ndarray
) -> Float[np.ndarray, "F J 3"]:
    """World positions of a long axis of frames."""
    return np.asarray(forward(skeleton, root, rotations)[0])
