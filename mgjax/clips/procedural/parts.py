"""Avoidance parts: how the procedural character gets out of the way, and in how many ways."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial

import numpy as np

from mgjax.clips.procedural.score import Jump, Score
from mgjax.clips.synthetic_skeleton import CHANNELS
from mgjax.core import planar
from mgjax.core.arrays import Array

_TABLE = """
duck       up -.22 -.34  fore -.08 -.11  pitch 15 23  bend 32 46  knees 6 10  heel 2 10  lean -3 3
           flex 26 48  elbow 58 90  turn -14 -6  open 2 10  nod -8 -2  rise .38 .46  hold .05 .18
           fall .46 .58
slip       up -.18 -.26  fore -.05 -.08  side .03 .05  pitch 10 15  bend 24 34  lean 18 26  roll 3 6
           twist 10 20  knees 4 8  flex 24 40  elbow 60 88  open 2 8  rise .34 .42  hold .05 .16
           fall .46 .56
sway       lean 44 54  roll 9 13  side -.03 -.01  up -.04 -.09  bend 6 14  open_r -4 4  open_l 8 16
           elbow_l 30 50  elbow_r 45 65  flex 12 25  twist -6 6  rise .32 .39  hold .05 .16
           fall .46 .56
lean_back  pitch -19 -23  bend -42 -51  fore .06 .08  up -.10 -.14  heel 3 8  open 10 22
           elbow 35 55  flex 28 46  rise .37 .44  hold .05 .14  fall .48 .58
twist      twist 52 64  yaw 10 16  bend -6 -2  up -.03 -.07  side -.02 -.03  elbow_l 45 65
           elbow_r 35 55  flex_r 15 25  flex_l -14 -4  open_l 8 16  rise .31 .37  hold .05 .16
           fall .46 .54
crouch     up -.48 -.53  fore -.12 -.15  pitch 24 28  bend 48 56  knees 16 22  heel 20 26
           flex 36 55  elbow 60 85  turn -12 -4  open 8 16  rise .46 .53  hold .10 .18  fall .50 .56
sidestep   up -.05 -.09  elbow_l 26 48  elbow_r 35 60  open_l 8 18  open_r 14 28  lean -5 -12
           roll 2 4  bend 4 12  twist -10 6  flex -6 14
           rise .28 .34  hold .16 .22  fall .46 .54
backstep   up -.05 -.09  elbow 30 55  open 8 16  bend 8 18  pitch 2 6  flex 12 30
           rise .28 .34  hold .16 .22  fall .46 .54
dash       up -.06 -.10  elbow 40 65  open 4 10  bend 12 22  pitch 4 8
           rise .22 .28  hold .20 .26  fall .46 .54
turn       up -.04 -.07  elbow 35 60  open 8 16  bend 2 8  lean -3 3
           rise .28 .34  hold .14 .20  fall .46 .54
