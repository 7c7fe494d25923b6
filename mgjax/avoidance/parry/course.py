"""How an arm's offset goes over time: out to the attack, a moment there, and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.parry.guard import Arm
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.core import quaternion
from mgjax.core.arrays import Array, namespace
from mgjax.core.motion import Motion
from mgjax.core.shown import like

RISE_S = 0.4
"""How long the arm takes to be where it meets the attack; less where less time is left."""
EARLY_S = 0.02
"""It is there so long before, …"""
STAY_S = 0.08
"""… stays so long after, …"""
FALL_S = 0.5
"""… and takes so long back."""


def rise_start(contact: Float[Array, "*b"]) -> Float[Array, "*b"]:
    """When an arm sets out that meets an attack at some moment, s from now; never before now."""
    xp = namespace(contact)
    return xp.maximum(contact - EARLY_S - RISE_S, 0.0)


def share_at(times: Float[Array, "*b T"], contact: Float[Array, "*b"]) -> Float[Array, "*b T"]:
    """Share of the offset at some times, 0 … 1: a quintic step up, and one down.

    Value, first and second derivative are 0 at both ends of the window, and outside.

    Args:
        times: s from now.
        contact: when the attack is met, s.
    """
    xp = namespace(times, contact)
    start = rise_start(contact)[..., None]
    there = xp.maximum(contact[..., None] - EARLY_S, start + 1e-3)
    leave = contact[..., None] + STAY_S
    up = _step((times - start) / (there - start))
    return up * (1 - _step((times - leave) / FALL_S))


def _step(x: Float[Array, "*b"]) -> Float[Array, "*b"]:
    """6x⁵ − 15x⁴ + 10x³ between 0 and 1."""
    x = namespace(x).clip(x, 0.0, 1.0)
    return x * x * x * (x * (6 * x - 15) + 10)


def course(
    contact: float, turns: Float[np.ndarray, "2 3"]
) -> tuple[float, Float[np.ndarray, "W 6"]]:
    """The window of an offset in whole written frames: its start, s, and the turns in it, rad."""
    when = np.array([contact])
    first = int(np.floor(float(rise_start(when)[0]) * EXPORT_RATE))
    last = int(np.ceil((contact + STAY_S + FALL_S) * EXPORT_RATE))
    times = np.arange(first, last + 1) / EXPORT_RATE
    share = np.asarray(share_at(times[None], when))[0]
    values = share[:, None] * np.asarray(turns, np.float64).reshape(1, 6)
    return first / EXPORT_RATE, values


def turn_arm(
    motion: Motion,
    arm: Arm,
    times: Float[np.ndarray, " T"],
    values: Float[np.ndarray, "W 6"],
    start: float,
) -> Motion:
    """A motion with shoulder and elbow of one arm turned; all else, and other frames, as they were.

    Args:
        motion: a pose for each of the ``times``.
        arm: the arm.
        times: s from now.
        values: rotation vectors of shoulder and elbow in their own frames, rad, 120 times a second.
        start: of these, s from now.
    """
    position = (np.asarray(times, np.float64) - start) * EXPORT_RATE
    inside = (position > 0) & (position < len(values) - 1)
    if not inside.any():
        return motion
    low = position[inside].astype(np.int64)
    part = (position[inside] - low)[:, None]
    turns = (values[low] * (1 - part) + values[low + 1] * part).reshape(-1, 2, 3)
    joints = np.array([arm.shoulder, arm.elbow])
    rotations = np.array(motion.local_rotations)
    rows = np.flatnonzero(inside)[:, None]
    before = rotations[rows, joints].astype(np.float64)
    after = np.asarray(quaternion.multiply(before, quaternion.exp(turns)))
    rotations[rows, joints] = after / np.linalg.norm(after, axis=-1, keepdims=True)
    return like(replace(motion, local_rotations=rotations), motion)
