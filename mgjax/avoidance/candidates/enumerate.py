"""Candidates: all walks from a node whose avoidance part comes at about the right time (eq. 1)."""

from __future__ import annotations

from dataclasses import dataclass, field

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


@dataclass(frozen=True, kw_only=True, eq=False)
class _Grown:
    """How walks came about that grow all at once; each round has two levels.

    Attributes:
        came_from: of each walk that was extended, the walk of the level before; then of each that
            goes on, the one that was extended. [levels][W]
        via: the edge it was extended by; none where it only goes on. [levels][W]
        found: level, row in it, part and t_avoid of the candidates of each round. [rounds][4][C]
    """

    came_from: list[Int[np.ndarray, " W"]] = field(default_factory=list)
    via: list[Int[np.ndarray, " W"]] = field(default_factory=list)
    found: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list)

    def edges_to(
        self, level: Int[np.ndarray, " C"], row: Int[np.ndarray, " C"]
    ) -> Int[np.ndarray, "C L"]:
        """Edges of the walks with the given rows: each is followed back to its first edge."""
        length, row = level // 2 + 1, row.copy()
        edges = np.full((len(row), int(length.max())), NO_EDGE)
        for depth in range(int(length.max()) - 1, -1, -1):
            here = length > depth
            edges[here, depth] = self.via[2 * depth][row[here]]
            row[here] = self.came_from[2 * depth][row[here]]
            if depth:
                row[here] = self.came_from[2 * depth - 1][row[here]]
        return edges


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
    grown = _Grown()
    overflow = 0
    while len(nodes):
        row, position = expand_rows(graph.out_first, nodes)
        edge = graph.out_edges[position]
        begin = times[row]
        hit, position = expand_rows(tables.part_first, edge)
        part = tables.part_ids[position]
        t_avoid = begin[hit] + tables.part_centre[part]
        fits = (t_avoid > low) & (t_avoid < high)
        grown.came_from.append(row.astype(np.int32))
        grown.via.append(edge.astype(np.int32))
        if fits.any():
            level = np.full(np.count_nonzero(fits), len(grown.via) - 1)
            grown.found.append((level, hit[fits], part[fits], t_avoid[fits]))
        end = begin + tables.seconds[edge]
        target = graph.edge_target[edge]
        go_on = np.flatnonzero(end + tables.nearest_part[target] < high)
        if len(go_on) > MAX_WALKS:
            overflow += len(go_on) - MAX_WALKS
            go_on = go_on[np.arange(MAX_WALKS) * len(go_on) // MAX_WALKS]  # from all beginnings
        nodes, times = target[go_on], end[go_on]
        # Rows of the next round count within the walks that go on.
        grown.came_from.append(go_on.astype(np.int32))
        grown.via.append(np.zeros(0, dtype=np.int64))
    if not grown.found:
        empty = np.zeros(0, dtype=np.int64)
        return Candidates(
            edges=np.full((0, 1), NO_EDGE), length=empty, part=empty, overflow=overflow
        )
    level, row, part, t_all = (np.concatenate(column) for column in zip(*grown.found, strict=True))
    order = np.argsort(np.abs(t_all - t_attack), kind="stable")
    overflow += max(len(order) - capacity, 0)
    chosen = np.sort(order[:capacity])
    edges = grown.edges_to(level[chosen], row[chosen])
    return Candidates(
        edges=edges, length=level[chosen] // 2 + 1, part=part[chosen], overflow=overflow
    )


def natural_times(tables: EdgeTables, candidates: Candidates) -> Float[np.ndarray, " C"]:
    """t_avoid of each candidate at natural speed, s from the beginning of its walk."""
    column = np.arange(candidates.edges.shape[1])
    before = column[None] < candidates.length[:, None] - 1
    seconds = np.where(before, tables.seconds[np.maximum(candidates.edges, 0)], 0.0)
    return seconds.sum(axis=1) + tables.part_centre[candidates.part]
