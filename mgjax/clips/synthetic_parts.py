"""What the procedural character can do: a score of steps and gestures, written verb by verb."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from mgjax.clips.synthetic_skeleton import BALLS, LAG_S, Gesture, ball_place
from mgjax.clips.types import Label
from mgjax.core import planar
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


_TABLE = """
duck       up -.24 -.32  fore -.09 -.11  pitch 16 22  bend 34 44  knees 6 10  heel 2 10
           flex 30 45  elbow 60 80  turn -14 -6  open 2 8  rise .40 .46  hold .06 .20  fall .44 .52
sway       lean 46 54  roll 9 13  side -.03 -.01  up -.04 -.08  bend 6 14  open_r -8 0
           elbow 40 60  flex 12 25  rise .34 .40  hold .05 .16  fall .42 .50
lean_back  pitch -20 -23  bend -44 -51  fore .06 .08  up -.10 -.14  heel 3 8  open 6 14
           elbow 35 55  flex 28 42  rise .38 .44  hold .05 .16  fall .46 .54
twist      twist 54 64  yaw 10 16  bend -6 -2  up -.03 -.06  side -.01 -.03  elbow_l 45 65
           elbow_r 35 55  flex_r 15 25  open_l 8 14  rise .31 .37  hold .05 .16  fall .42 .50
crouch     up -.48 -.52  fore -.13 -.15  pitch 24 28  bend 49 56  knees 16 22  heel 20 26
           flex 40 55  elbow 60 80  turn -12 -4  open 8 14  rise .50 .53  hold .12 .18  fall .51 .54
sidestep   up -.04 -.07  elbow 30 50  open 8 14  lean -4 -8
           rise .30 .34  hold .08 .12  fall .46 .50
"""
"""Avoidance to the left: ranges of the largest deviations (m, degrees) and of the times (s)."""
_RANGE = re.compile(r"(\w+) (-?\.?\d+) (-?\.?\d+)")
PARTS = {
    block.split()[0]: {name: (float(a), float(b)) for name, a, b in _RANGE.findall(block)}
    for block in re.split(r"\n(?=\w)", _TABLE.strip())
}
_MIRRORED = {"side", "yaw", "roll", "twist", "lean", "look", "tilt"}


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

    def label(self, start: float, kind: str, direction: str = "") -> None:
        """Labels everything from ``start`` on."""
        begin, end = round(start, 3), round(self.time, 3)
        self.labels.append(Label(start_s=begin, end_s=end, kind=kind, direction=direction))

    def uniform(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))


def idle(score: Score, seconds: str = "") -> None:
    """Stands for some seconds, by default for a little more than one."""
    score.time += float(seconds) if seconds else score.uniform(1.05, 1.4)


def look(score: Score) -> None:
    """Looks to one side and shifts the weight a little while standing."""
    sign = int(score.rng.choice([1, -1]))
    moves = {"look": sign * score.uniform(15, 30), "twist": sign * 4.0, "side": -sign * 0.015}
    score.time = score.gesture(score.time, 0.6, score.uniform(0.3, 0.8), 0.7, moves)


def step(score: Score, direction: str) -> None:
    """One small step with both feet, in a direction of the character's own."""
    x, z = {"forward": (0, 1), "back": (0, -1), "left": (1, 0), "right": (-1, 0)}[direction]
    far = score.uniform(0.25, 0.36) if z else score.uniform(0.2, 0.3)
    place = planar.compose(score.feet[0], np.array([0.0, x * far, z * far]))
    first = {"left": 0, "right": 1}.get(direction, int(score.rng.integers(2)))
    score.step(first, place, score.uniform(0.45, 0.52))
    score.time += 0.1
    score.step(1 - first, place, score.uniform(0.45, 0.52))


def turn(score: Score, degrees: str) -> None:
    """Turns in place with stepping feet, to the left where positive, about 45° a pair of steps."""
    angle = np.radians(float(degrees))
    pairs, first = max(1, round(abs(angle) / (0.25 * np.pi))), int(angle < 0)
    for _ in range(pairs):
        place = planar.compose(score.feet[0], np.array([angle / pairs, 0.0, 0.0]))
        for foot in (first, 1 - first):
            score.step(foot, place, score.uniform(0.42, 0.48), shift=0.4)
            score.time += 0.08


