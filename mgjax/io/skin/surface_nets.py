"""A closed surface where a field on a grid changes its sign (naive surface nets, Gibson 1998).

One vertex in each cell that the surface passes, at the middle of where it crosses the cell's edges,
and one quad across each edge of the grid whose ends have different signs.
"""

from __future__ import annotations

import itertools

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

_CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
_EDGES = [
    (a, b)
    for a, b in itertools.combinations(range(8), 2)
    if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1
]


def surface_nets(
    values: Float[np.ndarray, "X Y Z"],
) -> tuple[Float[np.ndarray, "V 3"], Int[np.ndarray, "T 3"]]:
    """The surface around where values are negative, in steps of the grid from its first corner.

    Values at the grid's border must be positive. Every edge of a triangle belongs to exactly one
    other one: where the signs on a face of the grid leave open which corners are connected, the
    ones outside are taken inside.

    Returns:
        Vertices, and triangles counter-clockwise from outside.
    """
    values = _decided(np.array(values, dtype=np.float64))
    inside = values < 0
    cells = tuple(n - 1 for n in values.shape)
    corner = [
        values[tuple(slice(o, o + n) for o, n in zip(offset, cells, strict=True))]
        for offset in _CORNERS
    ]
    count = sum((c < 0).astype(np.int8) for c in corner)
    active = np.nonzero(np.asarray((count > 0) & (count < 8)))
    total, crossings = np.zeros((len(active[0]), 3)), np.zeros(len(active[0]))
    for a, b in _EDGES:
        one, other = corner[a][active], corner[b][active]
        crosses = (one < 0) != (other < 0)
        share = np.where(crosses, one / np.where(crosses, one - other, 1.0), 0.0)
        place = _CORNERS[a] + share[:, None] * (_CORNERS[b] - _CORNERS[a])
        total += np.where(crosses[:, None], place, 0.0)
        crossings += crosses
    vertices = np.stack(active, axis=1) + total / crossings[:, None]
    number = np.full(cells, -1, np.int64)
    number[active] = np.arange(len(active[0]))
    triangles = np.concatenate([_across(inside, number, axis) for axis in range(3)])
    return _split(vertices, triangles)


def _split(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One vertex for each sheet where two sheets meet in one point of a cell."""
    corner = np.arange(triangles.size).reshape(-1, 3)
    starts = np.concatenate([triangles[:, i] for i in range(3)])
    ends = np.concatenate([triangles[:, (i + 1) % 3] for i in range(3)])
    at_start = np.concatenate([corner[:, i] for i in range(3)])
    at_end = np.concatenate([corner[:, (i + 1) % 3] for i in range(3)])
    there = np.argsort(starts * len(vertices) + ends)  # each edge once in each direction
    back = np.argsort(ends * len(vertices) + starts)
    ones = np.concatenate([at_start[there], at_end[there]])
    others = np.concatenate([at_end[back], at_start[back]])
    links = coo_array((np.ones(len(ones), bool), (ones, others)), shape=(triangles.size,) * 2)
    count, sheet = connected_components(links, directed=False)
    source = np.empty(count, np.int64)
    source[sheet] = triangles.ravel()
    return vertices[source], sheet.reshape(-1, 3)


def _across(inside: np.ndarray, number: np.ndarray, axis: int) -> np.ndarray:
    """Two triangles across each edge of the grid along one axis."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    first = [slice(None)] * 3
    second = [slice(None)] * 3
    first[axis], second[axis] = slice(None, -1), slice(1, None)
    change = inside[tuple(first)] != inside[tuple(second)]
    at = np.stack(np.nonzero(change), axis=1)
    leaves = inside[tuple(first)][tuple(at.T)]

    def cell(back_j: int, back_k: int) -> np.ndarray:
        place = at.copy()
        place[:, j] -= back_j
        place[:, k] -= back_k
        return number[tuple(place.T)]

    ring = np.stack([cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)], axis=1)
    ring = np.where(leaves[:, None], ring, ring[:, ::-1])
    return np.concatenate([ring[:, [0, 1, 2]], ring[:, [0, 2, 3]]])


def _decided(values: np.ndarray) -> np.ndarray:
    """Values without faces of the grid on which only opposite corners have one sign."""
    while True:
        inside = values < 0
        found = False
        for axis in range(3):
            j, k = (a for a in range(3) if a != axis)

            def shifted(array: np.ndarray, dj: int, dk: int, j: int = j, k: int = k) -> np.ndarray:
                cut = [slice(None)] * 3
                cut[j] = slice(dj, array.shape[j] - 1 + dj)
                cut[k] = slice(dk, array.shape[k] - 1 + dk)
                return array[tuple(cut)]

            a, b, c, d = (shifted(inside, *o) for o in ((0, 0), (1, 0), (1, 1), (0, 1)))
            open_faces = (a == c) & (b == d) & (a != b)
            if open_faces.any():
                found = True
                for o in ((0, 0), (1, 0)):
                    part = shifted(values, *o)
                    outside = open_faces & (part > 0)
                    part[outside] = -1e-3
        if not found:
            return values
