"""The unit of a file that does not state one: the one in which the bones make a body."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Unit:
    """A unit of length and how many metres it has."""

    name: str
    metres: float


UNITS = {
    "m": Unit(name="metre", metres=1.0),
    "cm": Unit(name="centimetre", metres=0.01),
    "mm": Unit(name="millimetre", metres=0.001),
    "dm": Unit(name="decimetre", metres=0.1),
    "in": Unit(name="inch", metres=0.0254),
    "ft": Unit(name="foot", metres=0.3048),
    "cmu": Unit(name="CMU unit (0.0254/0.45 m)", metres=0.0254 / 0.45),
}

BODY_HEIGHT_M, BODY_SPREAD = 1.65, 0.15
"""Heights of captured people: the usual one, and the standard deviation of its logarithm."""

MARGIN = 2.3
"""Two units are about as likely where their log likelihoods differ by less: ten to one."""

_RARE = {"dm": -1.5, "ft": -1.5, "mm": -0.5}
"""Log of how much rarer a unit is in files than metre, centimetre, inch and CMU's."""

_NO_BODY = ("m", "cm", "cmu")


@dataclass(frozen=True, kw_only=True)
class FoundUnit:
    """A unit that was found.

    Attributes:
        unit: the most likely one.
        probability: how sure that is, 0 … 1; 1 where the file or a user says so.
        rival: another that is about as likely, or None.
    """

    unit: Unit
    probability: float
    rival: Unit | None = None


def unit_of_body(height: float) -> FoundUnit:
    """The unit of a body that is ``height`` of it tall, by the heights of captured people.

    A height between those of two units, such as 21 (1.2 m in CMU's unit or 2.1 m in decimetres),
    has a ``rival``.
    """
    score: dict[str, float] = {}
    for key, unit in UNITS.items():
        off = math.log(height * unit.metres / BODY_HEIGHT_M) / BODY_SPREAD
        score[key] = -0.5 * off * off + _RARE.get(key, 0.0)
    first, second = sorted(score, key=lambda k: -score[k])[:2]
    total = sum(math.exp(s - score[first]) for s in score.values())
    close = score[first] - score[second] < MARGIN
    return FoundUnit(
        unit=UNITS[first], probability=1 / total, rival=UNITS[second] if close else None
    )


def unit_of_thing(offsets: np.ndarray, parents: tuple[int, ...]) -> FoundUnit:
    """The unit of what is no human body: where its rest pose is nearest to 1.6 m, a mere guess.

    Args:
        offsets: [J,3], in the unknown unit; the root's is a place, not a bone.
        parents: parent of each joint, −1 for the root.
    """
    places = np.zeros_like(offsets)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            places[joint] = places[parent] + offsets[joint]
    extent = np.ptp(places, axis=0)
    size = float(extent[1]) if extent[1] > 1e-6 else float(extent.max())
    if not size > 1e-9:
        return FoundUnit(unit=UNITS["m"], probability=0.0)
    units = [UNITS[key] for key in _NO_BODY]
    nearest = min(units, key=lambda u: abs(math.log(size * u.metres / 1.6)))
    return FoundUnit(unit=nearest, probability=0.0)
