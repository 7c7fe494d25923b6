"""A score: the steps, gestures and jumps of a clip in the making, and its labels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mgjax.clips.procedural.gestures import LAG_S, Gesture
from mgjax.clips.synthetic_skeleton import BALLS, ball_place
from mgjax.clips.types import Label
from mgjax.core.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Step:
    """One foot is lifted, carried and planted.

    A foot's place is given by where the body would stand if this foot were in its neutral place
    under it: a planar transform (θ, x, z).

    Attributes:
        foot: 0 the left, 1 the right one.
        lift_s, land_s: when the ball of the foot leaves the floor and is back.
        start, end: places before and after.
        travel: what the ball of the foot does from the one to the other, m.
        height: lift of the ball of the foot, m.
        shift: share of the way over to the standing foot that the pelvis goes.
    """

    foot: int
    lift_s: float
    land_s: float
    start: Array
    end: Array
    travel: Array
    height: float
    shift: float


@dataclass(frozen=True, kw_only=True)
class Jump:
    """The root goes through ``knots`` (s, m over neutral, m/s, m/s²); the feet rise by ``tuck``."""

    knots: tuple[tuple[float, float, float, float], ...]
    takeoff_s: float
    land_s: float
    tuck: float


@dataclass(kw_only=True)
class Score:
    """A clip in the making: what happens when, up to ``time``, and where the feet then stand."""

    rng: np.random.Generator
    time: float = 0.0
    feet: list[Array] = field(default_factory=lambda: [np.zeros(3), np.zeros(3)])
    balls: list[Array] = field(default_factory=lambda: list(BALLS))
    steps: list[Step] = field(default_factory=list)
    gestures: list[Gesture] = field(default_factory=list)
    jumps: list[Jump] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)

    def step(self, foot: int, place: Array, seconds: float, **manner: float) -> None:
        """The foot goes to ``place``, beginning now; the score's time moves on to its landing.

        ``manner``: height and shift of the :class:`Step`; narrow: how much nearer to the middle
        than neutral the foot lands, m.
        """
        ball = ball_place(place, foot, manner.get("narrow", 0.0))
        self.steps.append(
            Step(
                foot=foot,
                lift_s=self.time,
                land_s=self.time + seconds,
                start=self.feet[foot],
                end=place,
                travel=ball - self.balls[foot],
                height=manner.get("height", 0.07),
                shift=manner.get("shift", 0.5),
            )
        )
        self.feet[foot], self.balls[foot], self.time = place, ball, self.time + seconds

    def gesture(
        self, start: float, rise: float, hold: float, fall: float, moves: Mapping[str, float]
    ) -> float:
        """Adds a gesture; returns when it is over."""
        gesture = Gesture(start_s=start, rise_s=rise, hold_s=hold, fall_s=fall, moves=moves)
        self.gestures.append(gesture)
        return start + rise + hold + fall + max(LAG_S.values())

    def label(self, start: float, kind: str, direction: str = "", *, end: float = 0.0) -> None:
        """Labels everything from ``start`` to ``end``, by default to now."""
        begin, end = round(start, 3), round(end or self.time, 3)
        self.labels.append(Label(start_s=begin, end_s=end, kind=kind, direction=direction))

    def uniform(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))
