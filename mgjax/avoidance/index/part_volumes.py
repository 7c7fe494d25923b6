"""The avoidance volumes of parts for the grid index: exactly, and as rasters seen from above."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Complex, Float, Int, Integer, UInt8, UInt32

from mgjax.avoidance.index.cells import CELL_M
from mgjax.core.csr import expand, row_starts
from mgjax.core.errors import FileFormatError

PIXEL_M = 0.01
ROUNDING_M = 1e-5
"""More than what 32 bits lose within some metres."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PartVolumes:
    """Avoidance volumes in the planar frame of the node at which the part's edge begins.

    Attributes:
        radii: of the spheres, m. [S]
        moment_first: the moments of part a are rows moment_first[a] … moment_first[a+1] − 1. [A+1]
        centres: of the spheres, m: at the start of a part, then at its other moments, each next one
            the farthest from those before. [M, 3, S]
        rows, columns: pixels of a part's raster along x and z; those on its edge are empty. [A]
        corner: x and z of its lowest pixel's lowest corner, m. [A, 2]
        inner_first: some points inside part a, in cell LOWEST + b, are rows inner_first[a, b] …
            inner_first[a, b + 1] − 1; those of a part lie together. [A, HEIGHTS + 1]
        inner: x, z, and how deep each is inside, m; all have the height of sub-points. [D, 3]
        inner_bit: b. [D]
        packed: the rasters, compressed, one after another; see :func:`pack`. [B]
        packed_first: where each begins, and where the last one ends. [A+1]
    """

    radii: Float[np.ndarray, " S"]
    moment_first: Integer[np.ndarray, " A1"]
    centres: Float[np.ndarray, "M 3 S"]
    rows: Integer[np.ndarray, " A"]
    columns: Integer[np.ndarray, " A"]
    corner: Float[np.ndarray, "A 2"]
    inner_first: Integer[np.ndarray, "A B1"]
    inner: Float[np.ndarray, "D 3"]
    inner_bit: UInt8[np.ndarray, " D"]
    packed: UInt8[np.ndarray, " B"]
    packed_first: Integer[np.ndarray, " A1"]

    @cached_property
    def rasters(self) -> Rasters:
        """The rasters of those parts that were looked at; see :meth:`unpack`."""
        size = self.rows.astype(np.int64) * self.columns
        first = 1 + row_starts(size)
        words = np.zeros((int(first[-1]), 2), np.uint32)
        return Rasters(first[:-1], np.zeros(len(size), bool), words)

    def unpack(self, part: Int[np.ndarray, " Q"]) -> Rasters:
        """The rasters, with those of some parts in place.

        Raises:
            FileFormatError: the index is damaged there.
        """
        rasters = self.rasters
        for one in np.unique(part[~rasters.known[part]]).tolist():
            packed = self.packed[self.packed_first[one] : self.packed_first[one + 1]]
            pixels = int(self.rows[one]) * int(self.columns[one])
            own = slice(rasters.first[one], rasters.first[one] + pixels)
            try:
                words = np.frombuffer(zlib.decompress(packed.tobytes()), "<u4")
                rasters.words[own] = words.reshape(2, pixels).T
            except (zlib.error, ValueError):
                raise FileFormatError(
                    "grid index", None, f"a damaged raster of part {one}", "a whole; build it anew"
                ) from None
            rasters.known[one] = True
        return rasters


