"""Which walks the grid index stores: to near parts all, and beyond them stretches to go on by.

All walks of a node within the horizon are hundreds and more, and grow exponentially with it. Two
things that are short suffice to make any of them: the shortest walks of every node that take at
least some time (``jumps``), and the walks to the parts whose edges begin before these end. Any
other walk to a part begins with one of the node's jumps and goes on with a walk of the node that it
leads to. So that a look-up has little to put together, the nearest of those are stored as well, as
a jump and what comes then.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.avoidance.index.walk_table import Arrivals, WalkTable, smallest
from mgjax.core import planar
from mgjax.core.csr import expand_rows, row_starts
from mgjax.graph.types import MotionGraph

LONGEST_S = 0.5
"""Longest time that jumps take at least."""
JUMPS = 6
"""Jumps of a node take less time at least if they would be more than so many."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StoredPaths:
    """What a node's paths are put together from.

    Attributes:
        arrivals: walks to a part: those whose last edge begins before the node's jumps end, which
            have a rank; and all others with t_avoid ≤ ``limit``. In the order of an enumeration.
        jumps: walks by which all others begin; ``end`` is a node.
        limit: latest t_avoid up to which a node's arrivals are all its paths, half frames. [N]
        nearest: half frames to the nearest part, one more than the horizon if it is later. [N]
        count: all paths within the horizon, those that are put together included.
    """

    arrivals: Arrivals
    jumps: WalkTable
    limit: Int[np.ndarray, " N"]
    nearest: Int[np.ndarray, " N"]
    count: int


class _Walks(NamedTuple):
    """Walks that are being made. Edges are padded with −1; ``place`` as in :class:`WalkTable`."""

    node: np.ndarray
    end: np.ndarray
    time: np.ndarray
    place: np.ndarray
    edges: np.ndarray

    def some(self, which: np.ndarray) -> _Walks:
        return _Walks(*(values[which] for values in self))


def stored_paths(
    graph: MotionGraph, tables: EdgeTables, horizon: float, capacity: int
) -> StoredPaths:
    """The walks that the index of a graph stores.

    Args:
        graph, tables: the graph and its tables.
        horizon: s.
        capacity: most paths of a node within its ``limit``.
    """
    latest = int(np.floor(horizon * 2 * graph.frame_rate + 1e-6))
    middle = part_middles(graph, tables)
    counts = _counts(graph, tables, middle, latest)
    limit = _limits(graph, counts, capacity)
    nearest = np.minimum(tables.nearest_part * 2 * graph.frame_rate, latest + 1)
    nearest = np.round(nearest).astype(np.int64)
    begun, jumps = _stretches(graph, tables, middle, latest, nearest)
    rank, rank_of_jumps = _ranks(graph, begun, jumps)
    table = _table(graph, jumps, rank_of_jumps)
    return StoredPaths(
        arrivals=_arrivals(graph, begun, rank, table, limit),
        jumps=table,
        limit=limit,
        nearest=nearest,
        count=int(counts.sum()),
    )


def part_middles(graph: MotionGraph, tables: EdgeTables) -> Int[np.ndarray, " A"]:
    """Half frames from the beginning of its edge to the middle of each part."""
    return graph.label_starts + graph.label_stops - 2 * graph.edge_starts[tables.part_edge]


def _counts(
    graph: MotionGraph, tables: EdgeTables, middle: Int[np.ndarray, " A"], latest: int
) -> Float[np.ndarray, "T N"]:
    """How many paths each node has with t_avoid at each half frame."""
    durations = 2 * graph.edge_frames
    counts = np.zeros((latest + 1, graph.num_nodes))
    begin = middle <= latest
    np.add.at(counts, (middle[begin], graph.edge_source[tables.part_edge[begin]]), 1.0)
    for t in range(latest + 1):
        edge = np.flatnonzero(durations <= t)
        ahead = counts[t - durations[edge], graph.edge_target[edge]]
        source = graph.edge_source[edge]
        counts[t] += np.bincount(source, weights=ahead, minlength=graph.num_nodes)
    return counts


