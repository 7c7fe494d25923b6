"""What a script can say: standing, looking, steps, turns, walks, and avoidance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mgjax.clips.procedural.parts import AVOIDANCE, gesture_of
from mgjax.clips.procedural.score import Score
from mgjax.core import planar
from mgjax.core.arrays import Array

_GLANCES = 0.5
"""How often a character that stands for a while looks aside or puts its weight on one leg."""
_WALKING = {"duck": 0.8, "slip": 0.95, "sway": 0.7, "twist": 0.7, "lean_back": 0.65}
"""Share of a part's deviations while walking."""


def idle(score: Score, seconds: str = "") -> None:
    """Stands for some seconds, by default for about one; now and then with a glance or a shift."""
    begin = score.time
    score.time += float(seconds) if seconds else score.uniform(0.95, 1.25)
    if score.time - begin < 0.9 or score.uniform(0, 1) > _GLANCES:
        return
    sign, hold = float(score.rng.choice([1, -1])), score.time - begin - 0.8
    rise = score.uniform(0.28, 0.36)
    if score.uniform(0, 1) < 0.5:
        moves = {"look": sign * score.uniform(6, 15), "nod": score.uniform(-4, 4)}
    else:
        over = score.uniform(0.012, 0.022)
        moves = {"side": sign * over, "roll": -sign * 1.5, "lean": sign * 1.5, "up": -0.004}
    score.gesture(begin + 0.08, rise, max(0.1, 0.5 * hold), 0.4, moves)


def look(score: Score) -> None:
    """Looks to one side and shifts the weight a little while standing."""
    sign = int(score.rng.choice([1, -1]))
    moves = {"look": sign * score.uniform(15, 30), "twist": sign * 4.0, "side": -sign * 0.02}
    moves |= {"roll": sign * 1.5, "nod": score.uniform(-5, 3)}
    score.time = score.gesture(score.time, 0.55, score.uniform(0.3, 0.8), 0.7, moves)


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


def walk_on(score: Score, metres: str, kind: str, direction: str = "") -> None:
    """Walks straight, and avoids on the way without standing still."""
    begin = score.time
    walk(score, metres)
    end, score.time = score.time, begin + 0.5 * (score.time - begin) - 0.5
    start = score.time
    shape = "slip" if kind == "duck" and direction else kind
    over = gesture_of(score, shape, direction, _WALKING[shape])
    score.label(start, kind, direction, end=over)
    score.time = end


VERBS: dict[str, Callable[..., None]] = {
    **AVOIDANCE,
    **{verb.__name__: verb for verb in (idle, look, step, turn, walk, walk_on)},
}
"""Each with its arguments as words."""
