"""Drawing spheres into horizontal layers, seen from above (§5.2).

Space is divided into :data:`LAYERS` layers of :data:`LAYER_M` from the floor up, and each layer
into square pixels of :data:`PIXEL_M`. A picture holds one word per pixel, whose bit k belongs to
layer k, so that one look at a pixel says everything about the column above it.

What of a sphere lies within a layer is a disc when seen from above: that of the sphere's widest
section in the layer. A pixel belongs to it if its middle does. Only the section at mid-height of a
layer would lose every sphere that does not reach it: layers are 25 cm high, a hand is 9 cm.
Counting each pixel that a disc touches at all would never miss an overlap, but makes a hand twice
as wide, and what overlaps by less than half a pixel is below any useful threshold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt16

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop

LAYERS = 9
LAYER_M = 0.25
PIXEL_M = 0.04
ATTACK_BIN_S = 0.05
"""Longest time of an attack that is tested against a body at one time."""
MAX_ATTACK_BINS = 64
MAX_STAMP = 1 << 18
"""Most pixels around the spheres of an attack, overlapping ones counted again; a ball at 10 m/s has
about 2,000. An attack with more, or with more bins, is not drawn: it would cost more than it can
save."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawn:
    """The pixels of an attack, of each bin in turn.

    Attributes:
        times: middle of each bin, s from now. [B]
        first: pixels of bin b are first[b] … first[b+1] − 1. [B+1]
        x, z: middle of each pixel, m. [Q]
        layers: bit k where it belongs to layer k. [Q]
    """

    times: Float[np.ndarray, " B"]
    first: Int[np.ndarray, " B1"]
    x: Float[np.ndarray, " Q"]
    z: Float[np.ndarray, " Q"]
    layers: UInt16[np.ndarray, " Q"]


def stamp_width(radius: float) -> int:
    """Pixels along each side of a square that holds the pixels of a sphere, wherever it is."""
    return int(np.ceil(2 * radius / PIXEL_M)) + 1


def stamp(
    centres: Float[np.ndarray, "N 3"], radii: Float[np.ndarray, " N"], width: int
) -> tuple[Int[np.ndarray, "N W"], Int[np.ndarray, "N W"], UInt16[np.ndarray, "N W W"]]:
    """Draws spheres, each into its own square of ``width`` pixels.

    Returns:
        Columns and rows of the pixels, counted from the origin, and the layers that each sphere
        fills there: [sphere, row, column].
    """
    corner = np.floor((centres[:, ::2] - radii[:, None]) / PIXEL_M).astype(np.int64)
    columns, rows = (corner[:, i, None] + np.arange(width) for i in (0, 1))
    dx = (columns + 0.5) * PIXEL_M - centres[:, 0, None]
    dz = (rows + 0.5) * PIXEL_M - centres[:, 2, None]
    across = (dz * dz)[:, :, None] + (dx * dx)[:, None, :]
    words = np.zeros(across.shape, np.uint16)
    y = centres[:, 1]
    lowest = np.maximum(np.floor((y - radii) / LAYER_M), 0).astype(np.int64)
    touched = int(np.ceil(2 * radii.max(initial=0.0) / LAYER_M)) + 1
    for more in range(min(touched, LAYERS)):
        k = lowest + more
        off = np.maximum(0.0, np.maximum(k * LAYER_M - y, y - (k + 1) * LAYER_M))
        reach = np.where(k < LAYERS, radii * radii - off * off, -1.0)
        bit = (1 << np.minimum(k, LAYERS - 1)).astype(np.uint16)
        words |= (across <= reach[:, None, None]) * bit[:, None, None]
    return columns, rows, words


def draw_attack(attack: Attack, crop: Crop) -> Drawn | None:
    """Draws the cropped attack: all its spheres, bin after bin.

    The crop is divided evenly into bins of at most :data:`ATTACK_BIN_S`. In each the spheres are
    drawn at evenly spaced moments, its beginning and end among them, between which none moves
    farther than the smallest radius; spheres that are not there are left out. A pixel appears once
    in each bin that draws it, with all its layers.

    Returns:
        The pixels, or None for an attack that is too long or too large to be worth it.
    """
    seconds = crop.end - crop.start
    bins = max(int(np.ceil(seconds / ATTACK_BIN_S - 1e-6)), 1)
    farthest = attack.largest_speed * seconds / bins / float(attack.radii.min())
    pieces = max(int(np.ceil(min(farthest, float(MAX_STAMP)))), 1)
    widths = np.array([float(stamp_width(min(r, 100.0))) for r in attack.radii])
    if bins > MAX_ATTACK_BINS or bins * (pieces + 1) * (widths**2).sum() > MAX_STAMP:
        return None
    shares = (np.arange(bins)[:, None] + np.arange(pieces + 1) / pieces) / bins
    moments = np.clip(crop.start + seconds * shares.ravel(), crop.start, crop.end)
    centres, active = attack.at(moments), attack.active(moments)
    number = np.repeat(np.arange(bins), pieces + 1)
    drawn = [
        _pixels(centres[when, i], radius, number[when])
        for i, radius in enumerate(attack.radii)
        if (when := active[:, i]).any()
    ]
    parts = (np.concatenate([pixels[i] for pixels in drawn]) for i in range(4))
    bin_of, column, row, words = parts if drawn else (np.zeros(0, np.int64),) * 4
    return _gather(bins, crop, bin_of, column, row, words.astype(np.uint16))


def _pixels(
    centres: Float[np.ndarray, "M 3"], radius: float, number: Int[np.ndarray, " M"]
) -> tuple[np.ndarray, ...]:
    """Bin, column, row and layers of all pixels of one sphere at moments; none without layers."""
    radii = np.full(len(centres), float(radius))
    columns, rows, words = stamp(centres, radii, stamp_width(float(radius)))
    moment, row, column = np.nonzero(words)
    return number[moment], columns[moment, column], rows[moment, row], words[moment, row, column]


def _gather(
    bins: int,
    crop: Crop,
    bin_of: np.ndarray,
    column: np.ndarray,
    row: np.ndarray,
    words: np.ndarray,
) -> Drawn:
    """Puts the layers of equal pixels of a bin together."""
    low = [int(x.min(initial=0)) for x in (column, row)]
    width, depth = (int(x.max(initial=0)) + 1 - a for x, a in zip((column, row), low, strict=True))
    key = (bin_of * depth + row - low[1]) * width + column - low[0]
    order = np.argsort(key, kind="stable")
    key, words = key[order], words[order]
    begins = np.flatnonzero(np.diff(key, prepend=-1))
    joined = np.bitwise_or.reduceat(words, begins) if len(key) else words
    key = key[begins]
    counts = np.bincount(key // (width * depth), minlength=bins)
    return Drawn(
        times=crop.start + (crop.end - crop.start) * (np.arange(bins) + 0.5) / bins,
        first=np.concatenate([[0], np.cumsum(counts)]),
        x=(key % width + low[0] + 0.5) * PIXEL_M,
        z=(key // width % depth + low[1] + 0.5) * PIXEL_M,
        layers=joined,
    )
