"""Rasterising the avoidance volumes of parts, seen from above, for the grid index."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int, UInt32
from tqdm import tqdm

from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.avoidance.index.cells import CELL_M, HEIGHTS, LOWEST
from mgjax.avoidance.index.part_volumes import (
    PIXEL_M,
    ROUNDING_M,
    PartVolumes,
    pack,
)
from mgjax.avoidance.index.walk_table import smallest
from mgjax.core.arrays import Array
from mgjax.core.csr import expand, row_starts
from mgjax.core.xla.padding import bucket_size, pad_axis

_SPLIT = 4  # pixels along a coarse one, of those that are looked at first
_TILE = 16384
_INNER = 5  # most points inside that are kept at one height
_DEEP_M = 0.01
_LAYERS = (2 * LOWEST, 2 * (LOWEST + HEIGHTS))


def part_volumes(
    tables: EdgeTables, rate: float, parts: Int[np.ndarray, " U"], *, progress: bool = False
) -> PartVolumes:
    """The volumes of all parts; those not among ``parts`` have an empty raster.

    Args:
        tables: with the body's volumes.
        rate: moments per second at which a part is sampled.
        parts: numbers of parts, without those that nothing leads to in time.
        progress: shows a bar.
    """
    count = len(tables.part_edge)
    bodies = [moments_of(tables, part, rate) for part in range(count)]
    most = bucket_size(max((len(b) for b in bodies), default=1))
    radii = tables.spheres.radii.astype(np.float32)
    shape, corner = np.zeros((count, 2), np.int64), np.zeros((count, 2))
    packed, inner = [b""] * count, [np.zeros((0, 3))] * count
    inner_count = np.zeros((count, HEIGHTS), np.int64)
    for part in tqdm(parts.tolist(), disable=not progress, unit="part", desc="volumes"):
        centres = pad_axis(bodies[part], most)
        raster, begin, inner[part], inner_count[part] = _rasterise(
            centres, len(bodies[part]), radii
        )
        raster, corner[part] = _cropped(raster, begin)
        shape[part] = raster.shape[1:]
        packed[part] = pack(raster)
    empty = np.zeros((0, 3, len(radii)), np.float32)
    ends = row_starts(inner_count.sum(axis=1))[:-1]
    return PartVolumes(
        radii=radii,
        moment_first=row_starts(np.array([len(b) for b in bodies], np.int64)),
        centres=np.concatenate([empty, *bodies]),
        rows=smallest(shape[:, 0]),
        columns=smallest(shape[:, 1]),
        corner=corner,
        inner_first=smallest(ends[:, None] + np.pad(np.cumsum(inner_count, 1), ((0, 0), (1, 0)))),
        inner=np.concatenate([np.zeros((0, 3)), *inner]).astype(np.float32),
        inner_bit=(expand(inner_count.ravel())[0] % HEIGHTS).astype(np.uint8),
        packed=np.frombuffer(b"".join(packed), np.uint8),
        packed_first=row_starts(np.array([len(p) for p in packed], np.int64)),
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
) -> tuple[UInt32[np.ndarray, "2 U V"], Float[np.ndarray, " 2"], np.ndarray, np.ndarray]:
    """Pixels of one part, sure and maybe, the corner of the first; points inside, and their counts.

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

    def depths(u: np.ndarray, v: np.ndarray, k: np.ndarray, pixel: float) -> tuple:
        middle = [corner[0] + (u + 0.5) * pixel, (k + 0.5) * half, corner[1] + (v + 0.5) * pixel]
        at = pixel * np.sqrt(0.5) + ROUNDING_M
        depth = _depth(np.stack(middle), centres, moments, radii, at)
        state = (depth > at).astype(np.int8) + (depth >= -at)  # 0 out, 1 open, 2 sure
        return state, depth

    u, v, k = (x.ravel() for x in np.meshgrid(*map(np.arange, size), layers, indexing="ij"))
    state, depth = depths(u, v, k, coarse)
    inner = _spread(k, depth)
    inner = inner[np.argsort(k[inner] // 2, kind="stable")]
    planar = corner + coarse * (np.stack([u[inner], v[inner]], axis=1) + 0.5)
    deep = np.concatenate([planar, depth[inner, None] - ROUNDING_M], axis=1)
    counts = np.bincount(k[inner] // 2 - LOWEST, minlength=HEIGHTS)
    words = np.zeros((2, *size), np.uint32)
    _set_bits(words[0], u, v, k, state == 2)
    words = np.repeat(words[0], _SPLIT, axis=0).repeat(_SPLIT, axis=1)
    words = np.stack([words, words])
    sub = np.arange(_SPLIT * _SPLIT)
    u, v, k = (x[state == 1, None] for x in (u, v, k))
    u, v, k = u * _SPLIT + sub // _SPLIT, v * _SPLIT + sub % _SPLIT, k + 0 * sub
    u, v, k = u.ravel(), v.ravel(), k.ravel()
    state, _ = depths(u, v, k, PIXEL_M)
    _set_bits(words[0], u, v, k, state == 2)
    _set_bits(words[1], u, v, k, state >= 1)
    return words, corner, deep, counts


def _spread(k: Int[np.ndarray, " Q"], depth: Float[np.ndarray, " Q"]) -> Int[np.ndarray, " D"]:
    """Some points that are deep enough, from all places at each height ``k``."""
    deep = np.flatnonzero(depth >= _DEEP_M)
    deep = deep[np.argsort(k[deep], kind="stable")]
    count = np.bincount(k[deep] - _LAYERS[0], minlength=1)
    layer, number = expand(count)
    kept = np.minimum(count, _INNER)[layer]
    step = number * kept // count[layer]
    return deep[(number == 0) | (step != (number - 1) * kept // count[layer])]


def _set_bits(
    words: np.ndarray, u: np.ndarray, v: np.ndarray, k: np.ndarray, on: np.ndarray
) -> None:
    bits = np.uint32(1) << (k[on] // 2 - LOWEST).astype(np.uint32)
    np.bitwise_or.at(words.reshape(-1), u[on] * words.shape[1] + v[on], bits)


def _cropped(
    raster: UInt32[np.ndarray, "2 U V"], corner: Float[np.ndarray, " 2"]
) -> tuple[UInt32[np.ndarray, "2 U1 V1"], Float[np.ndarray, " 2"]]:
    """Without empty rows and columns at the edges, but with one of each around what is left."""
    filled = [np.flatnonzero(raster[1].any(axis=axis)) for axis in (1, 0)]
    if not filled[0].size:
        return raster[:, :0, :0], corner
    low = np.array([along[0] for along in filled])
    (u, v), (after_u, after_v) = low, (along[-1] + 1 for along in filled)
    inner = raster[:, u:after_u, v:after_v]
    return np.pad(inner, ((0, 0), (1, 1), (1, 1))), corner + (low - 1) * PIXEL_M
