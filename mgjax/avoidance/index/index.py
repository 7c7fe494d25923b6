"""The grid index: which walks avoid something that passes through given cells (§5.1).

For every node, the walks to an avoidance part that comes soon enough, and the 10 cm cells of the
node's planar frame that the avoidance volume of each one touches. They grow with the body: in units
of :attr:`GridIndex.scale` metres, cell (i, j, k) is the cube
[0.1 i, 0.1 i + 0.1] × [0.1 j, …] × [0.1 k, …]; its eight sub-points are the centres of its
eighths. It belongs to a walk if one of them lies inside the body at the start of the part and
outside the body at another sampled moment of it, both placed by the walk.

Deviation: the paper keeps a list of paths for every cell. Here neither the cells of a path nor most
of the paths are stored, as both follow from less: a path's volume is that of its part, kept once
(:mod:`~mgjax.avoidance.index.part_volumes`) and placed by the path; and a long path is put together
from stretches that many share (:mod:`~mgjax.avoidance.index.paths`). The answers are the same.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Int, UInt

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop
from mgjax.avoidance.attacks.transform import of_size
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.index.found_paths import FoundPaths, edges_of, paths_between, places_of
from mgjax.avoidance.index.part_volumes import PartVolumes
from mgjax.avoidance.index.placed_parts import PlacedParts, cells_of
from mgjax.avoidance.index.swept_cells import SweptCells, swept_cells
from mgjax.avoidance.index.walk_table import Arrivals, WalkTable
from mgjax.graph.types import NO_EDGE


@dataclass(frozen=True, kw_only=True, eq=False)
class GridIndex:
    """Of a graph's nodes the walks that paths are put together from, and of its parts the volumes.

    Paths of a node are in the order in which they are enumerated: by length, then by the out-edges
    taken, then by part. Times are half frames, so they are whole numbers.

    Attributes:
        horizon: latest t_avoid that is known, s.
        half_frames: per second.
        scale: of the body: places are in units of so many metres.
        fingerprint: of the graph.
        report: of the build, JSON values.
        complete: until when the arrivals of a node are all its paths, half frames. [N]
        nearest: half frames from a node to its nearest part; more than the horizon if that is
            later. [N]
        arrivals, jumps: see :class:`~mgjax.avoidance.index.paths.StoredPaths`.
        parts: the volumes.
    """

    horizon: float
    half_frames: float
    scale: float
    fingerprint: str
    report: dict[str, Any]
    complete: Int[np.ndarray, " N"]
    nearest: UInt[np.ndarray, " N"]
    arrivals: Arrivals
    jumps: WalkTable
    parts: PartVolumes

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        return sum(array.nbytes for array in arrays_of(self).values())

    @cached_property
    def nodes(self) -> int:
        """Number of nodes of the graph."""
        return len(self.complete)

    def in_time(self, node: int, t_attack: float, window: float) -> FoundPaths | None:
        """All paths of a node with t_avoid in the window (eq. 1), in the order of an enumeration.

        None where the index cannot say: the window ends after the horizon, or there are too many.
        """
        low, high = t_attack - window / 2, t_attack + window / 2
        return None if high > self.horizon else self._between(node, low, high)

    def of_node(self, node: int) -> FoundPaths | None:
        """All paths of a node within the horizon; None if there are too many."""
        return self._between(node, -1.0, self.horizon + 0.5 / self.half_frames)

    def _between(self, node: int, low: float, high: float) -> FoundPaths | None:
        return paths_between(
            self.arrivals,
            self.jumps,
            self.complete,
            self.nearest,
            node,
            low,
            high,
            self.half_frames,
        )

    def touched(
        self, paths: FoundPaths, attack: Attack, crop: Crop
    ) -> Bool[np.ndarray, " C"] | None:
        """Which paths of a node have a cell that a cropped attack passes through (§5.1).

        The attack is in the node's planar frame. None where it leaves the space that is covered.
        """
        cells = swept_cells(of_size(attack, 1 / self.scale), crop)
        return None if cells is None else self.touched_by(paths, cells)

    def touched_by(self, paths: FoundPaths, cells: SweptCells) -> Bool[np.ndarray, " C"]:
        """Which paths of a node have one of the cells, which are in the node's planar frame.

        Lengths of the cells are in units of ``scale`` metres.
        """
        return self.placed(paths).touched_by(cells)

    def walks(self, paths: FoundPaths) -> Candidates:
        """The edges of paths, as candidates."""
        return Candidates(
            edges=edges_of(self.arrivals, self.jumps, paths, NO_EDGE),
            length=paths.length,
            part=self.arrivals.end[paths.arrival].astype(np.int64),
            overflow=0,
        )

    def placed(self, paths: FoundPaths) -> PlacedParts:
        """The parts of paths, in the frame of their node, in units of ``scale`` metres."""
        turn, where = places_of(self.arrivals, self.jumps, paths)
        part = self.arrivals.end[paths.arrival].astype(np.int64)
        return PlacedParts(volumes=self.parts, part=part, turn=turn, where=where)

    def cells(self, paths: FoundPaths) -> tuple[Int[np.ndarray, " M"], Int[np.ndarray, "M 3"]]:
        """All cells of paths: which path each is of, and the cell, those of a path ascending."""
        return cells_of(self.placed(paths))

    def paths_per_cell(self, node: int, most: int = 100_000) -> Int[np.ndarray, " M"] | None:
        """How many paths of a node touch each cell that any of them touches.

        None if the node has more than ``most`` paths.
        """
        paths = self.of_node(node)
        if paths is None or len(paths) > most:
            return None
        return np.unique(self.cells(paths)[1], axis=0, return_counts=True)[1]


def arrays_of(record: Any) -> dict[str, np.ndarray]:
    """The arrays of an index by name; those of its records have names like ``jumps.end``."""
    arrays: dict[str, np.ndarray] = {}
    for field in fields(record):
        value = getattr(record, field.name)
        if isinstance(value, np.ndarray):
            arrays[field.name] = value
        elif is_dataclass(value):
            arrays |= {f"{field.name}.{name}": array for name, array in arrays_of(value).items()}
    return arrays
