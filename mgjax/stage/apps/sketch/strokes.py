"""From a stroke of the pen on the floor to the few points of a path."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.ndimage import gaussian_filter1d

from mgjax.core.errors import PathError

SHORTEST_M = 0.4
"""Shorter strokes are slips of the hand."""
MEET_M = 0.4
"""Where a stroke ends so near to its beginning, it is closed."""
_ROUND_M = 2.0
"""But not where it is shorter than this."""
_FINE_M = 0.04
_TREMBLE_M = 0.14
"""Width of the low pass over a stroke: a hand with a mouse trembles by a few centimetres."""
_POINT_M = 0.45
"""Distance of a smooth path's points, through which a spline leads."""
_CORNER_M = 0.07
"""A stroke farther than this from the line between two corners has another one."""
_LONGEST_M = 0.9
"""Distance of points on a straight piece at most: a much longer step counts as a jump."""


def meets(stroke: Float[np.ndarray, "N 2"]) -> bool:
    """Whether a stroke leads back to its beginning."""
    length = float(np.linalg.norm(np.diff(stroke, axis=0), axis=1).sum())
    return length >= _ROUND_M and float(np.linalg.norm(stroke[-1] - stroke[0])) <= MEET_M


def path_of_stroke(
    stroke: Float[np.ndarray, "N 2"], *, smooth: bool, closed: bool
) -> Float[np.ndarray, "M 2"]:
    """The points of a path along a stroke: every half metre of a smooth one, else its corners.

    Args:
        stroke: places of the pen, x and z, m.
        smooth: without the trembling of the hand, to be joined by a spline.
        closed: it leads back to its first point, which is not repeated.

    Returns:
        Points in whole millimetres, so that a file holds just them.

    Raises:
        PathError: a stroke of no length.
    """
    line = np.concatenate([stroke, stroke[:1]]) if closed else stroke
    fine = _evenly(line, _FINE_M)
    length = float(np.linalg.norm(np.diff(fine, axis=0), axis=1).sum())
    if length < SHORTEST_M:
        raise PathError(
            got=f"a path of {100 * length:.0f} cm", expected=f"at least {100 * SHORTEST_M:.0f} cm"
        )
    points = _smoothed(fine, closed) if smooth else _corners(fine)
    if closed:
        points = points[:-1]
    return np.round(points, 3)


def _evenly(line: Float[np.ndarray, "N 2"], spacing: float) -> Float[np.ndarray, "M 2"]:
    """Places along a line, all equally far apart, about ``spacing`` m."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, arc[-1], max(2, 1 + round(arc[-1] / spacing)))
    return np.stack([np.interp(at, arc, line[:, i]) for i in (0, 1)], axis=1)


def _smoothed(fine: Float[np.ndarray, "N 2"], closed: bool) -> Float[np.ndarray, "M 2"]:
    width = _TREMBLE_M / _FINE_M
    if closed:
        ring = gaussian_filter1d(fine[:-1], width, axis=0, mode="wrap")
        soft = np.concatenate([ring, ring[:1]])
    else:
        # Mirrored at its ends a line goes straight on there, and stays where it began.
        around = [2 * fine[:1] - fine[:0:-1], fine, 2 * fine[-1:] - fine[-2::-1]]
        whole = gaussian_filter1d(np.concatenate(around), width, axis=0, mode="nearest")
        soft = whole[len(fine) - 1 : 2 * len(fine) - 1]
    return _evenly(soft, _POINT_M)


def _corners(fine: Float[np.ndarray, "N 2"]) -> Float[np.ndarray, "M 2"]:
    """Corners such that the lines between them stay near (Ramer, Douglas and Peucker)."""
    kept, waiting = {0, len(fine) - 1}, [(0, len(fine) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        off = _off_line(fine[first + 1 : last], fine[first], fine[last])
        worst = int(np.argmax(off))
        if off[worst] > _CORNER_M:
            middle = first + 1 + worst
            kept.add(middle)
            waiting += [(first, middle), (middle, last)]
    corners = fine[sorted(kept)]
    parts = [corners[:1]]
    for start, end in zip(corners[:-1], corners[1:], strict=True):
        count = max(1, int(np.ceil(np.linalg.norm(end - start) / _LONGEST_M)))
        parts.append(start + (end - start) * np.arange(1, count + 1)[:, None] / count)
    return np.concatenate(parts)


def _off_line(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance of each point from a segment, m."""
    along = end - start
    square = max(float(along @ along), 1e-12)
    share = np.clip((points - start) @ along / square, 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * along, axis=1)
