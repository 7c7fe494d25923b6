"""The cells that an attack touches, as far as a look-up has to know them (§5.1).

Whether a cell meets a swept sphere is costly to say exactly, and seldom asked: nearly every path
that is touched is touched in a cell whose middle is no farther than the radius and half an edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt32

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.index.cells import (
    CELL_M,
    COVERED,
    HEIGHTS,
    LOWEST,
    SPAN,
    box_gap,
    swept_lines,
    touched_cells,
)

_SLACK_M = 2e-4
"""For rounding, and for lines that count as straight, which are off by half of it at most."""
_SURE_M, _PERHAPS_M = 0.5 * CELL_M - _SLACK_M, 0.8661 * CELL_M + _SLACK_M
"""A ball of half an edge is inside the cell, and one of half a diagonal around it."""
_LEAST_M = 0.03
"""Distances below are too small for the digits of the numbers here; what they limit is left out."""
_CHORD_M, _LONGEST_M, _MOST_CHORDS = 0.01, 4.0, 32
"""How far chords may be from a curved line, about; how long they are, and how many."""
_FEW_CHORDS = 6
"""With more of them it is as quick to find all cells that are touched."""
_LOW, _HIGH = COVERED.tolist()
_SHAPE = (SPAN, HEIGHTS, SPAN)
_MIDDLES = [
    ((np.arange(a, b) + 0.5) * CELL_M).astype(np.float32) for a, b in zip(_LOW, _HIGH, strict=True)
]
_BITS = 2.0 ** np.arange(HEIGHTS)
"""In numbers of 53 bits, whose sums are exact and quick."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Chords:
    """Capsules around straight lines that are close to those that an attack's centres take.

    Attributes:
        start, stop: of the lines, m. [B, 3]
        radii: m. [B]
        off: how far each line is at most from what it stands for, m.
    """

    start: Float[np.ndarray, "B 3"]
    stop: Float[np.ndarray, "B 3"]
    radii: Float[np.ndarray, " B"]
    off: float


@dataclass(frozen=True, kw_only=True, eq=False)
class _Near:
    """Cells around one chord.

    Attributes:
        low: the first cell.
        squared: distance from the middle of each cell to the chord, m². [Y, X, Z]
        sure, perhaps: up to which distance a cell is touched for sure or perhaps, m.
    """

    low: list[int]
    squared: Float32[np.ndarray, "Y X Z"]
    sure: float
    perhaps: float


@dataclass(frozen=True, kw_only=True, eq=False)
class SweptCells:
    """The cells that an attack touches, column by column.

    Attributes:
        first: number of the first column of ``sure`` and ``perhaps()``.
        sure: bit b says that cell LOWEST + b of a column is touched for sure. The first column and
            the last are empty. [S]
        attack, crop: what is swept.
        chords: about the same, and ``near``, the cells around each of them.
    """

    first: int
    sure: UInt32[np.ndarray, " S"]
    attack: Attack
    crop: Crop
    chords: _Chords
    near: list[_Near]

    @property
    def heights(self) -> tuple[int, int]:
        """The lowest bit of ``sure``, and the one after the highest."""
        bits = int(np.bitwise_or.reduce(self.sure))
        return max((bits & -bits).bit_length() - 1, 0), bits.bit_length()

    def perhaps(self) -> UInt32[np.ndarray, " S"]:
        """Which cells are touched, or may be: of the latter :meth:`touches` has to say it."""
        bits = np.zeros(len(self.sure), np.uint32)
        for near in self.near:
            _mark(bits, self.first, near, near.perhaps)
        return bits

    def touches(self, cells: Int[np.ndarray, "M 3"]) -> Bool[np.ndarray, " M"]:
        """Whether covered cells are among those of ``touched_cells``."""
        keys, which = np.unique(_keys(cells), return_inverse=True)
        if len(self.near) <= _FEW_CHORDS:
            cells = np.stack(np.unravel_index(keys, _SHAPE), axis=1) + COVERED[0]
            gap = self._gaps(cells)
            if (np.abs(gap) > self.chords.off + _SLACK_M).all():
                return (gap < 0)[which]
        known = touched_cells(self.attack, self.crop)
        assert known is not None  # as they are covered
        return np.isin(keys, _keys(known))[which]

    def _gaps(self, cells: Int[np.ndarray, "M 3"]) -> Float[np.ndarray, " M"]:
        """Distances from cells to the nearest capsule around a chord."""
        chords = self.chords
        chord, cell = np.divmod(np.arange(len(self.near) * len(cells)), len(cells))
        displacement = chords.stop - chords.start
        gap = box_gap(chords.start[chord], displacement[chord], cells[cell] * CELL_M)
        return (gap - chords.radii[chord]).reshape(-1, len(cells)).min(axis=0)


def _keys(cells: Int[np.ndarray, "M 3"]) -> Int[np.ndarray, " M"]:
    """A number for each covered cell."""
    x, y, z = (cells - COVERED[0]).T
    return (x * _SHAPE[1] + y) * _SHAPE[2] + z


