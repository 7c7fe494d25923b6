"""The avoidance volumes of parts for the grid index: exactly, and as rasters seen from above."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int, UInt32
from scipy.spatial import ConvexHull

from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.avoidance.index.cells import CELL_M, HEIGHTS, LOWEST
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import bucket_size, pad_axis

PIXEL_M = 0.002
ROUNDING_M = 1e-5
"""More than what 32 bits lose within some metres."""
_SPLIT = 4  # pixels along a coarse one, of those that are looked at first
_TILE = 16384
_CELLS = 8192
_EARLY = 3  # moments at which all open cells are looked at


@dataclass(frozen=True, kw_only=True, eq=False)
class PartVolumes:
    """Avoidance volumes in the planar frame of the node at which the part's edge begins.

    Attributes:
        centres: of the spheres, m: at the start of the part, then at its other moments, each next
            one the farthest from those before; the last is repeated. [A, M, 3, S]
        moments: of each part. [A]
        radii: m. [S]
        sure, maybe: pixels of all parts, row after row along z; bit b: the volume is surely, or
            perhaps, at one of the two heights of sub-points in cell LOWEST + b, somewhere in the
            pixel. Pixel 0 is empty. [X]
        base, rows, columns: first pixel of each part, pixels along x and z. [A]
        corner: x and z of its lowest pixel's lowest corner, m. [A, 2]
        outlines: corners of a convex polygon around all that may be, x and z in m.
    """

    centres: Float[np.ndarray, "A M 3 S"]
    moments: Int[np.ndarray, " A"]
    radii: Float[np.ndarray, " S"]
    sure: UInt32[np.ndarray, " X"]
    maybe: UInt32[np.ndarray, " X"]
    base: Int[np.ndarray, " A"]
    rows: Int[np.ndarray, " A"]
    columns: Int[np.ndarray, " A"]
    corner: Float[np.ndarray, "A 2"]
    outlines: list[np.ndarray]


def part_volumes(tables: EdgeTables, rate: float, parts: Int[np.ndarray, " U"]) -> PartVolumes:
    """The volumes of all parts; those not in ``parts`` stay without raster."""
    count = len(tables.part_edge)
    bodies = [moments_of(tables, part, rate) for part in range(count)]
    most = bucket_size(max((len(b) for b in bodies), default=1))
    radii = tables.spheres.radii.astype(np.float32)
    empty = np.zeros((0, most, 3, len(radii)), np.float32)
    centres = np.concatenate([empty, *(pad_axis(b, most)[None] for b in bodies)])
    moments = np.array([len(b) for b in bodies], np.int64)
    words: list[np.ndarray] = [np.zeros((2, 1), np.uint32)]
    shape, corner = np.zeros((count, 2), np.int64), np.zeros((count, 2))
    outlines = [np.zeros((0, 2))] * count
    base, size = np.zeros(count, np.int64), 1
    for part in parts:
        raster, corner[part] = _rasterise(centres[part], int(moments[part]), radii)
        shape[part], base[part] = raster.shape[1:], size
        outlines[part] = _outline(raster[1], corner[part])
        words.append(raster.reshape(2, -1))
        size += words[-1].shape[1]
    flat = np.concatenate(words, axis=1)
    flat = pad_axis(flat, bucket_size(size, 1 << 16), axis=1, value=0)
    return PartVolumes(
        centres=centres,
        moments=moments,
        radii=radii,
        sure=flat[0],
        maybe=flat[1],
        base=base,
        rows=shape[:, 0],
        columns=shape[:, 1],
        corner=corner,
        outlines=outlines,
    )


def moments_of(tables: EdgeTables, part: int, rate: float) -> Float[np.ndarray, "M 3 S"]:
    """Sphere centres at start, start + 1/rate, … and at the end of a part; the start comes first.

    Between the samples of the tables the centres are interpolated.
    """
    edge = tables.part_edge[part]
    start, stop = tables.part_start[part], tables.part_stop[part]
    count = int(np.ceil((stop - start) * rate - 1e-6))
    times = np.minimum(start + np.arange(count + 1) / rate, stop)
    steps = tables.pool_steps[edge]
    at = times / tables.seconds[edge] * steps
    low = np.clip(np.floor(at + 1e-6).astype(np.int64), 0, steps - 1)
    share = (at - low)[:, None]
    row = tables.pool_first[edge] + low
    centres = tables.pool[row] * (1 - share) + tables.pool[row + 1] * share
    order, away = [0], np.full(len(times), np.inf)
    while len(order) < len(times):  # each next one the farthest from those before
        away = np.minimum(away, np.abs(centres - centres[order[-1]]).mean(axis=1))
        away[order] = -1.0
        order.append(int(np.argmax(away)))
    return centres[order].reshape(len(times), 3, -1).astype(np.float32)


@jax.jit
def _gap(
    points: Float[Array, "3 P"],
    centres: Float[Array, "M 3 S"],
    radii: Float[Array, " S"],
    count: Int[Array, ""],
) -> Float[Array, " P"]:
    """Signed distance of points to the body, the largest over the first ``count`` moments, m."""

    def at(moment: Array, largest: Array) -> Array:
        body = centres[moment]
        gap = jnp.full_like(largest, jnp.inf)
        for s in range(radii.shape[0]):  # as straight code: one pass over the points
            x, y, z = (points[i] - body[i, s] for i in range(3))
            gap = jnp.minimum(gap, jnp.sqrt(x * x + y * y + z * z) - radii[s])
        return jnp.maximum(largest, gap)

    return jax.lax.fori_loop(0, count, at, jnp.full_like(points[0], -jnp.inf))


def largest_gap(
    points: Float[np.ndarray, "3 P"], centres: np.ndarray, moments: int, radii: np.ndarray
) -> Float[np.ndarray, " P"]:
    """Signed distance of points to the body, the largest over the first moments, m."""
    count = points.shape[1]
    gaps = np.empty(count, np.float32)
    for first in range(0, count, _TILE):
        chunk = slice(first, min(first + _TILE, count))
        size = bucket_size(chunk.stop - first, _TILE // 8)
        gap = _gap(pad_axis(points[:, chunk], size, axis=1), centres, radii, np.int32(moments))
        gaps[chunk] = np.asarray(gap)[: chunk.stop - first]
    return gaps


def _depth(
    points: Float[np.ndarray, "3 P"],
    centres: np.ndarray,
    moments: int,
    radii: np.ndarray,
    at: float,
) -> Float[np.ndarray, " P"]:
    """How deep points are in the avoidance volume, m: below 0 outside, 1-Lipschitz.

    Where it is below ``-at`` only that is known.
    """
    points = points.astype(np.float32)
    depth = -largest_gap(points, centres, 1, radii)
    near = np.flatnonzero(depth >= -at)
    depth[near] = np.minimum(depth[near], largest_gap(points[:, near], centres, moments, radii))
    return depth


def _rasterise(
    centres: Float[np.ndarray, "M 3 S"], moments: int, radii: Float[np.ndarray, " S"]
) -> tuple[UInt32[np.ndarray, "2 U V"], Float[np.ndarray, " 2"]]:
    """Pixels of one part, sure and maybe, and the corner of the first.

    A pixel is judged by the depth at its middle, since the depth changes by at most the distance;
    first coarse pixels, then the parts of those that stay open.
    """
    coarse = PIXEL_M * _SPLIT
    start = centres[0].T.astype(np.float64)
    reach = radii[:, None] + coarse
    low = np.floor((start - reach).min(axis=0) / coarse) * coarse
    high = (start + reach).max(axis=0)
    size = np.ceil((high - low) / coarse).astype(np.int64)[[0, 2]]
    half = CELL_M / 2
    layers = np.arange(*np.clip(np.floor([low[1] / half, high[1] / half + 1]), *_LAYERS)).astype(
        int
    )
    corner = low[[0, 2]]

    def judge(u: np.ndarray, v: np.ndarray, k: np.ndarray, pixel: float) -> np.ndarray:
        middle = [corner[0] + (u + 0.5) * pixel, (k + 0.5) * half, corner[1] + (v + 0.5) * pixel]
        at = pixel * np.sqrt(0.5) + ROUNDING_M
        depth = _depth(np.stack(middle), centres, moments, radii, at)
        return (depth > at).astype(np.int8) + (depth >= -at)  # 0 out, 1 open, 2 sure

    u, v, k = (x.ravel() for x in np.meshgrid(*map(np.arange, size), layers, indexing="ij"))
    state = judge(u, v, k, coarse)
    words = np.zeros((2, *size), np.uint32)
    _set_bits(words[0], u, v, k, state == 2)
    words = np.repeat(words[0], _SPLIT, axis=0).repeat(_SPLIT, axis=1)
    words = np.stack([words, words])
    sub = np.arange(_SPLIT * _SPLIT)
    u, v, k = (x[state == 1, None] for x in (u, v, k))
    u, v, k = u * _SPLIT + sub // _SPLIT, v * _SPLIT + sub % _SPLIT, k + 0 * sub
    u, v, k = u.ravel(), v.ravel(), k.ravel()
    state = judge(u, v, k, PIXEL_M)
    _set_bits(words[0], u, v, k, state == 2)
    _set_bits(words[1], u, v, k, state >= 1)
    return words, corner


_LAYERS = (2 * LOWEST, 2 * (LOWEST + HEIGHTS))


def _set_bits(
    words: np.ndarray, u: np.ndarray, v: np.ndarray, k: np.ndarray, on: np.ndarray
) -> None:
    bits = np.uint32(1) << (k[on] // 2 - LOWEST).astype(np.uint32)
    np.bitwise_or.at(words.reshape(-1), u[on] * words.shape[1] + v[on], bits)


def _outline(
    maybe: UInt32[np.ndarray, "U V"], corner: Float[np.ndarray, " 2"]
) -> Float[np.ndarray, "H 2"]:
    """Corners of a convex polygon around all pixels that are not empty."""
    block = _SPLIT * _SPLIT  # coarser: fewer corners
    starts = [np.arange(0, length, block) for length in maybe.shape]
    coarse = np.bitwise_or.reduceat(np.bitwise_or.reduceat(maybe, starts[0]), starts[1], axis=1)
    u, v = np.nonzero(coarse)
    if not u.size:
        return np.zeros((0, 2))
    first = np.flatnonzero(np.diff(u, prepend=-1))
    last = np.append(first[1:], len(u)) - 1
    ends = np.concatenate([np.stack([u[i], v[i]], axis=1) for i in (first, last)])
    corners = (ends[:, None] + np.array([[0, 0], [0, 1], [1, 0], [1, 1]])).reshape(-1, 2)
    points = corner + corners * (PIXEL_M * block)
    return points[ConvexHull(points).vertices]


def touched_by(
    volumes: PartVolumes,
    part: Int[np.ndarray, " Q"],
    place: Float[np.ndarray, "Q 4"],
    corner: Int[np.ndarray, "3 Q"],
) -> Bool[np.ndarray, " Q"]:
    """Whether cells, given by their place in their path's rectangle, belong to the path.

    Args:
        volumes: of the parts.
        part: of each cell's path, ascending.
        place: of each cell's path, x, z, cosine and sine as in the rectangles of the build.
        corner: lowest corner, in cells.
    """
    touched = np.zeros(len(part), bool)
    bounds = np.append(np.flatnonzero(np.diff(part, prepend=-1)), len(part))
    for begin, end in zip(bounds[:-1], bounds[1:], strict=True):
        one = part[begin]
        shift = np.array([volumes.corner[one, 0], 0, volumes.corner[one, 1]])[:, None]
        centres = (volumes.centres[one] - shift).astype(np.float32)
        for at in range(begin, end, _CELLS):
            tile = slice(at, min(at + _CELLS, end))
            count = tile.stop - at
            padded = pad_axis(place[tile], _CELLS), pad_axis(corner[:, tile], _CELLS, axis=1)
            inside, outside, points = (
                np.array(x) for x in _sub_points(*padded, centres[:_EARLY], volumes.radii)
            )
            touched[tile] = (inside & outside).any(axis=0)[:count]
            sub, late = np.nonzero(inside[:, :count] & ~touched[tile])
            gap = largest_gap(
                points[:, sub, late], centres, int(volumes.moments[one]), volumes.radii
            )
            touched[at + late[gap > 0]] = True
    return touched


@jax.jit
def _sub_points(
    place: Float[Array, "Q 4"],
    corner: Int[Array, "3 Q"],
    centres: Float[Array, "M 3 S"],
    radii: Float[Array, " S"],
) -> tuple[Bool[Array, "8 Q"], Bool[Array, "8 Q"], Float[Array, "3 8 Q"]]:
    """Sub-points of cells: inside the first body, outside one of the others, and where they are."""
    x0, z0, c, s = (place[None, :, i] for i in range(4))
    sub = jnp.arange(8)[:, None]
    quarter = [0.25 + 0.5 * ((sub >> i) & 1).astype(jnp.float32) for i in range(3)]
    x, y, z = (CELL_M * (corner[None, i].astype(jnp.float32) + quarter[i]) for i in range(3))
    point = (x0 + x * c - z * s, y, z0 + x * s + z * c)
    gaps: list[Array] = []
    for body in centres:
        inside = jnp.zeros(point[0].shape, bool)
        for j in range(radii.shape[0]):
            dx, dy, dz = (point[i] - body[i, j] for i in range(3))
            inside |= dx * dx + dy * dy + dz * dz < radii[j] * radii[j]
        gaps.append(inside)
    return gaps[0], ~jnp.stack(gaps[1:]).all(axis=0), jnp.stack(point)
