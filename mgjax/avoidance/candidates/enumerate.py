"""Candidates: all walks from a node whose avoidance part comes at about the right time (eq. 1)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.core.csr import expand_rows
from mgjax.core.xla.padding import pad_axis
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
        found: level, row in it, part, t_avoid and origin, the node that it begins at among several,
            of the candidates of each round. [rounds][5][C]
    """

    came_from: list[Int[np.ndarray, " W"]] = field(default_factory=list)
    via: list[Int[np.ndarray, " W"]] = field(default_factory=list)
    found: list[tuple[np.ndarray, ...]] = field(default_factory=list)

    def all_found(self) -> tuple[np.ndarray, ...]:
        """The columns of ``found``, of all rounds."""
        return tuple(np.concatenate(column) for column in zip(*self.found, strict=True))

    def edges_to(
        self, level: Int[np.ndarray, " C"], row: Int[np.ndarray, " C"]
    ) -> Int[np.ndarray, "C L"]:
        """Edges of the walks with the given rows: each is followed back to its first edge."""
        length = level // 2 + 1
        order = np.argsort(-length, kind="stable")
        length, row = length[order], row[order]
        # A row for each depth, which the longest walks come first in.
        edges = np.full((int(length[0]), len(row)), NO_EDGE, np.int32)
        for depth in range(int(length[0]) - 1, -1, -1):
            count = int(np.searchsorted(-length, -depth))
            here = row[:count]
            edges[depth, order[:count]] = self.via[2 * depth][here]
            here = self.came_from[2 * depth][here]
            row[:count] = self.came_from[2 * depth - 1][here] if depth else here
        return edges.T


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
    grown, overflow = _grow(graph, tables, np.array([node]), np.array([low]), np.array([high]))
    if not grown.found:
        return _none(overflow)
    level, row, part, t_all, _ = grown.all_found()
    order = np.argsort(np.abs(t_all - t_attack), kind="stable")
    overflow += max(len(order) - capacity, 0)
    chosen = np.sort(order[:capacity])
    edges = grown.edges_to(level[chosen], row[chosen])
    return Candidates(
        edges=edges, length=level[chosen] // 2 + 1, part=part[chosen], overflow=overflow
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class NodeCandidates:
    """What :func:`enumerate_candidates` finds at each of several nodes, one node after the other.

    Attributes:
        edges, length, part: see :class:`Candidates`; all of them are padded alike. [C, L], [C]
        t_avoid: the middle of each part at natural speed, s. [C]
        first: where the candidates of each node begin and, last, where they end. [N + 1]
        overflow: of each node. [N]
    """

    edges: Int[np.ndarray, "C L"]
    length: Int[np.ndarray, " C"]
    part: Int[np.ndarray, " C"]
    t_avoid: Float[np.ndarray, " C"]
    first: Int[np.ndarray, " N1"]
    overflow: Int[np.ndarray, " N"]

    def some(self, rows: Int[np.ndarray, " K"], overflow: int) -> Candidates:
        """Some of them, with how many were left out beside them."""
        length = self.length[rows]
        return Candidates(
            edges=self.edges[rows, : int(length.max(initial=1))],
            length=length,
            part=self.part[rows],
            overflow=overflow,
        )


def enumerate_nodes(
    graph: MotionGraph,
    tables: EdgeTables,
    nodes: Int[np.ndarray, " N"],
    low: Float[np.ndarray, " N"],
    high: Float[np.ndarray, " N"],
) -> NodeCandidates:
    """What :func:`enumerate_candidates` finds at each of several nodes, without a capacity.

    The walks of all nodes grow together, which takes a fraction of the time that they take one by
    one: most of that is spent on calls, not on walks.

    Args:
        graph, tables: the graph and its tables.
        nodes: where the walks begin.
        low, high: between which t_avoid lies, s.
    """
    many = len(nodes) > 1
    grown, overflow = _grow(graph, tables, nodes, low, high, give_up=many)
    if many and overflow:
        half = len(nodes) // 2
        halves = slice(None, half), slice(half, None)
        return _joined([enumerate_nodes(graph, tables, nodes[h], low[h], high[h]) for h in halves])
    none = np.zeros(0, dtype=np.int64)
    edges, length, part = _none(0).edges, none, none
    t_avoid, origin = np.zeros(0), none
    if grown.found:
        level, row, part, t_avoid, origin = grown.all_found()
        chosen = np.argsort(origin, kind="stable")
        part, t_avoid, origin = part[chosen], t_avoid[chosen], origin[chosen]
        edges, length = grown.edges_to(level[chosen], row[chosen]), level[chosen] // 2 + 1
    return NodeCandidates(
        edges=edges,
        length=length,
        part=part,
        t_avoid=t_avoid,
        first=np.searchsorted(origin, np.arange(len(nodes) + 1)),
        overflow=np.full(len(nodes), overflow),
    )


def _joined(several: list[NodeCandidates]) -> NodeCandidates:
    """The candidates of all their nodes."""
    longest = max(own.edges.shape[1] for own in several)
    wide = [pad_axis(own.edges, longest, axis=1, value=NO_EDGE) for own in several]
    firsts, count = [several[0].first], len(several[0].length)
    for own in several[1:]:
        firsts.append(own.first[1:] + count)
        count += len(own.length)
    return NodeCandidates(
        edges=np.concatenate(wide),
        length=np.concatenate([own.length for own in several]),
        part=np.concatenate([own.part for own in several]),
        t_avoid=np.concatenate([own.t_avoid for own in several]),
        first=np.concatenate(firsts),
        overflow=np.concatenate([own.overflow for own in several]),
    )


def _grow(
    graph: MotionGraph,
    tables: EdgeTables,
    origins: Int[np.ndarray, " N"],
    low: Float[np.ndarray, " N"],
    high: Float[np.ndarray, " N"],
    *,
    give_up: bool = False,
) -> tuple[_Grown, int]:
    """All walks from some nodes, and how many unfinished ones were left out for lack of room.

    With ``give_up`` nothing is left out: the search ends where there is no room.
    """
    nodes, times, origin = origins, np.zeros(len(origins)), np.arange(len(origins))
    grown, overflow = _Grown(), 0
    while len(nodes):
        row, position = expand_rows(graph.out_first, nodes)
        edge = graph.out_edges[position]
        begin, begun = times[row], origin[row]
        hit, position = expand_rows(tables.part_first, edge)
        part = tables.part_ids[position]
        t_avoid, owner = begin[hit] + tables.part_centre[part], begun[hit]
        fits = (t_avoid > low[owner]) & (t_avoid < high[owner])
        grown.came_from.append(row.astype(np.int32))
        grown.via.append(edge.astype(np.int32))
        if fits.any():
            level = np.full(np.count_nonzero(fits), len(grown.via) - 1)
            grown.found.append((level, hit[fits], part[fits], t_avoid[fits], owner[fits]))
        end = begin + tables.seconds[edge]
        target = graph.edge_target[edge]
        go_on = np.flatnonzero(end + tables.nearest_part[target] < high[begun])
        if len(go_on) > MAX_WALKS:
            overflow += len(go_on) - MAX_WALKS
            if give_up:
                break
            go_on = go_on[np.arange(MAX_WALKS) * len(go_on) // MAX_WALKS]  # from all beginnings
        nodes, times, origin = target[go_on], end[go_on], begun[go_on]
        # Rows of the next round count within the walks that go on.
        grown.came_from.append(go_on.astype(np.int32))
        grown.via.append(np.zeros(0, dtype=np.int64))
    return grown, overflow


def _none(overflow: int) -> Candidates:
    empty = np.zeros(0, dtype=np.int64)
    return Candidates(edges=np.full((0, 1), NO_EDGE), length=empty, part=empty, overflow=overflow)
