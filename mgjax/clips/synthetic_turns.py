"""Quick turns on the spot with stepping feet, to any of a row of angles."""

from __future__ import annotations

import math

import numpy as np

from mgjax.clips.procedural.score import Score
from mgjax.clips.synthetic import perform
from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.clips.types import Clip
from mgjax.core import planar
from mgjax.core.errors import MotionError

REST_S = 0.35
"""Rest before and after a turn, s."""
_PAIR_DEG = 90.0
"""Largest angle that one pair of steps turns by."""
_STEP_S = (0.26, 0.12)
"""Duration of a step without a turn, and what the largest turn adds, s."""
_BETWEEN_S = 0.04


def synthetic_turns(
    degrees: tuple[int, ...], *, seed: int = 0, frame_rate: float = 60.0
) -> list[Clip]:
    """One clip ``turn_<degrees>`` for each angle, to the left where positive.

    A player who looks for a ball is quicker than someone who looks around: 45° take about 0.7 s,
    90° about 0.85 s, 180° twice that. Every clip begins and ends at
    rest in the neutral stance of :func:`mgjax.clips.synthetic.synthetic_clips`, over the origin.

    Raises:
        MotionError: an angle beyond half a turn or a frame rate that cannot be.
    """
    if not 1 <= frame_rate <= 10000:
        raise MotionError(f"frame rate is {frame_rate}, expected 1 … 10000 per second")
    skeleton = synthetic_skeleton()
    rng = np.random.default_rng(seed)
    clips: list[Clip] = []
    for angle in degrees:
        if not 0 < abs(angle) <= 180:
            raise MotionError(f"got a turn of {angle}°, expected up to 180° to either side")
        score = Score(rng=rng)
        score.time = REST_S
        _turn(score, math.radians(angle))
        score.time += REST_S - _BETWEEN_S
        motion = perform(score, frame_rate)
        clips.append(Clip(name=f"turn_{angle}", skeleton=skeleton, motion=motion))
    return clips


def _turn(score: Score, angle: float) -> None:
    """Pairs of quick steps; the foot on the side of the turn goes first."""
    pairs, first = math.ceil(abs(math.degrees(angle)) / _PAIR_DEG - 1e-9), int(angle < 0)
    share = abs(math.degrees(angle)) / pairs / _PAIR_DEG
    for _ in range(pairs):
        place = planar.compose(score.feet[0], np.array([angle / pairs, 0.0, 0.0]))
        for foot in (first, 1 - first):
            score.step(foot, place, _STEP_S[0] + _STEP_S[1] * share, height=0.05, shift=0.3)
            score.time += _BETWEEN_S