def walk(score: Score, metres: str, degrees: str = "0") -> None:
    """Walks an arc of some length that turns by some degrees, from standing to standing."""
    length, angle = float(metres), np.radians(float(degrees))
    lengths = [0.45, *score.rng.uniform(0.57, 0.63, round((length - 0.45) / 0.6))]
    lengths = length * np.array(lengths) / np.sum(lengths)
    origin, begin = score.feet[0], score.time
    period = score.uniform(0.49, 0.53)
    foot = int(score.rng.integers(2)) if angle == 0 else int(angle < 0)
    places: list[Array] = []
    for s in np.cumsum(lengths):
        # The chord of an arc lies in the direction of half its angle.
        a = angle * s / length
        chord = s * np.sinc(0.5 * a / np.pi)
        ahead = np.array([a, chord * np.sin(0.5 * a), chord * np.cos(0.5 * a)])
        places.append(planar.compose(origin, ahead))
    for k, place in enumerate([*places, places[-1]]):
        slow = 1.12 if k in (0, len(places)) else 1.0
        narrow = 0.035 if k < len(places) - 1 else 0.0
        score.step(foot, place, 0.76 * period * slow, height=0.06, shift=0.3, narrow=narrow)
        score.time += 0.24 * period
        foot = 1 - foot
    score.time -= 0.24 * period
    score.gesture(begin, 0.5, max(0.0, score.time - begin - 1.0), 0.5, {"up": 0.003})


def avoid(score: Score, direction: str = "", *, kind: str) -> None:
    """One of the kinds of the table, at a strength and speed of its own, labelled."""
    start = score.time
    score.time = _gesture(score, kind, direction)
    score.label(start, kind, direction)


def sidestep(score: Score, direction: str) -> None:
    """A quick step to one side; the other foot follows."""
    start, first, sign = score.time, *((0, 1) if direction == "left" else (1, -1))
    far = sign * score.uniform(0.54, 0.64)
    place = planar.compose(score.feet[0], np.array([0.0, far, 0.0]))
    _gesture(score, "sidestep", direction)
    score.time += 0.12
    score.step(first, place, score.uniform(0.27, 0.3), height=0.06, shift=0.0)
    score.time += 0.02
    score.step(1 - first, place, score.uniform(0.27, 0.3), height=0.06, shift=0.05)
    score.time += 0.22
    score.label(start, "sidestep", direction)


def jump(score: Score) -> None:
    """A jump on the spot with the knees tucked; the root's flight is a parabola."""
    gravity, speed, dip = 9.81, score.uniform(2.2, 2.35), score.uniform(0.13, 0.17)
    start, low, takeoff = score.time, score.time + 0.24, score.time + 0.41
    land = takeoff + 2 * speed / gravity
    knots = (
        (start, 0.0, 0.0, 0.0),
        (low, -dip, 0.0, 14.0),
        (takeoff, 0.005, speed, -gravity),
        (land, 0.005, -speed, -gravity),
        (land + 0.14, -dip, 0.0, 14.0),
        (land + 0.4, 0.0, 0.0, 0.0),
    )
    tuck = score.uniform(0.5, 0.58)
    score.jumps.append(Jump(knots=knots, takeoff_s=takeoff, land_s=land, tuck=tuck))
    dipped = {"bend": 16.0, "pitch": 10.0, "flex": -36.0, "open": 8.0, "fore": -0.06}
    score.gesture(start, 0.24, 0.0, 0.28, dipped)
    air = {"flex": 42.0, "elbow": 50.0, "open": 12.0, "bend": 18.0, "fore": -0.04, "knees": 8.0}
    score.gesture(low, 0.36, 0.14, 0.45, air)
    score.gesture(takeoff - 0.14, 0.14, land - takeoff, 0.12, {"heel": 32.0})
    score.time = max(land + 0.4, low + 1.0)
    score.label(start, "jump")


def _gesture(score: Score, kind: str, direction: str) -> float:
    """A gesture of the table, all its amplitudes of about one strength; mirrored for the right."""
    strength = score.uniform(0.1, 0.9)
    drawn: dict[str, float] = {}
    for name, (low, high) in PARTS[kind].items():
        value = low + (high - low) * np.clip(strength + score.uniform(-0.2, 0.2), 0, 1)
        if direction == "right":
            value = -value if name in _MIRRORED else value
            name = {"_l": name[:-1] + "r", "_r": name[:-1] + "l"}.get(name[-2:], name)
        drawn[name] = float(value)
    rise, hold, fall = (drawn.pop(name) for name in ("rise", "hold", "fall"))
    return score.gesture(score.time, rise, hold, fall, drawn)


VERBS: dict[str, Callable[..., None]] = {
    **{kind: partial(avoid, kind=kind) for kind in PARTS},
    **{verb.__name__: verb for verb in (idle, look, step, turn, walk, sidestep, jump)},
}
"""What a script can say, each with its arguments as words."""
