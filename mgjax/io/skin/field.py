"""The distance to a body made of shapes that flow into one another where they belong together.

A shape is a capsule with two radii and, across its axis, a breadth and a depth. Two shapes are
joined as after Quilez' polynomial smooth minimum, whose width shrinks to nothing where both
surfaces look the same way (after Gourmel and others, *A Gradient-Based Implicit Blend*, 2013):
along a straight limb nothing bulges, and an armpit is filled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.io.skin.bones import Capsule

NOWHERE, TRUNK = -1, -2
"""What a shape is joined to, if not to another shape: nothing, or all shapes of the trunk."""

_ALIKE = 0.8
"""Surfaces whose normals have a larger cosine are not blended."""
_EDGE = 0.4
"""A sole's edge is rounded by this share of the blend."""
_FAR = 1e3


@dataclass(frozen=True, kw_only=True)
class Shape:
    """A capsule and what it is joined to.

    Attributes:
        capsule: the shape.
        onto: index of an earlier shape, or :data:`TRUNK`, or :data:`NOWHERE`.
        trunk: it is part of the trunk, whose shapes are all joined in their order.
        floor: height at which it is cut off flat below, m; None where it is not.
    """

    capsule: Capsule
    onto: int = NOWHERE
    trunk: bool = False
    floor: float | None = None


@dataclass(frozen=True)
class _Values:
    """Distances and where they grow, at some points. [P], [P,3]"""

    distance: Float[np.ndarray, " P"]
    slope: Float[np.ndarray, "P 3"]

    def at(self, mask: np.ndarray) -> _Values:
        return _Values(self.distance[mask], self.slope[mask])


def body_distance(
    shapes: Sequence[Shape], points: Float[np.ndarray, "P 3"], blend: float
) -> Float[np.ndarray, " P"]:
    """Distance of points to the body's surface, negative inside; far away only that it is far.

    Args:
        shapes: of which the body is made.
        points: m.
        blend: how far apart two surfaces still flow into one another, m.
    """
    best = np.full(len(points), _FAR)
    reach = 3 * blend
    trunk: _Values | None = None
    for shape in (s for s in shapes if s.trunk):
        one = _shape(shape, points, blend)
        trunk = one if trunk is None else _join(trunk, one, blend)
    if trunk is not None:
        best = np.minimum(best, trunk.distance)
    for shape in (s for s in shapes if not s.trunk):
        near = _near(shape.capsule, points, reach)
        if not near.any():
            continue
        one = _shape(shape, points[near], blend)
        if shape.onto == TRUNK and trunk is not None:
            one = _join(one, trunk.at(near), blend)
        elif shape.onto >= 0:
            one = _join(one, _shape(shapes[shape.onto], points[near], blend), blend)
        best[near] = np.minimum(best[near], one.distance)
    return best


def _near(capsule: Capsule, points: np.ndarray, reach: float) -> np.ndarray:
    thick = max(capsule.radii) * max(capsule.width, capsule.depth, 1.0) + reach
    low = np.minimum(capsule.start, capsule.end) - thick
    high = np.maximum(capsule.start, capsule.end) + thick
    return np.asarray(((points > low) & (points < high)).all(axis=1))


def _shape(shape: Shape, points: np.ndarray, blend: float) -> _Values:
    values = capsule_distance(shape.capsule, points)
    if shape.floor is None:
        return values
    down = np.broadcast_to(np.array([0.0, -1.0, 0.0]), points.shape)
    inside = _Values(-values.distance, -values.slope)
    above = _Values(points[:, 1] - shape.floor, -down)
    cut = _join(inside, above, _EDGE * blend)
    return _Values(-cut.distance, -cut.slope)


def capsule_distance(capsule: Capsule, points: Float[np.ndarray, "P 3"]) -> _Values:
    """Distance to a capsule's surface, to first order where it is not round."""
    axis, across, over = capsule.frame()
    away = points - capsule.start
    along, u, v = away @ axis, away @ across / capsule.width, away @ over / capsule.depth
    out = np.sqrt(u * u + v * v) + 1e-12
    length = float(np.linalg.norm(capsule.end - capsule.start))
    first, last = capsule.radii
    tilt = float(np.clip((first - last) / max(length, 1e-9), -0.95, 0.95))
    upright = float(np.sqrt(1 - tilt * tilt))
    where = upright * along - tilt * out
    beyond = along - length
    start, end = np.hypot(out, along) + 1e-12, np.hypot(out, beyond) + 1e-12
    before, after = where < 0, where > upright * length
    distance = np.where(
        before, start - first, np.where(after, end - last, out * upright + along * tilt - first)
    )
    radial = np.where(before, out / start, np.where(after, out / end, upright))
    axial = np.where(before, along / start, np.where(after, beyond / end, tilt))
    slope = axial[:, None] * axis + (radial / out)[:, None] * (
        (u / capsule.width)[:, None] * across + (v / capsule.depth)[:, None] * over
    )
    steep = np.linalg.norm(slope, axis=1) + 1e-12
    return _Values(distance / steep, slope / steep[:, None])


def _join(a: _Values, b: _Values, blend: float) -> _Values:
    """The smooth minimum; ``blend`` is its width where the surfaces look opposite ways."""
    cosine = np.einsum("px,px->p", a.slope, b.slope)
    width = blend * np.clip(_ALIKE - cosine, 1e-6, 1.0)
    left = np.maximum(width - np.abs(a.distance - b.distance), 0.0)
    share = 0.5 * left / width
    first = a.distance <= b.distance
    towards = np.where(first, share, 1 - share)[:, None]
    slope = (1 - towards) * a.slope + towards * b.slope
    slope /= np.linalg.norm(slope, axis=1, keepdims=True) + 1e-12
    return _Values(np.minimum(a.distance, b.distance) - 0.5 * left * share, slope)
