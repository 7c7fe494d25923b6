"""Building the grid index (§5.1): all paths within the horizon, and the cells of each.

The avoidance volume of a path is that of its part, moved by a planar transform, so heights stay.
Each part is therefore rasterised once, seen from above, with one bit for each cell of height, and a
path reads the pixels below the sub-points of its node's cells. What stays open, near the surfaces,
is decided by the spheres themselves, so that the cells are exactly those of the definition.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int, Integer, UInt32
from tqdm import tqdm

from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables, of_size
from mgjax.avoidance.index.cells import CELL_M, LOWEST
from mgjax.avoidance.index.files import fingerprint
from mgjax.avoidance.index.index import GridIndex
from mgjax.avoidance.index.part_volumes import (
    PIXEL_M,
    PartVolumes,
    part_volumes,
    touched_by,
)
from mgjax.avoidance.index.paths import Paths, grid_paths
from mgjax.avoidance.index.rectangles import Rectangles, rectangles
from mgjax.core.arrays import Array
from mgjax.core.xla.padding import pad_axis
from mgjax.core.xla.pytree import register
from mgjax.graph.types import MotionGraph

CAPACITY = 512
"""Most paths of a node: more are needed only where very many parts are near, and weigh most."""
_WORDS = 1 << 21
_THREADS = min(4, os.cpu_count() or 1)
_AREAS = np.array([32, 64, 96, 128, 192, 256])
"""Columns of a path's rectangle are padded to one of these, then to their doubles."""


def build_index(
    graph: MotionGraph,
    *,
    horizon: float = 2.0,
    rate: float = 30.0,
    capacity: int = CAPACITY,
    progress: bool = False,
) -> GridIndex:
    """The index of all paths with t_avoid ≤ horizon at natural speed (§5.1).

    Args:
        graph: a motion graph with labelled avoidance parts.
        horizon: s.
        rate: moments per second at which a part's volume is sampled: its start, 1/rate s later and
            so on, and its end. Between the frames of the graph it is interpolated.
        capacity: most paths of a node; the index then knows up to when they are all there.
        progress: shows a bar.
    """
    return index_of_tables(
        graph,
        edge_tables(graph, graph.frame_rate),
        horizon=horizon,
        rate=rate,
        capacity=capacity,
        progress=progress,
    )


def index_of_tables(
    graph: MotionGraph,
    tables: EdgeTables,
    *,
    horizon: float,
    rate: float,
    capacity: int,
    progress: bool,
) -> GridIndex:
    """The index of a graph whose body volumes are those of given tables; see :func:`build_index`.

    Between the samples of the tables the volumes are interpolated. Cells grow with the body: all is
    done at the size of an adult.
    """
    tables = of_size(tables, 1 / graph.body_scale)
    clock = [time.perf_counter()]
    paths = grid_paths(graph, tables, horizon, capacity)
    clock.append(time.perf_counter())
    volumes = part_volumes(tables, rate, np.unique(paths.part))
    clock.append(time.perf_counter())
    boxes = rectangles(paths, volumes)
    columns = _columns(paths, volumes, boxes, progress)
    clock.append(time.perf_counter())
    latest = int(np.floor(horizon * 2 * graph.frame_rate + 1e-6))
    report = {
        "paths": len(paths.edge),
        "columns": len(columns["code"]),
        "cells": int(np.bitwise_count(columns["masks"])[columns["code"]].sum(dtype=np.int64)),
        "nodes_limited": int((paths.node_limit < latest).sum()),
        "rate": rate,
        "capacity": capacity,
        **dict(zip(("paths_s", "parts_s", "cells_s"), np.diff(clock).tolist(), strict=True)),
    }
    return GridIndex(
        horizon=horizon,
        scale=graph.body_scale,
        half_frames=2 * graph.frame_rate,
        fingerprint=fingerprint(graph),
        report=report,
        node_first=paths.node_first,
        node_limit=paths.node_limit.astype(np.int32),
        origin=boxes.origin.astype(np.uint16),
        width=_smallest(boxes.width),
        **{n: _smallest(getattr(paths, n)) for n in ("edge", "follow", "length", "part", "time")},
        **columns,
    )


def _smallest(values: Integer[np.ndarray, " P"]) -> np.ndarray:
    """Numbers ≥ 0 in as few bytes as hold them."""
    return values.astype(np.min_scalar_type(int(values.max(initial=0))))


@register()
@dataclass(frozen=True, kw_only=True)
class _Rasters:
    """The rasters of all parts, for the device; see :class:`PartVolumes`."""

    sure: UInt32[Array, " X"]
    maybe: UInt32[Array, " X"]
    base: Int[Array, " A"]
    rows: Float[Array, " A"]
    columns: Float[Array, " A"]


