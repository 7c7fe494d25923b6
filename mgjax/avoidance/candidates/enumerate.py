"""Candidates: all walks from a node whose avoidance part comes at about the right time (eq. 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.core.csr import expand_rows
from mgjax.graph.types import NO_EDGE, MotionGraph

MAX_WALKS = 200_000
"""Most unfinished walks of one round; beyond, the search says that it overflowed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidates:
    """Walks with the avoidance part that each is meant for.

    Attributes:
        edges: padded with ``NO_EDGE``. [C, L]
        length: edges of each walk; the last one holds the part. [C]
        part: the part. [C]
        overflow: left out for lack of room: walks that satisfy eq. 1, and unfinished walks from
            which at least one such walk would have come.
    """

    edges: Int[np.ndarray, "C L"]
    length: Int[np.ndarray, " C"]
    part: Int[np.ndarray, " C"]
    overflow: int


def enumerate_candidates(
    graph: MotionGraph,
    tables: EdgeTables,
    node: int,
    t_attack: float,
    *,
    window: float,
    capacity: int,
) -> Candidates:
    """All walks from ``node`` with t_attack − T/2 < t_avoid < t_attack + T/2 (eq. 1).

    t_avoid is the middle of the part at natural speed, counted from the beginning of the walk. A
    walk ends with the edge that holds its part; earlier parts may be passed. The walks grow by one
    edge a round, all at once; those from which no part can be reached in time are dropped.

    Args:
        graph, tables: the graph and its tables.
        node: where the walks begin.
        t_attack: s from the beginning of the walk.
        window: T, s.
        capacity: most candidates; those nearest in time to the attack are kept.
    """
    low, high = t_attack - window / 2, t_attack + window / 2
    nodes, times = np.array([node]), np.zeros(1)
    came_from: list[np.ndarray] = []
    via: list[np.ndarray] = []
    found: list[tuple[int, np.ndarray, np.ndarray, np.ndarray]] = []  # round, row, part, t_avoid
    overflow = 0
    while len(nodes):
        row, position = expand_rows(graph.out_first, nodes)
        edge = graph.out_edges[position]
        begin = times[row]
        hit, position = expand_rows(tables.part_first, edge)
        part = tables.part_ids[position]
        t_avoid = begin[hit] + tables.part_centre[part]
        fits = (t_avoid > low) & (t_avoid < high)
        came_from.append(row.astype(np.int32))
        via.append(edge.astype(np.int32))
        if fits.any():
            found.append((len(via) - 1, hit[fits], part[fits], t_avoid[fits]))
        end = begin + tables.seconds[edge]
        target = graph.edge_target[edge]
        go_on = np.flatnonzero(end + tables.nearest_part[target] < high)
        if len(go_on) > MAX_WALKS:
            overflow += len(go_on) - MAX_WALKS
            go_on = go_on[np.arange(MAX_WALKS) * len(go_on) // MAX_WALKS]  # from all beginnings
        nodes, times = target[go_on], end[go_on]
        # Rows of the next round count within the walks that go on.
        came_from.append(go_on.astype(np.int32))
        via.append(np.zeros(0, dtype=np.int64))
    if not found:
        empty = np.zeros(0, dtype=np.int64)
        return Candidates(
            edges=np.full((0, 1), NO_EDGE), length=empty, part=empty, overflow=overflow
        )
    t_all = np.concatenate([f[3] for f in found])
    order = np.argsort(np.abs(t_all - t_attack), kind="stable")
    overflow += max(len(order) - capacity, 0)
    chosen = np.sort(order[:capacity])
    return _walks(found, came_from, via, chosen, overflow)


def natural_times(tables: EdgeTables, candidates: Candidates) -> Float[np.ndarray, " C"]:
    """t_avoid of each candidate at natural speed, s from the beginning of its walk."""
    column = np.arange(candidates.edges.shape[1])
    before = column[None] < candidates.length[:, None] - 1
    seconds = np.where(before, tables.seconds[np.maximum(candidates.edges, 0)], 0.0)
    return seconds.sum(axis=1) + tables.part_centre[candidates.part]


def _walks(
    found: list[tuple[int, np.ndarray, np.ndarray, np.ndarray]],
    came_from: list[np.ndarray],
    via: list[np.ndarray],
    chosen: np.ndarray,
    overflow: int,
) -> Candidates:
    """Follows the chosen walks back to their first edge."""
    level = np.concatenate([np.full(len(f[1]), f[0]) for f in found])[chosen]
    row = np.concatenate([f[1] for f in found])[chosen]
    part = np.concatenate([f[2] for f in found])[chosen]
    length = level // 2 + 1
    edges = np.full((len(chosen), int(length.max())), NO_EDGE)
    for depth in range(int(length.max()) - 1, -1, -1):
        here = length > depth
        edges[here, depth] = via[2 * depth][row[here]]
        row[here] = came_from[2 * depth][row[here]]
        if depth:
            row[here] = came_from[2 * depth - 1][row[here]]
    return Candidates(edges=edges, length=length, part=part, overflow=overflow)
