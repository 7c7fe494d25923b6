"""A motion as the page plays it: few frames, and rotations in two bytes a number."""

from __future__ import annotations

import numpy as np
from jaxtyping import Int

from mgjax.core.motion import Motion, resample
from mgjax.stage.show.types import Frames

RATE = 30.0
"""Frames a second that are enough: the page interpolates between them."""
_ONE, _STEP = 32767, 8
"""Rotations are multiples of 8/32767: a third of a file less, and within 0.03°."""
_GRID = 8192.0
"""Places of the root are multiples of 1/8192 m: they take half as much in a file then."""


def frames_of(
    motion: Motion, *, start: float = 0.0, rate: float | None = None, delta: bool = True
) -> Frames:
    """The poses of a motion for the page; rotations are within 0.03° and places within 0.1 mm.

    Args:
        motion: any; bones that are not rigid are shown as the body's.
        start: second of the show at which it begins.
        rate: frames a second, default: as captured, but at most 30.
        delta: write rotations as differences, which takes much less in a file.
    """
    wanted = min(motion.frame_rate, RATE) if rate is None else rate
    if abs(wanted - motion.frame_rate) > 1e-6 * motion.frame_rate:
        motion = resample(motion, wanted)
    rotations = _whole(np.asarray(motion.local_rotations, dtype=np.float32))
    if delta:
        rotations = np.concatenate([rotations[:1], np.diff(rotations, axis=0)])
    root = np.asarray(motion.root_translation, dtype=np.float64)
    return Frames(
        rate=float(motion.frame_rate),
        start=float(start),
        rotations=rotations,
        root=(np.rint(root * _GRID) / _GRID).astype(np.float32),
        delta=delta,
    )


def _whole(rotations: np.ndarray) -> Int[np.ndarray, "F J 4"]:
    """Times 32767, each with the sign that is nearer to the frame before: q and −q are the same."""
    turned = np.einsum("fjx,fjx->fj", rotations[1:], rotations[:-1]) < 0
    signs = np.cumprod(np.where(turned, -1, 1), axis=0)
    signs = np.concatenate([np.ones((1, rotations.shape[1]), signs.dtype), signs])
    turns = np.clip(rotations * signs[..., None], -1, 1) * (_ONE / _STEP)
    return (np.rint(turns) * _STEP).clip(-_ONE, _ONE).astype(np.int16)
