"""Walks along arcs from straight to narrow, which follow any path when they are made a graph."""

from __future__ import annotations

import math

import numpy as np

from mgjax.clips.procedural.score import Score
from mgjax.clips.synthetic import perform
from mgjax.clips.synthetic_skeleton import synthetic_skeleton
from mgjax.clips.types import Clip
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.errors import MotionError

STEP_DEG = (0, 10, 20, 30, 40, 52)
"""By how much one step turns, to either side; 52° a step are a circle of 0.6 m radius."""
_STEPS = 8
_FIRST_M = 0.45
_STEP_M = 0.6
_SHORTER = 0.15
"""By so much a step that turns by :data:`_NARROW` is shorter than a straight one."""
_NARROW = math.radians(35.0)
_PERIOD_S = 0.51
_SWING = 0.76
"""Share of a step's period during which the foot is in the air."""
_REST_S = (0.4, 0.5)
"""Rest before and after."""


def synthetic_walks(*, seed: int = 0, frame_rate: float = 30.0) -> list[Clip]:
    """One clip ``arc_<degrees a step>`` for each curvature, to the left where positive.

    All walk at one pace, eight steps from standing to standing, so that they differ little but for
    their curvature and there are transitions between neighbours. About 60 s together.

    Args:
        seed: of the sway while standing.
        frame_rate: frames per second.

    Raises:
        MotionError: a frame rate that cannot be.
    """
    if not 1 <= frame_rate <= 10000:
        raise MotionError(got=f"frame rate {frame_rate}", expected="1 … 10000 per second")
    skeleton = synthetic_skeleton()
    degrees = [sign * angle for angle in STEP_DEG for sign in ((1, -1) if angle else (1,))]
    clips: list[Clip] = []
    for angle in degrees:
        score = Score(rng=np.random.default_rng(seed))
        score.time = _REST_S[0]
        _walk_arc(score, math.radians(angle))
        score.time += _REST_S[1]
        motion = perform(score, frame_rate)
        clips.append(Clip(name=f"arc_{angle}", skeleton=skeleton, motion=motion))
    return clips


def _walk_arc(score: Score, angle: float) -> None:
    """Steps that each turn by an angle; the foot on the inner side goes first."""
    length = _STEP_M * (1 - _SHORTER * min(abs(angle) / _NARROW, 1.0))
    here, begin, foot = score.feet[0], score.time, int(angle < 0)
    places: list[Array] = []
    for number in range(_STEPS):
        # The chord of an arc lies in the direction of half its angle.
        chord = (_FIRST_M if number == 0 else length) * np.sinc(0.5 * angle / np.pi)
        ahead = chord * np.array([math.sin(0.5 * angle), math.cos(0.5 * angle)])
        here = planar.compose(here, np.array([angle, *ahead]))
        places.append(here)
    for number, place in enumerate([*places, places[-1]]):
        slow = 1.12 if number in (0, _STEPS) else 1.0
        narrow = 0.035 if number < _STEPS - 1 else 0.0
        swing = _SWING * _PERIOD_S * slow
        score.step(foot, place, swing, height=0.06, shift=0.3, narrow=narrow)
        score.time += (1 - _SWING) * _PERIOD_S
        foot = 1 - foot
    score.time -= (1 - _SWING) * _PERIOD_S
    score.gesture(begin, 0.5, max(0.0, score.time - begin - 1.0), 0.5, {"up": 0.003})
