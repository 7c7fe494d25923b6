"""The grid index in plain float64, one walk and cell at a time, written from the definitions."""

from __future__ import annotations

import math
from functools import cache
from itertools import product

import numpy as np

from tests.reference import kinematics
from tests.reference.avoidance import edge_places, sphere_places

CELL = 0.1
TIE = 1e-5
"""Sub-points this near to a surface may fall on either side, m."""


def walks_within(graph, node, horizon) -> list[tuple[tuple[int, ...], int]]:
    """All (walk, part) whose part's middle is at most ``horizon`` s after the beginning.

    In the order of an enumeration: by length, then by the out-edges taken, then by part.
    """
    found = []
    latest = round(2 * horizon * graph.frame_rate)

    def visit(at: int, walk: tuple[int, ...], places: tuple[int, ...], begin: int) -> None:
        for place, edge in enumerate(graph.edges_from(at).tolist()):
            longer, taken = (*walk, edge), (*places, place)
            for part in np.flatnonzero(graph.label_edge == edge).tolist():
                ends = int(graph.label_starts[part]) + int(graph.label_stops[part])
                if 2 * begin + ends - 2 * int(graph.edge_starts[edge]) <= latest:
                    found.append((len(longer), taken, part, longer))
            end = begin + int(graph.edge_stops[edge] - graph.edge_starts[edge])
            if 2 * end < latest:
                visit(int(graph.edge_target[edge]), longer, taken, end)

    visit(node, (), (), 0)
    return [(walk, part) for _, _, part, walk in sorted(found)]


class Bodies:
    """Spheres at times of an edge: sampled ``rate`` times a second or oftener, linear between."""

    def __init__(self, graph, spheres, rate: float) -> None:
        self.graph, self.spheres, self.rate = graph, spheres, rate
        self.frame = cache(self._frame)
        self.sample = cache(self._sample)

    def _frame(self, row: int) -> np.ndarray:
        graph, spheres = self.graph, self.spheres
        pose, _ = kinematics.forward(
            graph.skeleton.parents,
            graph.skeleton.offsets,
            graph.root_translation[row],
            graph.local_rotations[row],
        )
        return sphere_places(spheres.first, spheres.second, spheres.share, pose)

    def _sample(self, edge: int, number: int, steps: int) -> np.ndarray:
        frames = int(self.graph.edge_stops[edge] - self.graph.edge_starts[edge])
        where = frames * number / steps
        low = min(int(where + 1e-9), frames - 1)
        row = int(self.graph.edge_starts[edge]) + low
        return (1 - where + low) * self.frame(row) + (where - low) * self.frame(row + 1)

    def at(self, edge: int, time: float) -> np.ndarray:
        """[S, 3] in the coordinates of the edge's clip."""
        frames = int(self.graph.edge_stops[edge] - self.graph.edge_starts[edge])
        seconds = frames / self.graph.frame_rate
        steps = max(math.ceil(seconds * self.rate - 1e-6), 1)
        where = time / seconds * steps
        low = min(int(where + 1e-9), steps - 1)
        share = where - low
        return (1 - share) * self.sample(edge, low, steps) + share * self.sample(
            edge, low + 1, steps
        )


def part_times(graph, part, rate) -> list[float]:
    """Seconds within the edge: the start of the part, every 1/rate s after it, and its end."""
    begin = int(graph.edge_starts[graph.label_edge[part]])
    start = (int(graph.label_starts[part]) - begin) / graph.frame_rate
    stop = (int(graph.label_stops[part]) - begin) / graph.frame_rate
    times, k = [start], 1
    while start + k / rate < stop - 1e-9:
        times.append(start + k / rate)
        k += 1
    return [*times, stop]


def depths(points, bodies, radii) -> np.ndarray:
    """How deep points are inside the first body and outside some other; negative if they are not.

    points: [..., 3]; bodies: places of the spheres, [S, 3] each.
    """
    gaps = [
        (np.linalg.norm(points[..., None, :] - body, axis=-1) - radii).min(axis=-1)
        for body in bodies
    ]
    return np.minimum(-gaps[0], np.max(gaps, axis=0))


def cells_of_walk(bodies: Bodies, walk, part, rate) -> tuple[set, set]:
    """Cells of the avoidance volume in the frame of the first node: surely, and perhaps."""
    place = edge_places(bodies.graph, walk)[-1]
    spheres = [
        np.array([kinematics.planar_apply(place, p) for p in bodies.at(walk[-1], time)])
        for time in part_times(bodies.graph, part, rate)
    ]
    return cells_of_bodies(spheres, np.asarray(bodies.spheres.radii, np.float64))


def cells_of_bodies(spheres, radii) -> tuple[set, set]:
    """The same for given places of the spheres."""
    low = np.floor((spheres[0] - radii[:, None]).min(axis=0) / CELL).astype(int)
    high = np.floor((spheres[0] + radii[:, None]).max(axis=0) / CELL).astype(int)
    ranges = [range(a, b + 1) for a, b in zip(low, high, strict=True)]
    cells = np.array(list(product(*ranges)))
    middles = (cells + 0.5) * CELL
    gap = (np.linalg.norm(middles[:, None] - spheres[0], axis=-1) - radii).min(axis=-1)
    cells = cells[gap <= 0.5 * CELL]  # the sub-points are 0.43 cells from the middle
    corners = cells[:, None] + 0.25 + 0.5 * np.array(list(product((0, 1), repeat=3)))
    deepest = depths(corners * CELL, spheres, radii).max(axis=1)
    sure = {tuple(cell) for cell in cells[deepest > TIE].tolist()}
    perhaps = {tuple(cell) for cell in cells[np.abs(deepest) <= TIE].tolist()}
    return sure, perhaps


def touched(attack, start, stop, tie=1e-7) -> tuple[set, set]:
    """Cells that the capsules between knots meet: surely, and those within ``tie`` of doing so."""
    inner = [float(t) for t in attack.times if start < t < stop]
    times = np.array([start, *inner, stop])
    centres = attack.at(times)
    sure, perhaps = set(), set()
    for i, radius in enumerate(attack.radii):
        for a, b in zip(centres[:-1, i], centres[1:, i], strict=True):
            low = np.floor((np.minimum(a, b) - radius) / CELL).astype(int) - 1
            high = np.floor((np.maximum(a, b) + radius) / CELL).astype(int) + 1
            axes = [np.arange(p, q + 1) for p, q in zip(low, high, strict=True)]
            cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
            gap = segment_gap(a, b, cells * CELL)
            sure |= {tuple(c) for c in cells[gap < radius - tie].tolist()}
            perhaps |= {tuple(c) for c in cells[np.abs(gap - radius) <= tie].tolist()}
    return sure, perhaps - sure


def segment_gap(a, b, corners) -> np.ndarray:
    """Least distance of one segment to cells, by ternary search: the distance is convex."""

    def gap(share: np.ndarray) -> np.ndarray:
        point = a + share[:, None] * (b - a)
        away = np.maximum(np.maximum(corners - point, point - corners - CELL), 0)
        return np.linalg.norm(away, axis=1)

    low, high = np.zeros(len(corners)), np.ones(len(corners))
    for _ in range(80):
        left, right = low + (high - low) / 3, high - (high - low) / 3
        smaller = gap(left) <= gap(right)
        low, high = np.where(smaller, low, left), np.where(smaller, right, high)
    return gap(0.5 * (low + high))
