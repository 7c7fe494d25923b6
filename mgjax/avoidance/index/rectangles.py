"""Where the columns of each path of the grid index can be: a rectangle around its part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.index.cells import CELL_M, SPAN
from mgjax.avoidance.index.part_volumes import ROUNDING_M, PartVolumes
from mgjax.avoidance.index.paths import Paths
from mgjax.core import planar


@dataclass(frozen=True, kw_only=True, eq=False)
class Rectangles:
    """The columns among which those of each path are.

    Attributes:
        origin: lowest column. [P]
        width, area: columns along z, and of all. [P]
        place: x and z of the rectangle's lowest corner, in the part's frame from the corner of its
            raster, m; cosine and sine of the turn of the part's frame in the node's. [P, 4]
    """

    origin: Int[np.ndarray, " P"]
    width: Int[np.ndarray, " P"]
    area: Int[np.ndarray, " P"]
    place: Float[np.ndarray, "P 4"]


def rectangles(paths: Paths, volumes: PartVolumes) -> Rectangles:
    """Around the outline of each path's part, placed by the path."""
    low = np.zeros((len(paths.part), 2), np.int64)
    high = low - 1
    c, s = np.cos(paths.place[:, 0]), np.sin(paths.place[:, 0])
    for part in np.flatnonzero([len(outline) for outline in volumes.outlines]):
        own = np.flatnonzero(paths.part == part)
        rows = np.array([[c[own], s[own]], [-s[own], c[own]]])  # of planar.apply, for x and z
        for axis in range(2):
            moved = volumes.outlines[part] @ rows[axis] + paths.place[own, 1 + axis]
            low[own, axis] = np.floor((moved.min(axis=0) - ROUNDING_M) / CELL_M)
            high[own, axis] = np.floor((moved.max(axis=0) + ROUNDING_M) / CELL_M)
    low, high = np.maximum(low, -SPAN // 2), np.minimum(high, SPAN // 2 - 1)
    size = np.maximum(high - low + 1, 0)
    size[(size == 0).any(axis=1)] = 0
    low[size[:, 0] == 0] = 0
    corner = np.stack([low[:, 0] * CELL_M, np.zeros(len(low)), low[:, 1] * CELL_M], axis=1)
    local = np.asarray(planar.apply(planar.inverse(paths.place), corner))[:, [0, 2]]
    place = [local - volumes.corner[paths.part], c[:, None], s[:, None]]
    return Rectangles(
        origin=(low[:, 0] + SPAN // 2) * SPAN + low[:, 1] + SPAN // 2,
        width=np.maximum(size[:, 1], 1),
        area=size.prod(axis=1),
        place=np.concatenate(place, axis=1).astype(np.float32),
    )