def _columns(
    paths: Paths, volumes: PartVolumes, boxes: Rectangles, progress: bool
) -> dict[str, np.ndarray]:
    """The columns of all paths, as the arrays of :class:`GridIndex`, and ``masks``."""
    count, first = (np.zeros(len(paths.part), np.int64) for _ in range(2))
    known = np.zeros(1 << int(volumes.maybe.max()).bit_length(), np.uint32)  # code + 1 of a mask
    masks: list[np.ndarray] = [np.zeros(0, np.uint32)]
    column, code = [np.zeros(0, np.uint8)], [np.zeros(0, np.uint8)]
    total = 0
    largest = int(boxes.area.max(initial=1)) - 1
    bar = tqdm(total=int((boxes.area > 0).sum()), disable=not progress, unit="path", desc="cells")
    for own, row, place, mask in _tiles(paths, volumes, boxes):
        count[own] = np.bincount(row, minlength=len(own))
        first[own] = total + np.cumsum(count[own]) - count[own]
        total += len(row)
        new = np.unique(mask[known[mask] == 0])
        known[new] = np.arange(len(new)) + sum(map(len, masks)) + 1
        masks.append(new)
        column.append(place.astype(np.min_scalar_type(largest)))
        code.append(_smallest(known[mask] - np.uint32(1)))
        bar.update(len(own))
    bar.close()
    return {
        "column_first": _smallest(first),
        "column_count": _smallest(count),
        "column": np.concatenate(column),
        "code": np.concatenate(code),
        "masks": np.concatenate(masks),
    }


def _tiles(
    paths: Paths, volumes: PartVolumes, boxes: Rectangles
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Many paths at once: the paths, and of each non-empty column its row in them, place, bits."""
    rasters = _Rasters(
        sure=jnp.asarray(volumes.sure),
        maybe=jnp.asarray(volumes.maybe),
        base=jnp.asarray(volumes.base, dtype=jnp.int32),
        rows=jnp.asarray(volumes.rows, dtype=jnp.float32),
        columns=jnp.asarray(volumes.columns, dtype=jnp.float32),
    )
    doubled = _AREAS[-1] << np.arange(1, 10)
    sizes = np.append(_AREAS, doubled)
    size = sizes[np.searchsorted(sizes, boxes.area)]
    order = np.lexsort((paths.part, size))
    order = order[boxes.area[order] > 0]
    tiles: list[np.ndarray] = []
    for area in np.unique(size[order]):
        these = order[size[order] == area]
        tiles += np.split(these, np.arange(_WORDS // area, len(these), _WORDS // area))

    def work(own: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        area = int(size[own[0]])
        tile = _WORDS // area
        sure, maybe = _read(
            rasters,
            pad_axis(boxes.place[own], tile),
            pad_axis(boxes.width[own].astype(np.float32), tile),
            pad_axis(boxes.area[own].astype(np.float32), tile, value=0),
            pad_axis(paths.part[own].astype(np.int32), tile),
            size=area,
        )
        return own, *_decide(paths, volumes, boxes, own, np.asarray(sure), np.asarray(maybe))

    with ThreadPoolExecutor(_THREADS) as pool:
        yield from pool.map(work, tiles)


@partial(jax.jit, static_argnames="size")
def _read(
    rasters: _Rasters,
    place: Float[Array, "T 4"],
    width: Float[Array, " T"],
    area: Float[Array, " T"],
    part: Int[Array, " T"],
    *,
    size: int,
) -> tuple[UInt32[Array, "T C"], UInt32[Array, "T C"]]:
    """Bits of the columns of paths where the volume surely is, and where it may be."""
    at = jnp.arange(size, dtype=jnp.float32)[None]
    x0, z0, c, s = (place[:, i, None] for i in range(4))
    along = jnp.floor((at + 0.5) / width[:, None])
    across = at - along * width[:, None]
    base, rows, columns = (t[part][:, None] for t in (rasters.base, rasters.rows, rasters.columns))
    sure, maybe = (jnp.zeros((len(width), size), jnp.uint32) for _ in range(2))
    for i in (0.25, 0.75):
        for k in (0.25, 0.75):
            x, z = CELL_M * (along + i), CELL_M * (across + k)
            u = jnp.floor((x0 + x * c - z * s) / PIXEL_M)
            v = jnp.floor((z0 + x * s + z * c) / PIXEL_M)
            inside = (u >= 0) & (u < rows) & (v >= 0) & (v < columns) & (at < area[:, None])
            pixel = base + (u * columns + v).astype(jnp.int32)
            pixel = jnp.where(inside, pixel, 0)
            sure |= jnp.take(rasters.sure, pixel, mode="clip")
            maybe |= jnp.take(rasters.maybe, pixel, mode="clip")
    return sure, maybe


def _decide(
    paths: Paths,
    volumes: PartVolumes,
    boxes: Rectangles,
    own: Int[np.ndarray, " T"],
    sure: UInt32[np.ndarray, "T1 C"],
    maybe: UInt32[np.ndarray, "T1 C"],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row, place and bits of the columns that are not empty once open cells are decided."""
    at = np.flatnonzero(maybe)
    mask = sure.reshape(-1)[at]
    open_ = maybe.reshape(-1)[at] & ~mask
    row = at // sure.shape[1]
    column = at - row * sure.shape[1]
    doubtful = np.flatnonzero(open_)
    bits = np.unpackbits(open_[doubtful].view(np.uint8), bitorder="little")
    cell = np.flatnonzero(bits)
    which = doubtful[cell >> 5]
    path = own[row[which]]
    width = boxes.width[path]
    along = column[which] // width
    corner = np.stack([along, (cell & 31) + LOWEST, column[which] - along * width])
    bits[cell] = touched_by(volumes, paths.part[path], boxes.place[path], corner)
    mask[doubtful] |= np.packbits(bits, bitorder="little").view(np.uint32)
    keep = np.flatnonzero(mask)
    return row[keep], column[keep], mask[keep]
