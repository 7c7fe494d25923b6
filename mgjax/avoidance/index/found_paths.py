"""Paths that are put together from what the grid index stores, when they are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Complex, Int, Integer

from mgjax.avoidance.index.walk_table import Arrivals, WalkTable
from mgjax.core.csr import expand

MOST = 200_000
"""Most unfinished walks of one round; where there are more, the index cannot say."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FoundPaths:
    """Paths of one node, in the order of an enumeration; ``paths[which]`` are some of them.

    Attributes:
        jumps: those that a path begins with, one after another, then −1. [C, J]
        arrival: by which it ends. [C]
        time: t_avoid, half frames. [C]
        length: edges. [C]
    """

    jumps: Int[np.ndarray, "C J"]
    arrival: Int[np.ndarray, " C"]
    time: Int[np.ndarray, " C"]
    length: Int[np.ndarray, " C"]

    def __len__(self) -> int:
        return len(self.arrival)

    def __getitem__(self, which: Bool[np.ndarray, " C"] | Int[np.ndarray, " D"]) -> FoundPaths:
        return FoundPaths(
            jumps=self.jumps[which],
            arrival=self.arrival[which],
            time=self.time[which],
            length=self.length[which],
        )


class _Level(NamedTuple):
    """Walks after equally many jumps: the walk before, its jump, and the place in the order."""

    before: np.ndarray
    jump: np.ndarray
    rank: np.ndarray


class _Hits(NamedTuple):
    """Arrivals in time, and the walks of a level that they continue."""

    row: np.ndarray
    arrival: np.ndarray
    rank: np.ndarray
    time: np.ndarray


def paths_between(
    arrivals: Arrivals,
    jumps: WalkTable,
    complete: Integer[np.ndarray, " N"],
    nearest: Integer[np.ndarray, " N"],
    node: int,
    low: float,
    high: float,
    half_frames: float,
) -> FoundPaths | None:
    """All paths of a node with low < t_avoid < high, s; None if there are too many.

    Args:
        arrivals, jumps: as in :class:`~mgjax.avoidance.index.paths.StoredPaths`.
        complete: until when the arrivals of a node are all its paths, half frames.
        nearest: half frames to the nearest part of each node.
        node, low, high: what is asked.
        half_frames: per second.
    """
    nodes, times = np.array([node]), np.zeros(1, np.int64)
    levels: list[_Level] = []
    hits: list[_Hits] = []
    while True:
        whole = high * half_frames - times <= complete[nodes] + 1
        # Of nodes that are not whole, those that no jump leads to.
        row, item = arrivals.of_nodes(nodes)
        time, rank = times[row] + arrivals.time[item], arrivals.rank[item]
        seconds, of_whole = time / half_frames, whole[row]
        fits = ((seconds > low) & (seconds < high) & (of_whole | (rank > 0))).nonzero()[0]
        rank = np.where(of_whole, item, rank)
        hits.append(_Hits(row[fits], item[fits], rank[fits], time[fits]))
        open_ = (~whole).nonzero()[0]
        if not open_.size:
            break
        row, jump = jumps.of_nodes(nodes[open_])
        row = open_[row]
        times = times[row] + jumps.time[jump]
        nodes = jumps.end[jump].astype(np.int64)
        on = ((times + nearest[nodes]) / half_frames < high).nonzero()[0]
        if not on.size:
            break
        if len(on) > MOST:
            return None
        nodes, times, jump = nodes[on], times[on], jump[on]
        levels.append(_Level(row[on], jump, jumps.rank[jump]))
    return _in_order(arrivals, jumps, levels, hits)


def _in_order(
    arrivals: Arrivals, jumps: WalkTable, levels: list[_Level], hits: list[_Hits]
) -> FoundPaths:
    """All that was found, by length, then by the out-edges taken, then by part.

    Where neither of two walks begins with the other, the order of out-edges is decided within the
    node at which they part.
    """
    count = sum(len(h.row) for h in hits)
    chain = np.full((count, len(levels)), -1)
    keys = np.zeros((len(levels) + 1, count), np.int64)
    length = arrivals.length[np.concatenate([h.arrival for h in hits])].astype(np.int64)
    begin = 0
    for depth, hit in enumerate(hits):
        own = slice(begin, begin + len(hit.row))
        keys[depth, own], row = hit.rank, hit.row
        for at in range(depth - 1, -1, -1):
            level = levels[at]
            jump = level.jump[row]
            chain[own, at], keys[at, own] = jump, level.rank[row]
            length[own] += jumps.length[jump]
            row = level.before[row]
        begin = own.stop
    found = FoundPaths(
        jumps=chain,
        arrival=np.concatenate([h.arrival for h in hits]),
        time=np.concatenate([h.time for h in hits]),
        length=length,
    )
    return found[np.lexsort((*keys[::-1], length))] if levels else found


def edges_of(
    arrivals: Arrivals, jumps: WalkTable, paths: FoundPaths, fill: int
) -> Int[np.ndarray, "C L"]:
    """The edges of paths, padded with ``fill``."""
    chain, arrival = [*paths.jumps.T], paths.arrival
    while (on := arrivals.rank[arrival] == 0).any():
        own, begun = on.nonzero()[0], arrival[on]
        node = arrivals.first.searchsorted(begun, "right") - 1
        jump = jumps.first[node].astype(np.int64) + arrivals.jump[begun]
        first = arrivals.first[jumps.end[jump]].astype(np.int64)
        chain.append(np.full(len(arrival), -1))
        chain[-1][own] = jump
        arrival = arrival.copy()
        arrival[own] = first + arrivals.then[begun]
    stretches = np.stack([*chain, arrival], axis=1)
    first, length = (np.zeros(stretches.shape, np.int64) for _ in range(2))
    there = stretches[:, :-1] >= 0
    jump = stretches[:, :-1][there]
    first[:, :-1][there], length[:, :-1][there] = jumps.first_edge[jump], jumps.length[jump]
    first[:, -1], length[:, -1] = arrivals.first_edge[arrival], arrivals.length[arrival]
    stretch, number = expand(length.ravel())
    at = first.ravel()[stretch] + number
    last = stretch % stretches.shape[1] == stretches.shape[1] - 1
    flat = np.empty(len(at), np.int64)
    flat[last], flat[~last] = arrivals.edges[at[last]], jumps.edges[at[~last]]
    edges = np.full((len(paths), int(paths.length.max(initial=1))), fill)
    edges[np.arange(edges.shape[1]) < paths.length[:, None]] = flat
    return edges


def places_of(
    arrivals: Arrivals, jumps: WalkTable, paths: FoundPaths
) -> tuple[Complex[np.ndarray, " C"], Complex[np.ndarray, " C"]]:
    """Planar frames of the nodes at which the parts' edges begin, in that of the paths' node.

    Returns:
        e^(iθ) of their turns θ; x + i z of their origins, m. A point p = x + i z of such a frame
        is at where + e^(−iθ) p.
    """
    inner = np.empty((len(paths), paths.jumps.shape[1] + 1, 3))
    inner[:, :-1] = jumps.place[np.maximum(paths.jumps, 0)]
    inner[:, :-1][paths.jumps < 0] = 0.0
    inner[:, -1] = arrivals.place[paths.arrival]
    turn = np.exp(1j * inner[..., 0].cumsum(axis=1))
    where = inner[..., 1] + 1j * inner[..., 2]
    where[:, 1:] *= turn[:, :-1].conj()
    return turn[:, -1], where.sum(axis=1)