"""
"""Avoidance to the left: ranges of the largest deviations (m, degrees) and of the times (s)."""
_RANGE = re.compile(r"(\w+) (-?\.?\d+) (-?\.?\d+)")
PARTS = {
    block.split()[0]: {name: (float(a), float(b)) for name, a, b in _RANGE.findall(block)}
    for block in re.split(r"\n(?=\w)", _TABLE.strip())
}
_MIRRORED = {"side", "yaw", "roll", "twist", "lean", "look", "tilt"}
_SIDES_DIFFER = 0.15
"""Of what both arms do, each does so much more or less."""
_AHEAD = {"forward": (0.0, 1.0), "back": (0.0, -1.0), "left": (1.0, 0.0), "right": (-1.0, 0.0)}


def avoid(score: Score, direction: str = "", *, kind: str) -> None:
    """One of the kinds of the table, at a strength and speed of its own, labelled."""
    start = score.time
    score.time = gesture_of(score, kind, direction)
    score.label(start, kind, direction)


def duck(score: Score, direction: str = "") -> None:
    """Ducks; with a direction, under and out to that side."""
    start = score.time
    score.time = gesture_of(score, "slip" if direction else "duck", direction)
    score.label(start, "duck", direction)


def sidestep(score: Score, direction: str) -> None:
    """A quick step to one side; the other foot follows."""
    far = _side(direction) * score.uniform(0.54, 0.66)
    place = planar.compose(score.feet[0], np.array([0.0, far, score.uniform(-0.12, 0.12)]))
    _go(score, "sidestep", direction, (_first(direction), 1 - _first(direction)), (place, place))


def backstep(score: Score) -> None:
    """A quick step back; the other foot follows."""
    away = np.array([0.0, score.uniform(-0.08, 0.08), -score.uniform(0.48, 0.58)])
    place, first = planar.compose(score.feet[0], away), int(score.rng.integers(2))
    _go(score, "backstep", "", (first, 1 - first), (place, place))


def dash(score: Score) -> None:
    """Two long quick steps forward, and the first foot closes up."""
    far, first = score.uniform(0.8, 0.95), int(score.rng.integers(2))
    half, whole = (
        planar.compose(score.feet[0], np.array([0.0, 0.0, share * far])) for share in (0.6, 1.0)
    )
    _go(score, "dash", "", (first, 1 - first, first), (half, whole, whole))


def sidle(score: Score, direction: str) -> None:
    """Steps to one side and turns the other way, so that what comes passes along the chest."""
    sign = _side(direction)
    turned = np.array(
        [-sign * np.radians(score.uniform(55, 72)), sign * score.uniform(0.34, 0.42), 0.0]
    )
    place = planar.compose(score.feet[0], turned)
    _go(score, "turn", direction, (_first(direction), 1 - _first(direction)), (place, place))


def _go(
    score: Score, kind: str, direction: str, feet: tuple[int, ...], places: tuple[Array, ...]
) -> None:
    """Quick steps with a gesture over them; the label lasts while the body is out of the way."""
    start = score.time
    gesture_of(score, kind, direction)
    score.time += score.uniform(0.1, 0.12)
    for foot, place in zip(feet, places, strict=True):
        score.step(foot, place, score.uniform(0.26, 0.29), height=0.06, shift=0.08)
        score.time += 0.02
    score.time += 0.36
    score.label(start + 0.05, kind, direction)


def jump(score: Score, direction: str = "") -> None:
    """A jump with the knees tucked, on the spot or half a metre to a side; the root's flight is a
    parabola."""
    gravity, speed, dip = 9.81, score.uniform(2.15, 2.35), score.uniform(0.13, 0.17)
    start, low, takeoff = score.time, score.time + 0.24, score.time + 0.41
    land = takeoff + 2 * speed / gravity
    knots = (
        (start, 0.0, 0.0, 0.0),
        (low, -dip, 0.0, 14.0),
        (takeoff, 0.005, speed, -gravity),
        (land, 0.005, -speed, -gravity),
        (land + 0.14, -dip, 0.0, 14.0),
        (land + 0.46, 0.0, 0.0, 0.0),
    )
    tuck = score.uniform(0.5, 0.58)
    x, z = _AHEAD.get(direction, (0.0, 0.0))
    far = score.uniform(0.42, 0.52)
    if direction:
        place = planar.compose(score.feet[0], np.array([0.0, far * x, far * z]))
        for foot in (0, 1):
            score.time = takeoff
            score.step(foot, place, land - takeoff, height=0.0, shift=0.0)
    score.jumps.append(Jump(knots=knots, takeoff_s=takeoff, land_s=land, tuck=tuck))
    dipped = {"bend": 16.0, "pitch": 10.0, "flex": -36.0, "open": 8.0, "fore": -0.06}
    score.gesture(start, 0.24, 0.0, 0.28, dipped | {"lean": 6.0 * x})
    air = {"flex": 42.0, "elbow": 50.0, "open": 14.0, "bend": 18.0, "fore": -0.04, "knees": 8.0}
    score.gesture(low, 0.36, 0.14, 0.5, _both_sides(score, air))
    score.gesture(takeoff - 0.14, 0.14, land - takeoff, 0.12, {"heel": 32.0})
    score.time = max(land + 0.46, low + 1.05)
    score.label(start, "jump", direction if x else "")


def gesture_of(score: Score, kind: str, direction: str, share: float = 1.0) -> float:
    """A gesture of the table, all its amplitudes of about one strength; mirrored for the right.

    Args:
        score: to which it is added, from now on.
        kind: of :data:`PARTS`.
        direction: ``"right"`` mirrors it.
        share: of the deviations that the table says.

    Returns:
        When it is over, s.
    """
    strength = score.uniform(0.1, 0.9)
    drawn: dict[str, float] = {}
    for name, (low, high) in PARTS[kind].items():
        value = low + (high - low) * np.clip(strength + score.uniform(-0.2, 0.2), 0, 1)
        if direction == "right":
            value = -value if name in _MIRRORED else value
            name = {"_l": name[:-1] + "r", "_r": name[:-1] + "l"}.get(name[-2:], name)
        drawn[name] = float(value)
    rise, hold, fall = (drawn.pop(name) for name in ("rise", "hold", "fall"))
    moves = {name: share * value for name, value in _both_sides(score, drawn).items()}
    return score.gesture(score.time, rise, hold, fall, moves)


def _both_sides(score: Score, moves: dict[str, float]) -> dict[str, float]:
    """Each arm with an amplitude of its own; no one's arms do quite the same."""
    apart: dict[str, float] = {}
    for name, value in moves.items():
        if name in CHANNELS or name == "heel":
            apart[name] = value
            continue
        for side in "lr":
            apart[f"{name}_{side}"] = value * (1 + score.uniform(-_SIDES_DIFFER, _SIDES_DIFFER))
    return apart


def _first(direction: str) -> int:
    return 0 if direction == "left" else 1


def _side(direction: str) -> float:
    return 1.0 if direction == "left" else -1.0


AVOIDANCE: dict[str, Callable[..., None]] = {
    **{kind: partial(avoid, kind=kind) for kind in ("sway", "lean_back", "twist", "crouch")},
    **{verb.__name__: verb for verb in (duck, sidestep, backstep, dash, sidle, jump)},
}
"""Verbs that label what they do; a direction is their argument where they have one."""
