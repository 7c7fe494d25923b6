"""Vectors with the components on the last axis but one: ``[..., 3, N]``, many solves last.

Compiled code over such arrays is several times faster than over ``[..., 3]``, where the last axis
is shorter than a register.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import lax

from mgjax.core.arrays import Array

TINY = 1e-20
"""Squared length below which a vector counts as zero, in the unit of its components squared."""


def scale(factor: Array, a: Array) -> Array:
    """Each vector times its own factor ``[..., N]``."""
    return factor[..., None, :] * a


def dot(a: Array, b: Array) -> Array:
    """Inner products ``[..., N]``."""
    return a[..., 0, :] * b[..., 0, :] + a[..., 1, :] * b[..., 1, :] + a[..., 2, :] * b[..., 2, :]


def cross(a: Array, b: Array) -> Array:
    """Cross products."""
    ax, ay, az = (a[..., i, :] for i in range(3))
    bx, by, bz = (b[..., i, :] for i in range(3))
    return jnp.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-2)


def where(mask: Array, a: Array, b: Array) -> Array:
    """Chooses whole vectors by a mask ``[..., N]``."""
    return jnp.where(mask[..., None, :], a, b)


def root(square: Array, floor: float = TINY) -> Array:
    """Square root; up to ``floor`` it is 0 and so is its derivative."""
    small = square <= floor
    return jnp.where(small, 0.0, jnp.sqrt(jnp.where(small, 1.0, square)))


def norm(a: Array) -> Array:
    """Lengths; the derivative at zero is 0."""
    return root(dot(a, a))


def unit(a: Array, otherwise: Array, floor: float) -> Array:
    """Directions of ``a``, or ``otherwise`` where ``a`` is not longer than ``floor``."""
    square = dot(a, a)
    short = square <= floor * floor
    return where(short, otherwise, scale(lax.rsqrt(jnp.where(short, 1.0, square)), a))


def square_to(axis: Array) -> Array:
    """Unit vectors square to the unit vectors ``axis``; zero for zero."""
    x, y, z = (axis[..., i, :] for i in range(3))
    zero = jnp.zeros_like(x)
    # The cross product with the coordinate axis, x or y, that is farther from it.
    use_x = jnp.abs(x) < 0.6
    with_x, with_y = jnp.stack([zero, z, -y], axis=-2), jnp.stack([-z, zero, x], axis=-2)
    across = where(use_x, with_x, with_y)
    return scale(lax.rsqrt(jnp.maximum(dot(across, across), 0.3)), across)


def x_axis(like: Array) -> Array:
    """The x axis for each of the vectors ``like``."""
    one = jnp.ones_like(like[..., 0, :])
    return jnp.stack([one, 0 * one, 0 * one], axis=-2)