def _limits(
    graph: MotionGraph, counts: Float[np.ndarray, "T N"], capacity: int
) -> Int[np.ndarray, " N"]:
    """Up to which t_avoid each node has at most ``capacity`` paths, half frames, or −1.

    Paths are made of those of the next nodes, so a limit there bounds it here, an edge later.
    """
    limit = (np.cumsum(counts, axis=0) <= capacity).sum(axis=0) - 1
    while True:
        closed = limit.copy()
        later = limit[graph.edge_target] + 2 * graph.edge_frames
        np.minimum.at(closed, graph.edge_source, later)
        if (closed == limit).all():
            return limit
        limit = closed


def _jump_times(graph: MotionGraph) -> Int[np.ndarray, " N"]:
    """How long each node's jumps take at least, half frames: the more, the fewer they are."""
    frames = max(int(LONGEST_S * graph.frame_rate), 1)
    durations, target, source = graph.edge_frames, graph.edge_target, graph.edge_source
    counts = np.ones((frames + 1, graph.num_nodes))
    for d in range(1, frames + 1):
        ahead = np.where(durations >= d, 1.0, counts[np.maximum(d - durations, 0), target])
        counts[d] = np.bincount(source, weights=ahead, minlength=graph.num_nodes)
    return 2 * np.maximum((counts[1:] <= JUMPS).sum(axis=0), 1)


def _stretches(
    graph: MotionGraph,
    tables: EdgeTables,
    middle: Int[np.ndarray, " A"],
    latest: int,
    nearest: Int[np.ndarray, " N"],
) -> tuple[_Walks, _Walks]:
    """The walks to parts whose edge begins before a node's jumps end, and these.

    Walks that reach no part within the horizon are dropped.
    """
    until = _jump_times(graph)
    root = np.arange(graph.num_nodes)
    edges = np.zeros((len(root), 0), np.int64)
    walks = _Walks(root, root, 0 * root, np.zeros((len(root), 3)), edges)
    begun, jumps = [], []
    while len(walks.node):
        row, position = expand_rows(graph.out_first, walks.end)
        edge = graph.out_edges[position]
        edges = np.concatenate([walks.edges[row], edge[:, None]], axis=1)
        hit, position = expand_rows(tables.part_first, edge)
        part, before = tables.part_ids[position], row[hit]
        at = walks.time[before] + middle[part]
        found = _Walks(walks.node[before], part, at, walks.place[before], edges[hit])
        begun.append(found.some(at <= latest))
        end, target = walks.time[row] + 2 * graph.edge_frames[edge], graph.edge_target[edge]
        place = np.asarray(planar.compose(walks.place[row], tables.step[edge]))
        grown = _Walks(walks.node[row], target, end, place, edges)
        grown = grown.some(end + nearest[target] <= latest)
        ended = grown.time >= until[grown.node]
        jumps.append(grown.some(ended))
        walks = grown.some(~ended)
    return _joined(begun), _joined(jumps)


def _joined(rounds: list[_Walks]) -> _Walks:
    """Walks one after another, padded to the longest."""
    longest = max(walks.edges.shape[1] for walks in rounds)
    edges = [
        np.pad(w.edges, ((0, 0), (0, longest - w.edges.shape[1])), constant_values=-1)
        for w in rounds
    ]
    columns = [np.concatenate(column) for column in zip(*(w[:-1] for w in rounds), strict=True)]
    return _Walks(*[*columns, np.concatenate(edges)])


def _ranks(
    graph: MotionGraph, begun: _Walks, jumps: _Walks
) -> tuple[Int[np.ndarray, " X"], Int[np.ndarray, " Z"]]:
    """Places of both in the order of out-edges taken, then parts, among those of their node."""
    both = _joined([begun, jumps])
    position = np.empty(graph.num_edges + 1, np.int64)
    position[graph.out_edges] = np.arange(graph.num_edges)
    position[-1] = -1  # of no edge
    order = np.lexsort((both.end, *position[both.edges].T[::-1], both.node))
    first = row_starts(np.bincount(both.node, minlength=graph.num_nodes))
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order)) - first[both.node[order]] + 1
    return rank[: len(begun.node)], rank[len(begun.node) :]


