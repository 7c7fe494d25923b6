"""Pictures of where the body is during each edge, in horizontal layers, for culling (§5.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from jaxtyping import Bool, Float, Int, UInt16

from mgjax.avoidance.body.edge_tables import EdgeTables, of_size
from mgjax.avoidance.culling.rasterise import LAYERS, PIXEL_M, stamp, stamp_width
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

BODY_BIN_S = 0.1
MOMENTS = 6
"""Intervals of a bin at whose ends the body is drawn: 60 a second, so that a hand at 5 m/s moves
on by its own width."""
CHUNK = 512
"""Bins that are drawn together: their squares then stay in the cache."""
Form: TypeAlias = Literal["paper", "binned"]


@register()
@dataclass(frozen=True, kw_only=True)
class Pictures:
    """Rectangular pictures of different sizes, one after the other.

    Attributes:
        words: one for each pixel, row by row; bit k is layer k. The first word is 0 and belongs to
            no picture. [W]
        first: word of each picture's first pixel. [N]
        corner: column and row of that pixel, counted from the origin of the frame. [N, 2]
        size: columns and rows. [N, 2]
    """

    words: UInt16[Array, " W"]
    first: Int[Array, " N"]
    corner: Int[Array, "N 2"]
    size: Int[Array, "N 2"]


@register()
@dataclass(frozen=True, kw_only=True)
class Slices:
    """The pictures of a graph's edges, each in the planar frame of the node its edge leaves.

    Attributes:
        scale: of the body; all lengths here are in metres of an adult's body
            (:func:`mgjax.core.body.height.body_scale`).
        seconds: natural duration of each edge. [E]
        step: planar frame of the node an edge arrives at, in that of the node it leaves. [E, 3]
        paper: one picture for each edge, of the whole edge.
        binned: one picture for each bin of each edge, of that part of its motion.
        first_bin: an edge's first bin; bin b lasts from b to b + 1 times :data:`BODY_BIN_S` after
            its beginning, or to its end. [E]
        bins: of each edge. [E]
    """

    scale: Float[Array, ""]
    seconds: Float[Array, " E"]
    step: Float[Array, "E 3"]
    paper: Pictures
    binned: Pictures
    first_bin: Int[Array, " E"]
    bins: Int[Array, " E"]


def picture_bytes(pictures: Pictures) -> int:
    """What the pictures take in memory."""
    arrays = (pictures.words, pictures.first, pictures.corner, pictures.size)
    return sum(int(array.nbytes) for array in arrays)


def build_slices(tables: EdgeTables, scale: float = 1.0) -> Slices:
    """Draws the body of every edge, bin by bin and as a whole.

    Layers and pixels grow with the body: it is drawn at the size of an adult, ``scale`` times
    smaller than it is.

    The body of a bin is that at ``MOMENTS`` + 1 evenly spaced moments from its beginning to its
    end, linear between the samples of the tables. The picture of an edge is the union of those of
    its bins; its extent is the bounding box of the edge.
    """
    tables = of_size(tables, 1 / scale)
    bins = np.maximum(np.ceil(tables.seconds / BODY_BIN_S - 1e-6).astype(np.int64), 1)
    first = np.cumsum(bins) - bins
    edge = np.repeat(np.arange(len(bins)), bins)
    begin = (np.arange(len(edge)) - first[edge]) * BODY_BIN_S
    end = np.minimum(begin + BODY_BIN_S, tables.seconds[edge])
    moments = np.linspace(begin, end, MOMENTS + 1)
    low, high = _bounds(tables, edge, moments)
    binned = _empty(low, high - low)
    for start in range(0, len(edge), CHUNK):
        tile = slice(start, start + CHUNK)
        for when in moments[:, tile]:
            _draw(binned, tile, _body(tables, edge[tile], when), tables.spheres.radii)
    paper = _empty(
        np.minimum.reduceat(low, first),
        np.maximum.reduceat(high, first) - np.minimum.reduceat(low, first),
    )
    _join(paper, binned, edge)
    return Slices(
        scale=np.array(scale, np.float32),
        seconds=tables.seconds.astype(np.float32),
        step=tables.step.astype(np.float32),
        paper=paper,
        binned=binned,
        first_bin=first.astype(np.int32),
        bins=bins.astype(np.int32),
    )


def _body(
    tables: EdgeTables, edge: Int[np.ndarray, " N"], when: Float[np.ndarray, " N"]
) -> Float[np.ndarray, "N 3 S"]:
    """Sphere centres at times of edges, in the edges' frames."""
    steps = tables.pool_steps[edge]
    place = np.clip(when / tables.seconds[edge] * steps, 0, steps)
    low = np.minimum(np.floor(place + 1e-9).astype(np.int64), steps - 1)
    share = (place - low)[:, None]
    row = tables.pool_first[edge] + low
    centres = tables.pool[row] * (1 - share) + tables.pool[row + 1] * share
    return centres.reshape(len(edge), 3, -1)


