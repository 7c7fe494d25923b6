"""The grid index: which walks avoid something that passes through given cells (§5.1).

For every node, the walks to an avoidance part that comes soon enough, and the 10 cm cells of the
node's planar frame that the avoidance volume of each one touches. They grow with the body: in units
of :attr:`GridIndex.scale` metres, cell (i, j, k) is the cube
[0.1 i, 0.1 i + 0.1] × [0.1 j, …] × [0.1 k, …]; its eight sub-points are the centres of its
eighths. It belongs to a walk if one of them lies inside the body at the start of the part and
outside the body at another sampled moment of it, both placed by the walk.

Deviation: the paper keeps a list of paths for every cell. Here every path keeps its cells, as
columns with one bit for each height, and a node's paths lie together: with a hundred cells to a
path and a time window that leaves a fraction of the paths, reading those that are in time is as
quick, and a column with its bits takes 3 bytes where its cells would take 8. The answers are the
same. A walk is stored as its first edge and the walk of the next node that continues it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Int, UInt, UInt32

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.attacks.transform import of_size
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.index.cells import HEIGHTS, LOWEST, SPAN
from mgjax.avoidance.index.swept_cells import SweptCells, swept_cells
from mgjax.graph.types import NO_EDGE


@dataclass(frozen=True, kw_only=True, eq=False)
class GridIndex:
    """Per node its paths, and per path its walk and its cells.

    Paths of a node are in the order in which they are enumerated: by length, then by the out-edges
    taken, then by part. Times are half frames, so they are whole numbers.

    Attributes:
        horizon: latest t_avoid that was asked for, s.
        half_frames: per second.
        scale: of the body: places are in units of so many metres. Of indices that were written with
            cells of 10 cm for every body it is 1.
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
    scale: float
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
    def skip_links(self) -> list[UInt[np.ndarray, " P1"]]:
        """The path after 1, 2, 4, … edges of a path, P where there is none; see ``follow``."""
        links = [self.follow]
        longest = int(self.length.max(initial=1))
        while 1 << len(links) < longest:
            links.append(links[-1][links[-1]])
        return links

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

    def in_time(self, node: int, t_attack: float, window: float) -> Int[np.ndarray, " C"] | None:
        """All paths of a node with t_avoid in the window (eq. 1), in the order of an enumeration.

        None where the index cannot say: the window ends after the horizon, or after what there was
        room for at this node.
        """
        low, high = t_attack - window / 2, t_attack + window / 2
        if high > self.horizon or high * self.half_frames > self.node_limit.item(node) + 1:
            return None
        first, stop = self.node_first[node], self.node_first[node + 1]
        time = self.time[first:stop] / self.half_frames
        return ((time > low) & (time < high)).nonzero()[0] + first

    def touched(
        self, paths: Int[np.ndarray, " C"], attack: Attack, crop: Crop
    ) -> Bool[np.ndarray, " C"] | None:
        """Which paths of a node have a cell that a cropped attack passes through (§5.1).

        The attack is in the node's planar frame. None where it leaves the space that is covered.
        """
        cells = swept_cells(of_size(attack, 1 / self.scale), crop)
        return None if cells is None else self.touched_by(paths, cells)

    def touched_by(self, paths: Int[np.ndarray, " C"], cells: SweptCells) -> Bool[np.ndarray, " C"]:
        """Which paths of a node have one of the cells, which are in the node's planar frame.

        Lengths of the cells are in units of ``scale`` metres.
        """
        if not paths.size:
            return np.zeros(0, bool)
        touched = np.zeros(len(paths), bool)
        rows, columns, masks = self.columns(paths, cells.first)
        touched[rows[(cells.sure.take(columns, mode="clip") & masks).nonzero()[0]]] = True
        if touched.all():
            return touched
        masks &= cells.perhaps().take(columns, mode="clip")
        masks[touched[rows]] = 0
        open_ = masks.nonzero()[0]
        if open_.size:
            which, doubtful = column_cells(columns[open_] + cells.first, masks[open_])
            touched[rows[open_[which[cells.touches(doubtful)]]]] = True
        return touched

    def walks(self, paths: Int[np.ndarray, " C"]) -> Candidates:
        """The edges of paths, as candidates."""
        length = self.length[paths].astype(np.int64)
        part = self.part[paths].astype(np.int64)
        rows = np.empty((int(length.max(initial=1)), len(paths)), np.int64)
        rows[0], known = paths, 1
        for link in self.skip_links:
            if known == len(rows):
                break
            more = min(known, len(rows) - known)
            rows[known : known + more] = link[rows[:more]]
            known += more
        edges = self.edge_or_none.take(rows.T)
        return Candidates(edges=edges, length=length, part=part, overflow=0)

    def columns(
        self, paths: Int[np.ndarray, " C"], lowest: int = 0
    ) -> tuple[Int[np.ndarray, " X"], Int[np.ndarray, " X"], UInt32[np.ndarray, " X"]]:
        """All columns of paths: the row of the path, the number less ``lowest``, the bits."""
        count = self.column_count[paths].astype(np.int64)
        rows = np.arange(len(paths)).repeat(count)
        first = self.column_first[paths] - (count.cumsum() - count)
        at = np.arange(len(rows)) + first[rows]
        table = self.width[paths] * np.int64(self.places.shape[1])
        columns = self.places.take(table[rows] + self.column[at])
        columns += (self.origin[paths] - np.int64(lowest))[rows]
        return rows, columns, self.masks[self.code[at]]

    def paths_per_cell(self, node: int) -> Int[np.ndarray, " M"]:
        """How many paths of a node touch each cell that any of them touches."""
        paths = np.arange(self.node_first[node], self.node_first[node + 1])
        _, columns, masks = self.columns(paths)
        counts = [
            np.bincount(columns[(masks >> np.uint32(bit)) & 1 == 1], minlength=1)
            for bit in range(HEIGHTS)
        ]
        return np.concatenate([c[c > 0] for c in counts])


def column_cells(
    columns: Int[np.ndarray, " X"], masks: UInt32[np.ndarray, " X"]
) -> tuple[Int[np.ndarray, " M"], Int[np.ndarray, "M 3"]]:
    """The cells of columns given by number and bits, and which of these each one is from."""
    which, bit = np.nonzero((masks[:, None] >> np.arange(HEIGHTS, dtype=np.uint32)) & 1)
    columns = columns[which]
    x = columns // SPAN
    z = columns - x * SPAN
    return which, np.stack([x - SPAN // 2, bit + LOWEST, z - SPAN // 2], axis=1)
