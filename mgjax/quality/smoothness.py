"""Smoothness: the normalised jerk of short windows, and jumps of the velocity."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.core.arrays import Array
from mgjax.quality.feet import Count, Number

WINDOW_S = 0.4
"""Length of a window."""
LEAST_PATH_M = 1e-4
"""A joint of an adult that moves less in a window counts as moving so far."""


def window_frames(rate: float) -> int:
    """Steps from a frame to the next that a window has."""
    return round(WINDOW_S * rate)


def normalised_jerk(
    places: Float[Array, "F J 3"], *, rate: float, scale: Number
) -> Float[Array, "W J"]:
    """T⁵ ∫ |jerk|² dt / path² of each joint in each window of 0.4 s. [F − window, J]

    It has no unit and does not depend on the rate: a motion twice as large has the same. The
    integral is the mean of the squared third differences inside the window, times its length; the
    path is the sum of its steps, and at least :data:`LEAST_PATH_M`.
    """
    length = window_frames(rate)
    step = places[1:] - places[:-1]
    change = step[1:] - step[:-1]
    jerk = change[1:] - change[:-1]
    square = _window_sums(jnp.sum(jerk * jerk, axis=-1), length - 2) * (length / (length - 2))
    way = jnp.sqrt(jnp.maximum(jnp.sum(step * step, axis=-1), 1e-20))
    path = jnp.maximum(_window_sums(way, length), LEAST_PATH_M * scale)
    # jerk = third difference · rate³ and dt = 1 / rate
    return jnp.asarray(length**5, places.dtype) * square / path**2


def velocity_jumps(places: Float[Array, "F J 3"], *, rate: float) -> Float[Array, "C J"]:
    """How much each joint's velocity changes at each inner frame, m/s. [F − 2, J]"""
    change = places[2:] - 2 * places[1:-1] + places[:-2]
    return jnp.sqrt(jnp.maximum(jnp.sum(change * change, axis=-1), 1e-20)) * rate


def windows_counted(
    windows: int, length: int, count: Count, first: Count, last: Count
) -> Bool[Array, " W"]:
    """Which windows lie inside the motion and have a frame of ``first`` … ``last``."""
    start = jnp.arange(windows)
    return (start + length <= count - 1) & (start + length >= first) & (start <= last)


def _window_sums(values: Float[Array, "S J"], length: int) -> Float[Array, "W J"]:
    """Sums of so many values in a row: each window by itself, so that a quiet one stays exact."""
    zero = np.zeros((), values.dtype)
    return jax.lax.reduce_window(values, zero, jax.lax.add, (length, 1), (1, 1), "valid")
