"""Hits of a clip set as a worse sensor, or another body, would show them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.config import FEET, AnalysisConfig
from mgjax.ballsport.hits.bones import BoneHit, analyse
from mgjax.ballsport.hits.motion_vectors import MotionVectors, stack

NEAR_S = 0.1
Disturbance = Callable[[np.ndarray], np.ndarray]
"""What becomes of the positions of all joints [F,J,3]."""


@dataclass(frozen=True, kw_only=True)
class Found:
    """The hits of a set as they are found in a disturbed copy of its motion.

    Attributes:
        hit: number in the set, for each that was found.
        vectors: their motion vectors.
        missed: numbers that were not found.
        spurious: hits that are in no clip of the set.
    """

    hit: np.ndarray
    vectors: MotionVectors
    missed: list[int]
    spurious: int


def find_again(
    clips: ClipSet, analysis: AnalysisConfig, disturb: Disturbance, size: float = 1.0
) -> Found:
    """Analyses all clips as ``disturb`` shows them, of a body so many times as large."""
    rate = clips.motion.frame_rate
    body = replace(clips.skeleton, offsets=clips.skeleton.offsets * np.float32(size))
    number: list[int] = []
    vectors: list[MotionVectors] = []
    missed, spurious = [], 0
    for clip, (first, stop) in enumerate(zip(clips.clip_starts, clips.clip_stops, strict=True)):
        shown = disturb(clips.positions[first:stop].astype(np.float64))
        hits: list[BoneHit] = analyse(body, shown, rate, bones=FEET, config=analysis)
        wanted = [int(h) for h in np.flatnonzero(clips.hit_clip == clip)]
        for item in hits:
            at = item.hit.fastest + first
            near = [
                h
                for h in wanted
                if clips.hit_bone[h] == item.bone
                and abs(int(clips.fastest[h]) - at) <= NEAR_S * rate
            ]
            if near:
                wanted.remove(near[0])
                number.append(near[0])
                vectors.append(item.vector)
            else:
                spurious += 1
        missed += wanted
    return Found(hit=np.array(number), vectors=stack(vectors), missed=missed, spurious=spurious)


def disturbances(
    noise_m: Sequence[float], dropped: Sequence[float], bodies: Sequence[float], seed: int
) -> dict[str, tuple[Disturbance, float, bool]]:
    """By name: what happens to positions, the size of the body, whether that is known."""

    def noisy(sigma: float, positions: np.ndarray) -> np.ndarray:
        rng = np.random.default_rng(seed)
        return positions + rng.normal(scale=sigma, size=positions.shape)

    def gaps(share: float, positions: np.ndarray) -> np.ndarray:
        rng = np.random.default_rng(seed)
        kept = np.flatnonzero(rng.random(len(positions)) >= share)
        t = np.arange(len(positions))
        right = np.clip(np.searchsorted(kept, t), 1, len(kept) - 1)
        a, b = kept[right - 1], kept[right]
        weight = np.clip((t - a) / (b - a), 0, 1)[:, None, None]
        return positions[a] * (1 - weight) + positions[b] * weight

    named: dict[str, tuple[Disturbance, float, bool]] = {"as captured": (lambda p: p, 1.0, True)}
    for sigma in noise_m:
        named[f"noise {1000 * sigma:g} mm"] = (partial(noisy, sigma), 1.0, True)
    for share in dropped:
        named[f"{100 * share:g} % of frames lost"] = (partial(gaps, share), 1.0, True)
    for size in bodies:
        named[f"body × {size:g}, scaled"] = (lambda p, size=size: p * size, size, True)
        named[f"body × {size:g}, not scaled"] = (lambda p, size=size: p * size, size, False)
    return named
