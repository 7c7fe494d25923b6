"""The grid index: which walks avoid something that passes through given cells (§5.1).

For every node, the walks to an avoidance part that comes soon enough, and the 10 cm cells of the
node's planar frame that the avoidance volume of each one touches. Cell (i, j, k) is the cube
[0.1 i, 0.1 i + 0.1] × [0.1 j, …] × [0.1 k, …] m; its eight sub-points are the centres of its
eighths. It belongs to a walk if one of them lies inside the body at the start of the part and
outside the body at another sampled moment of it, both placed by the walk.

Deviation: the paper keeps a list of paths for every cell. Here every path keeps its cells, as
columns with one bit for each height, and a node's paths lie together: with a hundred cells to a
path and a time window that leaves a fraction of the paths, reading those that are in time is as
quick, and a column with its bits takes 3 bytes where its cells would take 8. The answers are the
same. A walk is stored as its first edge and the walk of the next node that continues it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Int, UInt, UInt32

from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.index.cells import COVERED, HEIGHTS, LOWEST, SPAN, touched_cells
from mgjax.avoidance.index.swept_cells import SweptCells
from mgjax.core.errors import FileFormatError
from mgjax.graph.types import NO_EDGE, MotionGraph
from mgjax.io.store import load_arrays, save_arrays

FORMAT_VERSION = 1
FILE_NAME = "grid_index.safetensors"
__all__ = [
    "GridIndex",
    "cells_of",
    "fingerprint",
    "load_index",
    "lookup",
    "paths_per_cell",
    "save_index",
    "touched_cells",
]


@dataclass(frozen=True, kw_only=True, eq=False)
class GridIndex:
    """Per node its paths, and per path its walk and its cells.

    Paths of a node are in the order in which they are enumerated: by length, then by the out-edges
    taken, then by part. Times are half frames, so they are whole numbers.

    Attributes:
        horizon: latest t_avoid that was asked for, s.
        half_frames: per second.
        fingerprint: of the graph.
        report: of the build, JSON values.
        node_first: the paths of node n are node_first[n] … node_first[n+1] − 1. [N+1]
        node_limit: latest t_avoid up to which a node's paths are complete, half frames: the horizon
            unless the node has more paths than there was room for. [N]
        edge: first edge of a path. [P]
        follow: the path of that edge's target that continues it, P where there is none. [P+1]
        length: edges of a path. [P]
        part: the part at its end. [P]
        time: t_avoid, half frames. [P]
        origin: lowest column of the path's columns. [P]
        width: columns along z of their rectangle, at least 1. [P]
        column_first, column_count: the path's columns. [P]
        column: place in the rectangle, along x · width + along z. [X]
        code: row of ``masks``. [X]
        masks: bit b says that cell j = LOWEST + b of the column belongs to the path. [M]
    """

    horizon: float
    half_frames: float
    fingerprint: str
    report: dict[str, Any]
    node_first: Int[np.ndarray, " N1"]
    node_limit: Int[np.ndarray, " N"]
    edge: UInt[np.ndarray, " P"]
    follow: UInt[np.ndarray, " P1"]
    length: UInt[np.ndarray, " P"]
    part: UInt[np.ndarray, " P"]
    time: UInt[np.ndarray, " P"]
    origin: UInt[np.ndarray, " P"]
    width: UInt[np.ndarray, " P"]
    column_first: UInt[np.ndarray, " P"]
    column_count: UInt[np.ndarray, " P"]
    column: UInt[np.ndarray, " X"]
    code: UInt[np.ndarray, " X"]
    masks: UInt32[np.ndarray, " M"]

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        arrays = (getattr(self, f.name) for f in fields(self))
        return sum(a.nbytes for a in arrays if isinstance(a, np.ndarray))

    @cached_property
    def leaps(self) -> list[UInt[np.ndarray, " P1"]]:
        """The path after 1, 2, 4, … edges of a path, P where there is none; see ``follow``."""
        leaps = [self.follow]
        longest = int(self.length.max(initial=1))
        while 1 << len(leaps) < longest:
            leaps.append(leaps[-1][leaps[-1]])
        return leaps

    @cached_property
    def edge_or_none(self) -> Int[np.ndarray, " P1"]:
        """The first edge of a path, ``NO_EDGE`` for path P."""
        return np.append(self.edge.astype(np.int64), NO_EDGE)

    @cached_property
    def places(self) -> Int[np.ndarray, "W C"]:
        """Columns from the origin of a rectangle to a place in it, by width and place."""
        place = np.arange(int(self.column.max(initial=0)) + 1)
        x, z = np.divmod(
            place, np.maximum(np.arange(int(self.width.max(initial=0)) + 1), 1)[:, None]
        )
        return x * SPAN + z


_PLAIN = ("horizon", "half_frames", "fingerprint", "report")


def lookup(
    index: GridIndex,
    node: int,
    cells: SweptCells | Int[np.ndarray, "M 3"] | None,
    t_attack: float,
    window: float,
) -> Candidates | None:
    """The paths of a node that touch one of the cells, with t_avoid in the window (eq. 1).

    Args:
        index: of the graph.
        node: where the walks begin.
        cells: in the node's planar frame, see
            :func:`~mgjax.avoidance.index.swept_cells.swept_cells` and :func:`touched_cells`.
        t_attack: s from the beginning of the walk.
        window: T, s.

    Returns:
        The candidates in the order of
        :func:`~mgjax.avoidance.candidates.enumerate.enumerate_candidates`, perhaps none; or None
        where the index cannot say: the window ends after the horizon or after what there was room
        for at this node, or a cell lies outside the space that is covered.
    """
    if cells is None or (isinstance(cells, np.ndarray) and _outside(cells)):
        return None
    paths = paths_in_time(index, node, t_attack, window)
    return None if paths is None else walks_of(index, paths[touched_paths(index, paths, cells)])


def paths_in_time(
    index: GridIndex, node: int, t_attack: float, window: float
) -> Int[np.ndarray, " C"] | None:
    """All paths of a node with t_avoid in the window (eq. 1); None where the index cannot say."""
    low, high = t_attack - window / 2, t_attack + window / 2
    if high > index.horizon or high * index.half_frames > index.node_limit.item(node) + 1:
        return None
    first, stop = index.node_first[node], index.node_first[node + 1]
    time = index.time[first:stop] / index.half_frames
    return ((time > low) & (time < high)).nonzero()[0] + first


def touched_paths(
    index: GridIndex, paths: Int[np.ndarray, " C"], cells: SweptCells | Int[np.ndarray, "M 3"]
) -> Bool[np.ndarray, " C"]:
    """Which paths of a node have a cell that is touched."""
    if not paths.size:
        return np.zeros(0, bool)
    touched = np.zeros(len(paths), bool)
    if isinstance(cells, np.ndarray):
        rows, columns, masks = _columns(index, paths)
        touched[rows[(_image(cells)[columns] & masks) != 0]] = True
        return touched
    rows, columns, masks = _columns(index, paths, cells.first)
    touched[rows[(cells.sure.take(columns, mode="clip") & masks).nonzero()[0]]] = True
    if touched.all():
        return touched
    masks &= cells.perhaps().take(columns, mode="clip")
    masks[touched[rows]] = 0
    open_ = masks.nonzero()[0]
    if open_.size:
        which, some = _cells(columns[open_] + cells.first, masks[open_])
        touched[rows[open_[which[cells.touches(some)]]]] = True
    return touched


def _outside(cells: Int[np.ndarray, "M 3"]) -> bool:
    """Whether a cell lies outside the space that is covered."""
    return bool((cells < COVERED[0]).any() or (cells >= COVERED[1]).any())


def _image(cells: Int[np.ndarray, "M 3"]) -> UInt32[np.ndarray, " S"]:
    """Bits of the cells of every column."""
    image = np.zeros(SPAN * SPAN, np.uint32)
    column = (cells[:, 0] + SPAN // 2) * SPAN + cells[:, 2] + SPAN // 2
    np.bitwise_or.at(image, column, np.uint32(1) << (cells[:, 1] - LOWEST).astype(np.uint32))
    return image


def _columns(
    index: GridIndex, paths: Int[np.ndarray, " C"], lowest: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All columns of paths: the row of the path, the number less ``lowest``, the bits."""
    count = index.column_count[paths].astype(np.int64)
    rows = np.arange(len(paths)).repeat(count)
    first = index.column_first[paths] - (count.cumsum() - count)
    at = np.arange(len(rows)) + first[rows]
    table = index.width[paths] * np.int64(index.places.shape[1])
    columns = index.places.take(table[rows] + index.column[at])
    columns += (index.origin[paths] - np.int64(lowest))[rows]
    return rows, columns, index.masks[index.code[at]]


