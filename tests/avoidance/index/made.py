"""Indices read cell by cell, bodies of one sphere, and attacks past a character."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.body.edge_tables import EdgeTables, edge_tables
from mgjax.avoidance.body.spheres import BodySpheres
from mgjax.avoidance.candidates.enumerate import Candidates
from mgjax.avoidance.index.build import CAPACITY, index_of_tables
from mgjax.avoidance.index.cells import COVERED
from mgjax.avoidance.index.found_paths import FoundPaths
from mgjax.avoidance.index.index import GridIndex
from mgjax.avoidance.index.swept_cells import SweptCells
from mgjax.graph.types import MotionGraph
from tests.avoidance.made import make_graph, throw

RATE = 30.0
SHORT_S = 1.3


def built(
    graph: MotionGraph, tables: EdgeTables, *, horizon: float = 2.0, rate: float = 30.0
) -> GridIndex:
    """The index of bodies that are not those of the graph."""
    return index_of_tables(
        graph, tables, horizon=horizon, rate=rate, capacity=CAPACITY, progress=False
    )


def paths_of(index: GridIndex, node: int) -> FoundPaths:
    """All paths of a node within the horizon."""
    paths = index.of_node(node)
    assert paths is not None
    return paths


def cells_of(index: GridIndex, node: int, path: int) -> np.ndarray:
    """The cells of one path of a node, in its planar frame, in ascending order. [M, 3]"""
    return index.cells(paths_of(index, node)[np.array([path])])[1]


def lookup(
    index: GridIndex,
    node: int,
    cells: SweptCells | np.ndarray | None,
    t_attack: float,
    window: float,
) -> Candidates | None:
    """The paths of a node in the window that have one of the cells; None where that is unknown.

    Swept cells are looked up; an array of cells is compared with all cells of every path.
    """
    paths = index.in_time(node, t_attack, window)
    if paths is None or cells is None:
        return None
    if isinstance(cells, SweptCells):
        return index.walks(paths[index.touched_by(paths, cells)])
    if (cells < COVERED[0]).any() or (cells >= COVERED[1]).any():
        return None
    which, own = index.cells(paths)
    looked = cell_set(np.unique(cells, axis=0))
    met = [path for path, cell in zip(which, own.tolist(), strict=True) if tuple(cell) in looked]
    return index.walks(paths[np.unique(np.array(met, np.int64))])


def all_of(index: GridIndex, node: int) -> Candidates:
    """Every path of a node as a walk, whether or not it has cells."""
    return index.walks(paths_of(index, node))


def pairs(candidates: Candidates) -> list[tuple[tuple[int, ...], int]]:
    rows = zip(candidates.edges, candidates.length, candidates.part, strict=True)
    return [(tuple(row[:length].tolist()), int(part)) for row, length, part in rows]


def cell_set(cells: np.ndarray) -> set:
    found = {tuple(cell) for cell in cells.tolist()}
    assert len(found) == len(cells)
    return found


def one_sphere(steps: list[tuple[float, float, float]]) -> tuple[MotionGraph, EdgeTables]:
    """Edge 0 leads to edge 1, with a part of two frames; the body is one sphere of 6 cm.

    Places are those at the beginning, the middle and the end of the part.
    """
    graph = make_graph([(0, 1, 15), (1, 0, 30)], [(1, 9, 11)])
    tables = edge_tables(graph, RATE)
    zero = np.zeros(1, np.int64)
    share, radii = np.zeros(1, np.float32), np.array([0.06], np.float32)
    spheres = BodySpheres(names=("one",), first=zero, second=zero, share=share, radii=radii)
    pool = np.zeros((len(tables.pool), 3), np.float32)
    first = int(tables.pool_first[1])
    pool[first + 9 : first + 12] = steps
    step = tables.step.copy()
    step[0] = (np.pi / 2, 1.0, 0.0)
    return graph, replace(tables, spheres=spheres, pool=pool, step=step)


def ball(*places: tuple[float, float, float], radius: float) -> tuple[Attack, Crop]:
    times = np.arange(float(len(places)))
    attack = Attack(times=times, centres=np.array(places)[:, None], radii=np.array([radius]))
    return attack, Crop(start=0.0, end=float(times[-1]))


def passing(rng: np.random.Generator, kind: str) -> tuple[Attack, Crop]:
    """An attack past the character, and a crop of it."""
    if kind in ("straight", "ballistic"):
        attack = throw(rng, gravity=kind == "ballistic", height=float(rng.uniform(0.3, 1.7)))
        crop = crop_attack(attack, radius=float(rng.uniform(0.4, 1.0)), height=2.3)
        assert crop is not None
        return attack, crop
    knots, spheres = int(rng.integers(1, 30)), int(rng.integers(1, 4))
    step = rng.normal(size=(knots, spheres, 3)) * rng.uniform(0, 0.1)
    if kind == "along cells":  # on their faces, so that it depends on the last bit
        step = np.round(step, 1) * rng.integers(0, 2, 3)
    centres = np.cumsum(step, axis=0) + np.round(rng.uniform((-0.3, 0.5, -0.3), (0.3, 1.7, 0.3)), 1)
    attack = Attack(
        times=np.sort(rng.uniform(0, 1, knots)),
        centres=centres,
        radii=rng.integers(1, 6, spheres) / 20,
        acceleration=float(rng.choice([0.0, 9.8])),
    )
    return attack, Crop(start=float(rng.uniform(0, 0.3)), end=float(rng.uniform(0.3, 1)))
