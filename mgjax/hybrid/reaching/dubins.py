"""The shortest way of two turns and a straight line between two places with headings."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float


def dubins(
    begin: Float[np.ndarray, "3"], end: Float[np.ndarray, "3"], radius: float, step: float
) -> Float[np.ndarray, "M 2"]:
    """Points along the shortest way of turns of one radius and a straight line (Dubins 1957).

    Ways of three turns are left out; where they are shorter the two places lie within two circles,
    and one with a straight line is little longer.

    Args:
        begin, end: planar frames (θ, x, z): the way leaves and arrives along their +Z.
        radius: of the turns, m.
        step: distance of the points, m.
    """
    best: tuple[float, np.ndarray] | None = None
    for first in (1.0, -1.0):
        for last in (1.0, -1.0):
            parts = _parts(begin, end, first, last, radius)
            if parts is None:
                continue
            length = radius * (parts[0] + parts[2]) + parts[1]
            if best is None or length < best[0]:
                best = length, _points(begin, parts, first, last, radius, step)
    assert best is not None  # turns to the same side always have a way
    return best[1]


def _centre(frame: np.ndarray, side: float, radius: float) -> np.ndarray:
    """Centre of the turn to the left (side +1) or right (−1): θ grows to the left."""
    return frame[1:] + side * radius * np.array([math.cos(frame[0]), -math.sin(frame[0])])


def _parts(
    begin: np.ndarray, end: np.ndarray, first: float, last: float, radius: float
) -> tuple[float, float, float] | None:
    """Angle of the first turn, length of the line, angle of the last turn."""
    between = _centre(end, last, radius) - _centre(begin, first, radius)
    distance = float(np.hypot(*between))
    bearing = math.atan2(between[0], between[1]) if distance > 1e-9 else begin[0]
    if first == last:
        line, heading = distance, bearing
    else:
        if distance < 2 * radius:
            return None
        line = math.sqrt(distance * distance - 4 * radius * radius)
        # The line crosses from one circle to the other.
        heading = bearing + first * math.asin(2 * radius / distance)
    turn = 2 * math.pi
    turn_first = (first * (heading - begin[0])) % turn
    turn_last = (last * (end[0] - heading)) % turn
    turns = [0.0 if turn - t < 1e-6 else t for t in (turn_first, turn_last)]
    return turns[0], line, turns[1]


def _points(
    begin: np.ndarray,
    parts: tuple[float, float, float],
    first: float,
    last: float,
    radius: float,
    step: float,
) -> np.ndarray:
    heading, place = float(begin[0]), begin[1:].astype(np.float64)
    points = [place[None]]
    for amount, side in ((parts[0], first), (parts[1], 0.0), (parts[2], last)):
        length = amount * radius if side else amount
        if length < 1e-9:
            continue
        arc = np.linspace(0, length, max(math.ceil(length / step), 1) + 1)[1:]
        if side:
            angle = heading + side * arc / radius
            centre = _centre(np.array([heading, *place]), side, radius)
            outwards = np.stack([np.cos(angle), -np.sin(angle)], axis=-1)
            points.append(centre - side * radius * outwards)
            heading = float(angle[-1])
        else:
            points.append(place + arc[:, None] * np.array([math.sin(heading), math.cos(heading)]))
        place = points[-1][-1]
    return np.concatenate(points)