@dataclass(frozen=True, eq=False)
class Rasters:
    """Pixels of parts, row after row along z; pixel 0 is empty.

    Attributes:
        first: first pixel of each part. [A]
        known: parts whose pixels are in place. [A]
        words: bit b: the volume is surely, and perhaps, at one of the two heights of sub-points in
            cell LOWEST + b, somewhere in the pixel. [X, 2]
    """

    first: Int[np.ndarray, " A"]
    known: Bool[np.ndarray, " A"]
    words: UInt32[np.ndarray, "X 2"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Pixels:
    """The rasters of placed parts.

    Attributes:
        words: of all pixels; see :class:`~mgjax.avoidance.index.part_volumes.Rasters`. [X, 2]
        first: the first of each part. [C]
        rows, columns: pixels along x and z. [C]
        turn, begin: a point p, x + i z in cells from the node, is in pixel turn p + begin. [C]
        middle, half: of the boxes around the rasters, x + i z, in cells from the node. [C]
    """

    words: UInt32[np.ndarray, "X 2"]
    first: Int[np.ndarray, " C"]
    rows: UInt32[np.ndarray, " C"]
    columns: UInt32[np.ndarray, " C"]
    turn: Complex[np.ndarray, " C"]
    begin: Complex[np.ndarray, " C"]
    middle: Complex[np.ndarray, " C"]
    half: Complex[np.ndarray, " C"]

    @classmethod
    def of(
        cls,
        volumes: PartVolumes,
        part: Int[np.ndarray, " C"],
        turn: Complex[np.ndarray, " C"],
        where: Complex[np.ndarray, " C"],
    ) -> Pixels:
        rasters = volumes.unpack(part)
        corner = as_complex(volumes.corner[part])
        rows, columns = (n[part].astype(np.uint32) for n in (volumes.rows, volumes.columns))
        a, b = (0.5 * PIXEL_M / CELL_M) * rows, (0.5 * PIXEL_M / CELL_M) * columns
        middle = where / CELL_M + turn.conj() * (corner / CELL_M + (a + 1j * b))
        c, s = np.abs(np.real(turn)), np.abs(np.imag(turn))
        return cls(
            words=rasters.words,
            first=rasters.first[part],
            rows=rows,
            columns=columns,
            turn=(turn * (CELL_M / PIXEL_M)).astype(np.complex64),
            begin=((turn * where + corner) / -PIXEL_M).astype(np.complex64),
            middle=middle,
            half=c * a + s * b + 1j * (s * a + c * b),
        )

    def near(
        self, along: Float[np.ndarray, " K"], along_x: bool
    ) -> tuple[Int[np.ndarray, " Q"], Int[np.ndarray, " Q"]]:
        """Pairs of parts and columns among which are all that meet: rows of both.

        Args:
            along: lowest places of the columns on an axis, in cells, ascending.
            along_x: whether it is x and not z.
        """
        if along_x:
            middle, half = np.real(self.middle), np.real(self.half)
        else:
            middle, half = np.imag(self.middle), np.imag(self.half)
        half = half + ROUNDING_M / CELL_M
        first = along.searchsorted(middle - half - 1)
        row, number = expand(along.searchsorted(middle + half, "right") - first)
        return row, first[row] + number

    def at(
        self, row: Int[np.ndarray, " Q"], planar: Complex[np.ndarray, " Q"]
    ) -> tuple[Int[np.ndarray, " I"], Int[np.ndarray, " I"]]:
        """Which of some points, in cells, are in the raster of a part, and in which pixel.

        Args:
            row: which of the parts each is asked for.
            planar: x + i z.
        """
        planar = planar.astype(np.complex64) * self.turn[row]
        planar += self.begin[row]
        # Pixels at the edges are empty, so it does not matter that −0.5 counts as 0.
        u, v = np.real(planar).astype(np.int32), np.imag(planar).astype(np.int32)
        inside = u.view(np.uint32) < self.rows[row]
        inside &= v.view(np.uint32) < self.columns[row]
        at = inside.nonzero()[0]
        row = row[at]
        return at, u[at] * self.columns[row] + v[at] + self.first[row]


def as_complex(planar: Float[np.ndarray, "*a 2"]) -> Complex[np.ndarray, " *a"]:
    """x + i z of places (x, z)."""
    return planar[..., 0] + 1j * planar[..., 1]


def pack(raster: UInt32[np.ndarray, "2 U V"]) -> bytes:
    """The pixels of one part, sure and maybe, in zlib's format, four bytes each, lowest first."""
    return zlib.compress(np.ascontiguousarray(raster, "<u4").tobytes(), 9)
