"""Two aligned windows mixed into the frames of a transition."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float

from mgjax.core import planar, quaternion
from mgjax.core.kinematics import forward
from mgjax.core.skeleton import Skeleton
from mgjax.graph.feet.legs import FootChains

LED = 0.5
"""Share of a transition for which feet must stand in both windows to lead the root wholly."""


class Window(NamedTuple):
    """The frames of a window and the one after it, in the coordinates of their clip."""

    root: Float[jax.Array, "W1 3"]
    rotations: Float[jax.Array, "W1 J 4"]
    places: Float[jax.Array, "W1 J 3"]


def blend(
    root_a: Float[jax.Array, "W1 3"],
    rotations_a: Float[jax.Array, "W1 J 4"],
    root_b: Float[jax.Array, "W1 3"],
    rotations_b: Float[jax.Array, "W1 J 4"],
    transform: Float[jax.Array, "3"],
    decay: Float[jax.Array, "W1 W1"],
    *,
    continuous: bool,
) -> tuple[Float[jax.Array, "W1 3"], Float[jax.Array, "W1 J 4"]]:
    """B, mapped by ``transform``, plus the offset of A from it that dies away by ``decay``.

    The root's offset is a vector, that of a joint the rotation vector of b⁻¹a. With ``continuous``
    its sign goes along the frames, so that offsets that pass half a turn do not jump to the other
    side; the turn is the shorter one in the middle frame. Without, it is in each frame. The last
    frame is that of B. With diagonal ``decay`` this is the crossfade of eqs 2–5.

    Deviation: the paper prints slerp(A, B, α), which would turn from B to A while the root runs
    from A to B; here both run from A to B.
    """
    root, turned = planar.apply_pose(transform, root_b, rotations_b[:, 0])
    target = jnp.concatenate([turned[:, None], rotations_b[:, 1:]], axis=1)
    target = _same_sign(jnp.asarray(target)) if continuous else target
    apart = jnp.asarray(quaternion.multiply(quaternion.conjugate(target), rotations_a))
    if continuous:
        apart = _same_sign(apart)
        middle = apart[apart.shape[0] // 2, :, :1]
        vectors = _full_log(jnp.where(middle < 0, -1.0, 1.0)[None] * apart)
    else:
        vectors = quaternion.log(apart)
    offsets = jnp.einsum("pq,qjc->pjc", decay, vectors)
    rotations = quaternion.multiply(target, quaternion.exp(offsets))
    rotations = jnp.asarray(rotations).at[-1].set(target[-1])
    offset = (decay @ (root_a - root)).at[-1].set(0.0)
    return jnp.asarray(root) + offset, rotations


def lead_by_support(
    skeleton: Skeleton,
    chains: FootChains,
    root: Float[jax.Array, "W1 3"],
    rotations: Float[jax.Array, "W1 J 4"],
    places_a: Float[jax.Array, "W1 J 3"],
    places_b: Float[jax.Array, "W1 J 3"],
    standing: Bool[jax.Array, "W 2"],
    decay: Float[jax.Array, "W1 W1"],
) -> Float[jax.Array, "W1 3"]:
    """The root moved so that the feet that stand in both windows are blended as places.

    Joint angles and root that are blended apart move a standing foot though it stands in both
    windows; its place, blended as such, only goes from the one spot to the other. With two feet,
    the mean of what they ask for, each by how long it stands. Nothing changes in the first and the
    last frame.

    Args:
        skeleton, chains: the body and its legs.
        root, rotations: blended.
        places_a, places_b: the joints of the two windows, the second's aligned.
        standing: whether the left and right foot stand in both.
        decay: of the blend.
    """
    share = jnp.mean(standing.astype(root.dtype), axis=0)
    share = share / jnp.maximum(jnp.sum(share), LED)
    balls = jnp.array(chains.balls)
    a, b = places_a[:, balls], places_b[:, balls]
    wanted = b + jnp.einsum("pq,qsc->psc", decay, a - b)
    positions, _ = forward(skeleton, root, rotations)
    moved = jnp.einsum("s,psc->pc", share, wanted - jnp.asarray(positions)[:, balls])
    return root + moved.at[0].set(0.0).at[-1].set(0.0)


def mix(
    skeleton: Skeleton,
    chains: FootChains | None,
    a: Window,
    b: Window,
    standing: Bool[jax.Array, "W 2"],
    transform: Float[jax.Array, "3"],
    decay: Float[jax.Array, "W1 W1"],
    *,
    continuous: bool,
) -> tuple[Float[jax.Array, "W1 3"], Float[jax.Array, "W1 J 4"]]:
    """:func:`blend`, and :func:`lead_by_support` where the legs are given."""
    root, rotations = blend(
        a.root, a.rotations, b.root, b.rotations, transform, decay, continuous=continuous
    )
    if chains is not None:
        b_places = jnp.asarray(planar.apply(transform, b.places))
        root = lead_by_support(
            skeleton, chains, root, rotations, a.places, b_places, standing, decay
        )
    return root, rotations


def _same_sign(turns: Float[jax.Array, "W J 4"]) -> Float[jax.Array, "W J 4"]:
    """Each quaternion on the side of the one in the frame before."""
    opposite = jnp.sum(turns[1:] * turns[:-1], axis=-1) < 0
    signs = jnp.cumprod(jnp.where(opposite, -1.0, 1.0), axis=0)
    return turns * jnp.concatenate([jnp.ones_like(signs[:1]), signs])[..., None]


def _full_log(q: Float[jax.Array, "*b 4"]) -> Float[jax.Array, "*b 3"]:
    """The rotation vector of a unit quaternion, up to a whole turn long where w is below 0."""
    sine = jnp.sqrt(jnp.maximum(jnp.sum(q[..., 1:] ** 2, axis=-1), 1e-16))
    return (2 * jnp.arctan2(sine, q[..., 0]) / sine)[..., None] * q[..., 1:]