def _table(graph: MotionGraph, walks: _Walks, rank: Int[np.ndarray, " X"]) -> WalkTable:
    """A table of walks that all have a rank, in its order."""
    order = np.lexsort((rank, walks.node))
    edges = walks.edges[order]
    taken = edges >= 0
    return WalkTable(
        first=smallest(row_starts(np.bincount(walks.node, minlength=graph.num_nodes))),
        end=smallest(walks.end[order]),
        time=smallest(walks.time[order]),
        length=smallest(taken.sum(axis=1)),
        rank=smallest(rank[order]),
        place=walks.place[order].astype(np.float32),
        edges=smallest(edges[taken]),
    )


def _arrivals(
    graph: MotionGraph,
    begun: _Walks,
    rank: Int[np.ndarray, " X"],
    jumps: WalkTable,
    limit: Int[np.ndarray, " N"],
) -> Arrivals:
    """The walks that have a rank, and each node's others within its limit.

    Each round puts the jumps of all nodes before the walks of the round before. Walks of a node
    are in order by their length, then by the ranks of their jumps and arrival.
    """
    count = len(begun.node)
    none = np.zeros(count, np.int64)
    rounds = [
        {"node": begun.node, "end": begun.end, "time": begun.time, "place": begun.place}
        | {"length": (begun.edges >= 0).sum(axis=1), "jump": none, "then": none}
        | {"walk": np.arange(count), "ranks": rank[:, None]}
    ]
    node = np.repeat(np.arange(graph.num_nodes), np.diff(jumps.first))
    target, place = jumps.end.astype(np.int64), jumps.place.astype(np.float64)
    while len(rounds[-1]["node"]):
        last = rounds[-1]
        order = np.argsort(last["node"], kind="stable")
        first = row_starts(np.bincount(last["node"], minlength=graph.num_nodes))
        jump, position = expand_rows(first, target)
        item = order[position]
        time = jumps.time[jump] + last["time"][item]
        keep = time <= limit[node[jump]]
        jump, item = jump[keep], item[keep]
        base = sum(len(r["node"]) for r in rounds[:-1])
        rounds.append(
            {"node": node[jump], "end": last["end"][item], "time": time[keep]}
            | {"place": np.asarray(planar.compose(place[jump], last["place"][item]))}
            | {"length": jumps.length[jump] + last["length"][item]}
            | {"jump": jump - jumps.first[node[jump]], "then": base + item}
            | {"walk": np.full(len(jump), -1)}
            | {"ranks": np.concatenate([jumps.rank[jump][:, None], last["ranks"][item]], axis=1)}
        )
    return _in_order(graph, rounds, begun.edges)


def _in_order(
    graph: MotionGraph, rounds: list[dict[str, np.ndarray]], edges: Int[np.ndarray, "X L"]
) -> Arrivals:
    """A table of arrivals, those of each node in order; ``then`` numbers all as they came."""
    most = max(r["ranks"].shape[1] for r in rounds)
    for r in rounds:
        r["ranks"] = np.pad(r["ranks"], ((0, 0), (0, most - r["ranks"].shape[1])))
    flat = {name: np.concatenate([r[name] for r in rounds]) for name in rounds[0]}
    order = np.lexsort((*flat["ranks"].T[::-1], flat["length"], flat["node"]))
    moved = np.empty(len(order), np.int64)
    moved[order] = np.arange(len(order))
    whole: Bool[np.ndarray, " X"] = flat["walk"] >= 0
    first = row_starts(np.bincount(flat["node"], minlength=graph.num_nodes))
    if len(order):
        then = moved[flat["then"]] - first[flat["node"][flat["then"]]]
        flat["then"] = np.where(whole, 0, then)
    flat["rank"] = np.where(whole, flat["ranks"][:, 0], 0)
    own = edges[flat["walk"][order][whole[order]]]
    names = ("end", "time", "length", "rank", "jump", "then")
    return Arrivals(
        first=smallest(first),
        place=flat["place"][order].astype(np.float32),
        edges=smallest(own[own >= 0]),
        **{name: smallest(flat[name][order]) for name in names},
    )