def _cells(
    columns: Int[np.ndarray, " X"], masks: UInt32[np.ndarray, " X"]
) -> tuple[Int[np.ndarray, " M"], Int[np.ndarray, "M 3"]]:
    """The cells of columns, and which of these each one is from."""
    which, bit = np.nonzero((masks[:, None] >> np.arange(HEIGHTS, dtype=np.uint32)) & 1)
    columns = columns[which]
    x = columns // SPAN
    z = columns - x * SPAN
    return which, np.stack([x - SPAN // 2, bit + LOWEST, z - SPAN // 2], axis=1)


def walks_of(index: GridIndex, paths: Int[np.ndarray, " C"]) -> Candidates:
    """The paths as walks."""
    length = index.length[paths].astype(np.int64)
    part = index.part[paths].astype(np.int64)
    rows = np.empty((int(length.max(initial=1)), len(paths)), np.int64)
    rows[0], known = paths, 1
    for leap in index.leaps:
        if known == len(rows):
            break
        more = min(known, len(rows) - known)
        rows[known : known + more] = leap[rows[:more]]
        known += more
    edges = index.edge_or_none.take(rows.T)
    return Candidates(edges=edges, length=length, part=part, overflow=0)


def cells_of(index: GridIndex, path: int) -> Int[np.ndarray, "M 3"]:
    """The cells of one path, in its node's planar frame, in ascending order."""
    _, columns, masks = _columns(index, np.array([path]))
    cells = _cells(columns, masks)[1]
    return cells[np.lexsort(cells.T[::-1])]


def paths_per_cell(index: GridIndex, node: int) -> Int[np.ndarray, " M"]:
    """How many paths touch each non-empty cell of a node."""
    paths = np.arange(index.node_first[node], index.node_first[node + 1])
    _, columns, masks = _columns(index, paths)
    counts = [
        np.bincount(columns[(masks >> np.uint32(bit)) & 1 == 1], minlength=1)
        for bit in range(HEIGHTS)
    ]
    return np.concatenate([c[c > 0] for c in counts])


def fingerprint(graph: MotionGraph) -> str:
    """A hash of everything of a graph that its index depends on."""
    digest = hashlib.blake2b(digest_size=16)
    digest.update(repr((graph.frame_rate, graph.skeleton.names, graph.skeleton.parents)).encode())
    digest.update(np.asarray(graph.skeleton.offsets).tobytes())
    for field in fields(graph):
        value = getattr(graph, field.name)
        if isinstance(value, np.ndarray):
            digest.update(f"{field.name} {value.dtype} {value.shape}".encode())
            digest.update(np.ascontiguousarray(value).tobytes())
    return digest.hexdigest()


def save_index(path: str | Path, index: GridIndex) -> None:
    """Writes the index into the folder of its graph."""
    arrays = {f.name: getattr(index, f.name) for f in fields(index) if f.name not in _PLAIN}
    metadata = {name: getattr(index, name) for name in _PLAIN}
    metadata["format_version"] = FORMAT_VERSION
    save_arrays(Path(path) / FILE_NAME, arrays, metadata)


def load_index(path: str | Path, graph: MotionGraph) -> GridIndex:
    """Reads the index of a graph from its folder.

    Raises:
        FileFormatError: there is none, it is damaged, or it belongs to another graph.
    """
    file = Path(path) / FILE_NAME
    arrays, metadata = load_arrays(file, "grid index")
    version = metadata.get("format_version")
    if version != FORMAT_VERSION:
        raise FileFormatError(
            file, None, f"format {version}", f"format {FORMAT_VERSION}; build anew"
        )
    if metadata.get("fingerprint") != fingerprint(graph):
        raise FileFormatError(
            file, None, "the index of another graph", "this graph's; build it anew"
        )
    names = {f.name for f in fields(GridIndex)} - set(_PLAIN)
    if set(arrays) != names or not set(_PLAIN) <= set(metadata):
        raise FileFormatError(file, None, "an incomplete index", "a whole one; build it anew")
    if not _is_sound(arrays, graph):
        raise FileFormatError(file, None, "arrays that do not fit", "a whole index; build it anew")
    return GridIndex(**arrays, **{name: metadata[name] for name in _PLAIN})


def _is_sound(arrays: dict[str, np.ndarray], graph: MotionGraph) -> bool:
    """Whether all arrays of an index fit one another and point at something."""
    paths, columns = arrays["edge"].size, arrays["code"].size
    sizes = dict.fromkeys(set(arrays), paths) | {"follow": paths + 1, "column": columns}
    sizes |= {"code": columns, "node_first": graph.num_nodes + 1, "node_limit": graph.num_nodes}
    sizes["masks"] = arrays["masks"].size
    if any(array.shape != (sizes[name],) for name, array in arrays.items()):
        return False
    first = arrays["node_first"]
    below = (
        (arrays["edge"], graph.num_edges),
        (arrays["part"], len(graph.label_edge)),
        (arrays["follow"], paths + 1),
        (arrays["code"], sizes["masks"]),
        (arrays["column_first"] + arrays["column_count"].astype(np.int64), columns + 1),
    )
    ordered = first[0] == 0 and first[-1] == paths and (np.diff(first) >= 0).all()
    whole = all(not a.size or int(a.max()) < limit for a, limit in below)
    return bool(ordered and whole and (arrays["width"] > 0).all())
