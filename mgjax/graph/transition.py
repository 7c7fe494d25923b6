"""Transition clips: two windows aligned and blended (hybrid paper eqs 2–5)."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.core.xla.padding import bucket_size, pad_axis
from mgjax.graph.blending.alignment import align, align_by_support
from mgjax.graph.blending.forms import blend_form
from mgjax.graph.blending.mixing import Window, mix
from mgjax.graph.feet.blended import keep_plants
from mgjax.graph.feet.legs import FootChains
from mgjax.graph.plants import inherited_frames

CHUNK = 256
"""Transitions blended in one call; the last call is padded."""

FRAMES = 1024
"""Smallest number of frames that the axis is padded to."""


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
    *,
    form: str = "support",
    clean: bool = True,
    room: int = FRAMES,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Blends many transitions at once.

    Args:
        skeleton: of all motion.
        root, rotations, positions: all clips on one axis of frames.
        plants: whether the left and right foot are planted, on the same axis.
        chains: the legs, for support and foot clean-up; None does without both.
        rows, columns: first frames of the two windows of each transition.
        weights: of all joints, with the sum 1.
        window: frames in a window.
        form: of the blend; see :func:`mgjax.graph.blending.forms.blend_form`.
        clean: whether feet are cleaned.
        room: smallest number of frames that the axis is padded to.

    Returns:
        root [M, W+1, 3] and rotations [M, W+1, J, 4] in the coordinates of the clip that is left,
        the last frame being the pose of arrival; the planar transforms [M, 3]; and metres that
        planted feet travel per frame, before and after clean-up [M, 2].
    """

    # One frame more: the first window is read to the frame after it, where it no longer counts.
    size = bucket_size(len(root) + 1, room)
    axis = [jnp.asarray(pad_axis(x, size)) for x in (root, rotations, positions, plants)]
    how = blend_form(form, window)
    share, decay = jnp.asarray(weights), jnp.asarray(how.decay)
    parts: list[tuple[np.ndarray, ...]] = []
    for first in range(0, len(rows), CHUNK):
        chunk = [x[first : first + CHUNK].astype(np.int32) for x in (rows, columns)]
        count = len(chunk[0])
        padded = (pad_axis(x, CHUNK) for x in chunk)
        result = _build_chunk(
            skeleton,
            *axis,
            *padded,
            share,
            decay,
            chains=chains,
            support=how.support and chains is not None,
            continuous=how.continuous,
            clean=clean and chains is not None,
        )
        parts.append(tuple(np.asarray(x)[:count] for x in result))
    if not parts:
        shape = (0, window + 1, skeleton.num_joints, 4)
        return np.zeros((0, window + 1, 3)), np.zeros(shape), np.zeros((0, 3)), np.zeros((0, 2))
    joined = [np.concatenate(x) for x in zip(*parts, strict=True)]
    return joined[0], joined[1], joined[2], joined[3]


@partial(jax.jit, static_argnames=("chains", "support", "continuous", "clean"))
def _build_chunk(
    skeleton: Skeleton,
    root: Float[jax.Array, "F 3"],
    rotations: Float[jax.Array, "F J 4"],
    positions: Float[jax.Array, "F J 3"],
    plants: Bool[jax.Array, "F 2"],
    rows: Int[jax.Array, " M"],
    columns: Int[jax.Array, " M"],
    weights: Float[jax.Array, " J"],
    decay: Float[jax.Array, "W1 W1"],
    *,
    chains: FootChains | None,
    support: bool,
    continuous: bool,
    clean: bool,
) -> tuple[jax.Array, ...]:
    """The four results of :func:`build_transitions`; ``decay`` is as long as a transition."""
    length = decay.shape[0]
    window = length - 1

    def take(x: jax.Array, first: jax.Array, count: int = length) -> jax.Array:
        return jax.lax.dynamic_slice_in_dim(x, first, count)

    def one(row: jax.Array, column: jax.Array) -> tuple[jax.Array, ...]:
        axis = root, rotations, positions
        first, second = (Window(*(take(x, at) for x in axis)) for at in (row, column))
        standing = take(plants, row, window) & take(plants, column, window)
        legs = chains if support else None
        places = first.places[:-1], second.places[:-1]
        if legs is None:
            transform = align(*places, weights)
        else:
            transform = align_by_support(*places, weights, legs, standing)
        mixed_root, mixed = mix(
            skeleton, legs, first, second, standing, transform, decay, continuous=continuous
        )
        if not clean or chains is None:
            return mixed_root, mixed, transform, jnp.zeros(2)
        # One frame before and after.
        inherited = inherited_frames(row, column, jnp.arange(-1, length), window)
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