def swept_cells(attack: Attack, crop: Crop) -> SweptCells | None:
    """The cells of :func:`~mgjax.avoidance.index.cells.touched_cells`, in the form to look up.

    Args:
        attack: in the planar frame of the node whose cells are meant.
        crop: the part that counts.

    Returns:
        The cells, or None if some are outside the space that indices cover, or if there are none.
    """
    chords = _straight(attack, crop) or _curved(attack, crop)
    if not len(chords.radii):
        return None
    starts, stops, radii = chords.start.tolist(), chords.stop.tolist(), chords.radii.tolist()
    if not _is_covered(starts + stops, max(radii) + chords.off):
        cells = touched_cells(attack, crop)  # the last word
        if cells is None or (cells < COVERED[0]).any() or (cells >= COVERED[1]).any():
            return None
    spheres = zip(starts, stops, radii, strict=True)
    near = [_near(start, stop, radius, chords.off) for start, stop, radius in spheres]
    low = min(sphere.low[0] for sphere in near) - 1
    high = max(sphere.low[0] + sphere.squared.shape[1] for sphere in near)
    first = (low + SPAN // 2) * SPAN
    sure = np.zeros((high - low + 1) * SPAN, np.uint32)
    for sphere in near:
        _mark(sure, first, sphere, sphere.sure)
    return SweptCells(first=first, sure=sure, attack=attack, crop=crop, chords=chords, near=near)


def _is_covered(places: list[list[float]], reach: float) -> bool:
    """Whether balls around places are in the space that indices cover, with some room to spare."""
    reach += _SLACK_M
    return all(
        low * CELL_M < min(along) - reach and max(along) + reach < high * CELL_M
        for low, high, along in zip(_LOW, _HIGH, zip(*places, strict=True), strict=True)
    )


def _straight(attack: Attack, crop: Crop) -> _Chords | None:
    """The lines of an attack whose spheres move straight and evenly, None if they do not."""
    if attack.starts is not None or attack.stops is not None or attack.acceleration > 0:
        return None
    first = max(int(attack.times.searchsorted(crop.start, "right")) - 1, 0)
    stop = int(attack.times.searchsorted(crop.end)) + 1
    times, lines = attack.times[first:stop], attack.centres[first:stop]
    begin, span = float(times[0]), max(float(times[-1] - times[0]), 1e-12)
    displacement = lines[-1] - lines[0]
    off = lines - lines[0] - ((times - begin) / span)[:, None, None] * displacement
    if np.vdot(off, off) > (0.5 * _SLACK_M) ** 2:
        return None
    shares = [min(max((t - begin) / span, 0.0), 1.0) for t in (crop.start, crop.end)]
    if np.vdot(displacement, displacement) * (shares[1] - shares[0]) ** 2 > _LONGEST_M**2:
        return None
    ends = lines[0] + np.array(shares)[:, None, None] * displacement
    return _Chords(start=ends[0], stop=ends[1], radii=attack.radii, off=0.0)


def _curved(attack: Attack, crop: Crop) -> _Chords:
    """Chords of even duration.

    A point of a line and that of its chord at the same time are no farther apart than at a knot.
    """
    times, lines, radii = swept_lines(attack, crop)
    share = (times - times[0]) / max(float(times[-1] - times[0]), 1e-12)
    columns = lines.reshape(len(times), -1)
    displacement = columns[-1] - columns[0]
    off = _largest(columns - columns[0] - share[:, None] * displacement)
    count = max(math.sqrt(off / _CHORD_M), _largest(displacement[None]) / _LONGEST_M, 1.0)
    count = min(math.ceil(count), _MOST_CHORDS)
    even = np.arange(count + 1) / count
    corners = np.stack([np.interp(even, share, column) for column in columns.T], axis=1)
    chord = np.minimum((share * count).astype(np.int64), count - 1)
    along = (share * count - chord)[:, None]
    off = _largest(columns - corners[chord] - along * (corners[chord + 1] - corners[chord]))
    return _Chords(
        start=corners[:-1].reshape(-1, 3),
        stop=corners[1:].reshape(-1, 3),
        radii=np.tile(radii, count),
        off=off,
    )


def _largest(ways: Float[np.ndarray, "K C"]) -> float:
    """Length of the longest way of some spheres' ways."""
    return math.sqrt((ways * ways).reshape(-1, 3).sum(axis=1).max())


def _near(start: list[float], stop: list[float], radius: float, off: float) -> _Near:
    """The covered cells in the box of one chord."""
    sure, perhaps = radius + _SURE_M - off, radius + _PERHAPS_M + off
    length = math.dist(start, stop)
    low, squares, alongs = [], [], []
    for axis, (a, b) in enumerate(zip(start, stop, strict=True)):
        first = max(math.floor((min(a, b) - perhaps) / CELL_M), _LOW[axis])
        last = min(math.floor((max(a, b) + perhaps) / CELL_M), _HIGH[axis] - 1)
        middle = _MIDDLES[axis][first - _LOW[axis] : last + 1 - _LOW[axis]] - a
        low.append(first)
        squares.append(middle * middle)
        alongs.append(middle * ((b - a) / max(length, 1e-9)))
    squared, along = _outer_sum(squares), _outer_sum(alongs)
    share = np.minimum(np.maximum(along, 0.0), length)
    along += along
    along -= share
    along *= share
    squared -= along
    return _Near(low=low, squared=squared, sure=sure, perhaps=perhaps)


def _outer_sum(terms: list[np.ndarray]) -> Float32[np.ndarray, "Y X Z"]:
    """Sums of one term for each axis."""
    return (terms[0][:, None] + terms[2]) + terms[1][:, None, None]


def _mark(bits: UInt32[np.ndarray, " S"], first: int, near: _Near, limit: float) -> None:
    """Sets the bits of cells whose middles are within a limit; ``first`` is the first column."""
    if limit < _LEAST_M or not near.squared.size:
        return
    height, *sides = near.squared.shape
    y = near.low[1] - LOWEST
    within = _BITS[y : y + height] @ (near.squared < limit * limit).reshape(height, -1)
    row = near.low[0] + SPAN // 2 - first // SPAN
    column = near.low[2] + SPAN // 2
    box = bits.reshape(-1, SPAN)[row : row + sides[0], column : column + sides[1]]
    box |= within.astype(np.uint32).reshape(box.shape)
