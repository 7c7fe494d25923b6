"""Which cells belong to parts that paths place somewhere: by their rasters, then by their spheres.

A path moves its part's volume by a planar transform, so heights stay, and a column of cells reads
the pixels below its sub-points. What stays open, near surfaces, is decided by the spheres
themselves, so that cells are exactly those of the definition.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Complex, Float, Int, Integer, UInt32

from mgjax.avoidance.index.cells import CELL_M, LOWEST, SPAN, cell_of, corners, set_bits
from mgjax.avoidance.index.part_volumes import PIXEL_M, PartVolumes, Pixels, as_complex
from mgjax.avoidance.index.swept_cells import SweptCells
from mgjax.core.csr import expand

_QUARTERS = np.array([0.25 + 0.25j, 0.75 + 0.75j, 0.25 + 0.75j, 0.75 + 0.25j])
"""Sub-points of a column, in cells from its lowest corner: x + i z."""
_HALF = SPAN // 2
_MOST = 1 << 16
"""Columns of parts that are looked at at once."""
_POINTS = 1 << 14
"""Points that are looked at at once."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedParts:
    """Parts in the planar frame of one node.

    Attributes:
        volumes: of the parts.
        part: of each path. [C]
        turn: e^(iθ), where θ is the turn of the part's frame. [C]
        where: x + i z of its origin, m. [C]
    """

    volumes: PartVolumes
    part: Int[np.ndarray, " C"]
    turn: Complex[np.ndarray, " C"]
    where: Complex[np.ndarray, " C"]

    def some(self, which: Int[np.ndarray, " D"] | slice) -> PlacedParts:
        """Those of some paths."""
        return PlacedParts(
            volumes=self.volumes,
            part=self.part[which],
            turn=self.turn[which],
            where=self.where[which],
        )

    def touched_by(self, cells: SweptCells) -> Bool[np.ndarray, " C"]:
        """Which of them have a cell that a sweep touches."""
        touched = self._inside_touched(cells)
        rest = (~touched).nonzero()[0]
        if rest.size:
            columns = SweptColumns.of(cells)
            size = max(_MOST // max(len(columns.number), 1), 1)
            for first in range(0, len(rest), size):
                own = rest[first : first + size]
                touched[own] = self.some(own)._decided(columns)
        return touched

    def _inside_touched(self, cells: SweptCells) -> Bool[np.ndarray, " C"]:
        """Which surely have one of the cells, as some points inside them say.

        The sub-point next to such a point is inside as well if it is no farther than the point is
        deep. At a path both have the same height, so it is decided on the plane.
        """
        inner_first, heights = self.volumes.inner_first, cells.heights
        first = inner_first[self.part, heights[0]].astype(np.int64)
        row, number = expand(inner_first[self.part, heights[1]] - first)
        at = first[row] + number
        x, z, depth = self.volumes.inner[at].T  # 32 bits lose less than the depths leave room for
        place = (self.turn.conj() * (2 / CELL_M)).astype(np.complex64)[row] * (x + 1j * z)
        place += (self.where * (2 / CELL_M)).astype(np.complex64)[row]
        x, z = np.floor(np.real(place)), np.floor(np.imag(place))
        away = (np.real(place) - x - 0.5) ** 2 + (np.imag(place) - z - 0.5) ** 2
        near = away < (depth * (2 / CELL_M)) ** 2
        near &= np.abs(z + 0.5) < SPAN
        near = near.nonzero()[0]
        x, z = (along[near].astype(np.int64) >> 1 for along in (x, z))
        words = cells.sure.take((x + _HALF) * SPAN + (z + (_HALF - cells.first)), mode="clip")
        words >>= self.volumes.inner_bit[at[near]]
        touched = np.zeros(len(self.part), bool)
        touched[row[near[(words & 1).nonzero()[0]]]] = True
        return touched

    def _decided(self, columns: SweptColumns) -> Bool[np.ndarray, " C"]:
        """Which have a cell that a sweep touches, each open cell decided."""
        touched = np.zeros(len(self.part), bool)
        pixels = self.pixels
        row, column = pixels.near(columns.along, columns.along_x)
        planar = (columns.corner[column][:, None] + _QUARTERS).ravel()
        row, column = row.repeat(4), column.repeat(4)
        at, index = pixels.at(row, planar)
        sure, maybe = pixels.words[index].T
        row, column, planar = row[at], column[at], planar[at]
        touched[row[(sure & columns.sure[column]).nonzero()[0]]] = True
        maybe &= columns.perhaps[column]
        maybe[touched[row]] = 0
        open_ = maybe.nonzero()[0]
        if not open_.size:
            return touched
        which, bit = set_bits(maybe[open_])
        which = open_[which]
        own, met = ((words[which] >> bit) & 1 == 1 for words in (sure, columns.sure[column]))
        row, column, planar = row[which], column[which], planar[which]

        open_ = (~own).nonzero()[0]
        own[open_] = self.have(row[open_], planar[open_], bit[open_])
        touched[row[own & met]] = True
        rest = (own & ~met & ~touched[row]).nonzero()[0]
        if rest.size:
            cells = cell_of(columns.number[column[rest]], bit[rest])
            touched[row[rest[columns.cells.touches(cells)]]] = True
        return touched

    @cached_property
    def pixels(self) -> Pixels:
        """Where the rasters of the parts are."""
        return Pixels.of(self.volumes, self.part, self.turn, self.where)

    def have(
        self,
        row: Int[np.ndarray, " Q"],
        planar: Complex[np.ndarray, " Q"],
        bit: Integer[np.ndarray, " Q"],
    ) -> Bool[np.ndarray, " Q"]:
        """Whether one of the two sub-points of a cell that are above one another is in a part.

        Args:
            row: which of the parts.
            planar: x + i z of the sub-points, in cells.
            bit: of the cell.
        """
        volumes, part = self.volumes, self.part[row]
        local = ((planar * CELL_M - self.where[row]) * self.turn[row])[:, None]
        height = (bit[:, None] + [LOWEST + 0.25, LOWEST + 0.75]) * CELL_M
        local = np.broadcast_to(local, height.shape)
        point = np.stack([np.real(local), height, np.imag(local)], axis=-1).reshape(-1, 3)
        owner = np.arange(len(row)).repeat(2)
        first = volumes.moment_first[part[owner]].astype(np.int64)
        count = volumes.moment_first[part[owner] + 1] - first
        inside = _inside(volumes, first, point).nonzero()[0]
        belongs = np.zeros(len(row), bool)
        # The second moment is the farthest; what it leaves open, all others decide.
        away = ~_inside(volumes, first[inside] + 1, point[inside])
        belongs[owner[inside[away]]] = True
        rest = inside[~belongs[owner[inside]] & (count[inside] > 2)]
        if rest.size:
            which, moment = expand(count[rest] - 2)
            which = rest[which]
            away = ~_inside(volumes, first[which] + moment + 2, point[which])
            belongs[owner[which[away]]] = True
        return belongs


@dataclass(frozen=True, kw_only=True, eq=False)
class SweptColumns:
    """The columns that a sweep touches or may touch, along the axis on which they are longest.

    Attributes:
        cells: of the sweep.
        number: of each column. [K]
        corner: x + i z, in cells. [K]
        along_x: whether the axis is x and not z.
        along: place on the axis, in cells, ascending. [K]
        sure, perhaps: bits of the heights. [K]
    """

    cells: SweptCells
    number: Int[np.ndarray, " K"]
    corner: Complex[np.ndarray, " K"]
    along_x: bool
    along: Float[np.ndarray, " K"]
    sure: UInt32[np.ndarray, " K"]
    perhaps: UInt32[np.ndarray, " K"]

    @classmethod
    def of(cls, cells: SweptCells) -> SweptColumns:
        perhaps = cells.perhaps()
        at = perhaps.nonzero()[0]
        corner = corners(at + cells.first)  # ascending along x
        x, z = np.real(corner), np.imag(corner)
        along_x = not at.size or bool(x[-1] - x[0] >= z.max() - z.min())
        if not along_x:
            order = np.argsort(z, kind="stable")
            at, corner, z = at[order], corner[order], z[order]
        return cls(
            cells=cells,
            number=at + cells.first,
            corner=corner,
            along_x=along_x,
            along=x if along_x else z,
            sure=cells.sure[at],
            perhaps=perhaps[at],
        )


def _inside(
    volumes: PartVolumes, moment: Integer[np.ndarray, " Q"], point: Float[np.ndarray, "Q 3"]
) -> Bool[np.ndarray, " Q"]:
    """Whether points are inside the body at a moment, in the part's frame."""
    inside = np.zeros(len(moment), bool)
    for first in range(0, len(moment), _POINTS):
        rows = slice(first, first + _POINTS)
        gap = volumes.centres[moment[rows]] - point[rows, :, None].astype(np.float32)
        gap *= gap
        inside[rows] = (gap.sum(axis=1) < volumes.radii**2).any(axis=1)
    return inside


def cells_of(parts: PlacedParts) -> tuple[Int[np.ndarray, " M"], Int[np.ndarray, "M 3"]]:
    """All cells of placed parts: which part each is of, and the cell, in ascending order."""
    volumes = parts.volumes
    found = [(np.zeros(0, np.int64), np.zeros((0, 3), np.int64))]
    for i, part in enumerate(parts.part.tolist()):
        size = PIXEL_M * np.array([int(volumes.rows[part]), int(volumes.columns[part])])
        box = as_complex(volumes.corner[[part]]) + np.array(
            [0, size[0], 1j * size[1], size @ [1, 1j]]
        )
        box = parts.where[i] + parts.turn[i].conj() * box
        ranges = []
        for along in (np.real(box), np.imag(box)):
            low, high = np.floor([along.min() / CELL_M, along.max() / CELL_M]).astype(int)
            ranges.append(np.arange(max(low, -_HALF), min(high, _HALF - 1) + 1) + _HALF)
        columns = (ranges[0][:, None] * SPAN + ranges[1]).ravel()
        one = parts.some(slice(i, i + 1))
        planar = (corners(columns)[:, None] + _QUARTERS).ravel()
        at, index = one.pixels.at(np.zeros(len(planar), np.int64), planar)
        sure, maybe = one.pixels.words[index].T
        which, bit = set_bits(maybe)
        own = (sure[which] >> bit) & 1 == 1
        at = at[which]
        open_ = (~own).nonzero()[0]
        own[open_] = one.have(np.zeros(len(open_), np.int64), planar[at[open_]], bit[open_])
        column = at // 4
        cells = np.unique(cell_of(columns[column[own]], bit[own]), axis=0)
        found.append((np.full(len(cells), i), cells))
    which, cells = (np.concatenate(column) for column in zip(*found, strict=True))
    return which, cells
