"""Planar rigid transforms: a turn about +Y, then a translation on the floor.

A transform is an array ``[..., 3]`` of (θ, x, z): θ in rad, x and z in metres. Applied to a point

    x ← x cos θ + z sin θ + x0,   y ← y,   z ← −x sin θ + z cos θ + z0

so that the +Z axis turns to (sin θ, 0, cos θ).
"""

from __future__ import annotations

from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.arrays import Array, namespace


def identity(like: Array) -> Float[Array, 3]:
    """The transform that changes nothing, in the array library and dtype of ``like``."""
    return namespace(like).zeros(3, dtype=like.dtype)


def apply(transform: Float[Array, "*a 3"], points: Float[Array, "*b 3"]) -> Float[Array, "*c 3"]:
    """Maps points ``[..., 3]``; leading axes broadcast."""
    xp = namespace(transform, points)
    c, s = xp.cos(transform[..., 0]), xp.sin(transform[..., 0])
    x, y, z = (points[..., i] for i in range(3))
    nx = x * c + z * s + transform[..., 1]
    nz = z * c - x * s + transform[..., 2]
    return xp.stack([nx, xp.broadcast_to(y, nx.shape), nz], axis=-1)


def compose(outer: Float[Array, "*a 3"], inner: Float[Array, "*b 3"]) -> Float[Array, "*c 3"]:
    """``inner`` first, then ``outer``."""
    xp = namespace(outer, inner)
    c, s = xp.cos(outer[..., 0]), xp.sin(outer[..., 0])
    x, z = inner[..., 1], inner[..., 2]
    return xp.stack(
        [
            outer[..., 0] + inner[..., 0],
            x * c + z * s + outer[..., 1],
            z * c - x * s + outer[..., 2],
        ],
        axis=-1,
    )


def inverse(transform: Float[Array, "*a 3"]) -> Float[Array, "*a 3"]:
    """The transform that undoes ``transform``."""
    xp = namespace(transform)
    c, s = xp.cos(transform[..., 0]), xp.sin(transform[..., 0])
    x, z = transform[..., 1], transform[..., 2]
    return xp.stack([-transform[..., 0], -(x * c - z * s), -(x * s + z * c)], axis=-1)


def apply_pose(
    transform: Float[Array, "*a 3"],
    root_translation: Float[Array, "*b 3"],
    root_rotation: Float[Array, "*b 4"],
) -> tuple[Float[Array, "*b 3"], Float[Array, "*b 4"]]:
    """Maps a root's position and rotation."""
    turn = quaternion.from_yaw(transform[..., 0])
    return apply(transform, root_translation), quaternion.multiply(turn, root_rotation)


def frame_of(
    root: Float[Array, "*b 3"], left_hip: Float[Array, "*b 3"], right_hip: Float[Array, "*b 3"]
) -> Float[Array, "*b 3"]:
    """The planar frame of a body: the transform from its own coordinates to the world.

    Origin: the root's floor projection. Heading (+Z): (left hip − right hip) × up, on the floor.
    Where the hips lie one above the other the heading is +Z of the world.
    """
    xp = namespace(root, left_hip, right_hip)
    across = left_hip - right_hip
    hx, hz = -across[..., 2], across[..., 0]
    lying = hx * hx + hz * hz < 1e-12
    theta = xp.arctan2(xp.where(lying, 0 * hx, hx), xp.where(lying, 0 * hz + 1, hz))
    return xp.stack([theta, root[..., 0], root[..., 2]], axis=-1)