def _bounds(
    tables: EdgeTables, edge: Int[np.ndarray, " N"], moments: Float[np.ndarray, "M N"]
) -> tuple[Int[np.ndarray, "N 2"], Int[np.ndarray, "N 2"]]:
    """First column and row of each bin's pictures, and those after the last."""
    radii = tables.spheres.radii.astype(np.float64)
    low, high = np.full((len(edge), 2), np.inf), np.full((len(edge), 2), -np.inf)
    for when in moments:
        centres = _body(tables, edge, when)[:, ::2]
        low = np.minimum(low, (centres - radii).min(axis=2))
        high = np.maximum(high, (centres + radii).max(axis=2))
    return (
        np.floor(low / PIXEL_M).astype(np.int64),
        np.floor(high / PIXEL_M).astype(np.int64) + 1,
    )


def _empty(corner: Int[np.ndarray, "N 2"], size: Int[np.ndarray, "N 2"]) -> Pictures:
    area = size[:, 0] * size[:, 1]
    return Pictures(
        words=np.zeros(1 + int(area.sum()), np.uint16),
        first=(1 + np.cumsum(area) - area).astype(np.int32),
        corner=corner.astype(np.int32),
        size=size.astype(np.int32),
    )


def _draw(
    pictures: Pictures,
    tile: slice,
    centres: Float[np.ndarray, "N 3 S"],
    radii: Float[np.ndarray, " S"],
) -> None:
    """Draws a body into each of some pictures."""
    first, corner, size = (x[tile] for x in (pictures.first, pictures.corner, pictures.size))
    for sphere, radius in enumerate(radii.tolist()):
        same = np.full(len(centres), radius)
        columns, rows, words = stamp(centres[:, :, sphere], same, stamp_width(radius))
        place = (first[:, None] + (rows - corner[:, 1:]) * size[:, :1])[:, :, None]
        place = place + (columns - corner[:, :1])[:, None, :]
        # Only what is drawn is sure to be inside its picture, and no place is there twice.
        drawn = words > 0
        pictures.words[place[drawn]] |= words[drawn]


def _join(into: Pictures, parts: Pictures, number: Int[np.ndarray, " N"]) -> None:
    """Draws pictures into others in the same frames; picture i into number[i]."""
    place = np.flatnonzero(parts.words)
    part = np.searchsorted(parts.first, place, side="right") - 1
    row, column = np.divmod(place - parts.first[part], parts.size[part, 0])
    target = number[part]
    row += parts.corner[part, 1] - into.corner[target, 1]
    column += parts.corner[part, 0] - into.corner[target, 0]
    at = into.first[target] + row * into.size[target, 0] + column
    np.bitwise_or.at(np.asarray(into.words), at, parts.words[place])


def unpack(pictures: Pictures, number: int) -> Bool[np.ndarray, "K H W"]:
    """One picture as layers, rows (along z) and columns (along x)."""
    columns, rows = (int(x) for x in pictures.size[number])
    first = int(pictures.first[number])
    words = np.asarray(pictures.words[first : first + rows * columns]).reshape(rows, columns)
    return (words >> np.arange(LAYERS, dtype=np.uint16)[:, None, None]) & 1 == 1
