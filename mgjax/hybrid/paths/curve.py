"""The sketched path as a curve by arc length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from mgjax.hybrid.paths.sketch import Sketch

SAMPLES = 65536
"""Places at which the search reads the path. The number is fixed, so that the search is compiled
once; a short path uses the first of them."""

SPACING_M = 0.001
"""Distance of two of these places for an adult on paths up to 65 m; on longer ones it is more."""

_FINE_M = 0.005
"""Length of the chords that a spline is made of, for an adult."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """A polyline with its arc length; a spline is one with many short chords.

    Attributes:
        points: corners, x and z, m. A closed path ends where it begins. [M, 2]
        arc: arc length at the corners, from 0, m. [M]
        speed: wanted speed at the corners, m/s; NaN where none is wanted. [M]
        closed: whether the path leads back to its beginning.
        scale: of the body that walks along it (:func:`mgjax.core.body.height.body_scale`): how
            finely, and how far ahead, it is looked at.
    """

    points: Float[np.ndarray, "M 2"]
    arc: Float[np.ndarray, " M"]
    speed: Float[np.ndarray, " M"]
    closed: bool
    scale: float = 1.0

    @property
    def length(self) -> float:
        """Arc length of the whole path, m."""
        return float(self.arc[-1])

    def at(self, arc: Float[np.ndarray, "*s"]) -> Float[np.ndarray, "*s 2"]:
        """P(s): the places at these arc lengths; before the beginning and after the end those."""
        return np.stack([np.interp(arc, self.arc, self.points[:, i]) for i in (0, 1)], axis=-1)

    def start(self) -> Float[np.ndarray, "3"]:
        """The planar frame of a body that stands at the beginning and faces along the path."""
        ahead = self.at(np.array(min(0.2 * self.scale, self.length))) - self.points[0]
        return np.array([np.arctan2(ahead[0], ahead[1]), *self.points[0]])

    def nearest(
        self, places: Float[np.ndarray, "F 2"], arc: Float[np.ndarray, " F"], reach: float = 1.5
    ) -> tuple[Float[np.ndarray, " F"], Float[np.ndarray, " F"]]:
        """Distance of each place to the part of the path around its arc length, and where on it.

        Only the part within ``reach`` m of the arc length, for an adult, counts: on a path that
        crosses itself the nearest point may belong to another time.

        Returns:
            Distances and arc lengths of the nearest points, m.
        """
        offsets = self.scale * np.arange(-reach, reach + 0.005, 0.01)
        near = np.clip(arc[:, None] + offsets, 0.0, self.length)
        away = np.linalg.norm(self.at(near) - places[:, None], axis=-1)
        row, best = np.arange(len(places)), away.argmin(axis=1)
        return away[row, best], near[row, best]


def make_curve(sketch: Sketch, scale: float = 1.0) -> Curve:
    """The curve through a sketch's points, straight between them or a spline.

    ``scale`` is that of the body; see :class:`Curve`.

    The spline is a cubic through all points, its parameter the root of the chord length
    (centripetal), so that it neither loops nor swings far where points crowd.
    """
    points, speed = sketch.points, sketch.speed
    if sketch.closed:
        points, speed = (np.concatenate([x, x[:1]]) for x in (points, speed))
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if sketch.spline and len(points) > 2:
        knots = np.concatenate([[0.0], np.cumsum(np.sqrt(chords))])
        ends = "periodic" if sketch.closed else "natural"
        counts = np.maximum(np.ceil(chords / (scale * _FINE_M)).astype(int), 1)
        fine = [
            np.linspace(a, b, n, endpoint=False)
            for a, b, n in zip(knots[:-1], knots[1:], counts, strict=True)
        ]
        at = np.concatenate([*fine, knots[-1:]])
        speed = np.interp(at, knots, speed)
        points = np.asarray(CubicSpline(knots, points, bc_type=ends)(at))
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(chords)])
    return Curve(points=points, arc=arc, speed=speed, closed=sketch.closed, scale=scale)
