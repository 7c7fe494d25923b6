"""The paths of the grid index: from every node all walks to an avoidance part within a horizon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mgjax.avoidance.body.edge_tables import EdgeTables
from mgjax.core import planar
from mgjax.core.csr import expand_rows
from mgjax.graph.types import MotionGraph


@dataclass(frozen=True, kw_only=True, eq=False)
class Paths:
    """All paths, those of a node together; see :class:`~mgjax.avoidance.index.index.GridIndex`.

    Attributes:
        node_limit: latest t_avoid up to which the paths of a node are all there, half frames. [N]
        node_first: first path of each node. [N+1]
        edge, length, part, time: of each path. [P]
        follow: the path that continues it, P where there is none. [P+1]
        place: planar frame of the node at which the part's edge begins, in that of the path's. [P]
    """

    node_limit: Int[np.ndarray, " N"]
    node_first: Int[np.ndarray, " N1"]
    edge: Int[np.ndarray, " P"]
    follow: Int[np.ndarray, " P1"]
    length: Int[np.ndarray, " P"]
    part: Int[np.ndarray, " P"]
    time: Int[np.ndarray, " P"]
    place: Float[np.ndarray, "P 3"]


def grid_paths(graph: MotionGraph, tables: EdgeTables, horizon: float, capacity: int) -> Paths:
    """All walks with t_avoid ≤ horizon at natural speed, from every node at once.

    A path of n + 1 edges is an edge and a path of n edges from its target, so each round makes the
    paths of one more edge out of those of the round before. In a round the paths of a node are in
    the order of its out-edges and then in that of the target's paths, as in an enumeration.

    Args:
        graph, tables: the graph and its tables.
        horizon: s.
        capacity: most paths of a node.
    """
    latest = int(np.floor(horizon * 2 * graph.frame_rate + 1e-6))
    durations = 2 * graph.edge_frames
    middle = graph.label_starts + graph.label_stops - 2 * graph.edge_starts[tables.part_edge]
    limit = _limits(graph, tables, durations, middle, latest, capacity)
    node, edge = np.repeat(np.arange(graph.num_nodes), np.diff(graph.out_first)), graph.out_edges
    row, part = expand_rows(tables.part_first, edge)
    part = tables.part_ids[part]
    keep = middle[part] <= limit[node[row]]
    row, part = row[keep], part[keep]
    generation = {"node": node[row], "edge": edge[row], "part": part, "time": middle[part]}
    generation |= {"follow": np.full(len(row), -1), "place": np.zeros((len(row), 3))}
    rounds: list[dict[str, np.ndarray]] = []
    base = 0
    while len(generation["node"]):
        rounds.append(generation | {"length": np.full(len(generation["node"]), len(rounds) + 1)})
        counts = np.bincount(generation["node"], minlength=graph.num_nodes)
        row, item = expand_rows(np.concatenate([[0], np.cumsum(counts)]), graph.edge_target[edge])
        at = durations[edge[row]] + generation["time"][item]
        keep = at <= limit[node[row]]
        row, item = row[keep], item[keep]
        generation = {
            "node": node[row],
            "edge": edge[row],
            "part": generation["part"][item],
            "time": at[keep],
            "follow": item + base,
            "place": np.asarray(planar.compose(tables.step[edge[row]], generation["place"][item])),
        }
        base += len(rounds[-1]["node"])
    return _by_node(rounds, limit)


def _limits(
    graph: MotionGraph,
    tables: EdgeTables,
    durations: Int[np.ndarray, " E"],
    middle: Int[np.ndarray, " A"],
    latest: int,
    capacity: int,
) -> Int[np.ndarray, " N"]:
    """Up to which t_avoid each node has at most ``capacity`` paths, half frames.

    Paths are made of those of the next nodes, so a limit there bounds it here, an edge later.
    """
    counts = np.zeros((latest + 1, graph.num_nodes))
    begin = middle <= latest
    np.add.at(counts, (middle[begin], graph.edge_source[tables.part_edge[begin]]), 1.0)
    for t in range(latest + 1):
        edge = np.flatnonzero(durations <= t)
        ahead = counts[t - durations[edge], graph.edge_target[edge]]
        source = graph.edge_source[edge]
        counts[t] += np.bincount(source, weights=ahead, minlength=graph.num_nodes)
    limit = (np.cumsum(counts, axis=0) <= capacity).sum(axis=0) - 1
    while True:
        closed = limit.copy()
        np.minimum.at(closed, graph.edge_source, limit[graph.edge_target] + durations)
        if (closed == limit).all():
            return limit
        limit = closed


def _by_node(rounds: list[dict[str, np.ndarray]], limit: Int[np.ndarray, " N"]) -> Paths:
    """Puts the paths of each node together, the shorter ones first."""
    names = ("node", "edge", "part", "time", "follow", "length", "place")
    empty = {name: np.zeros((0, 3) if name == "place" else 0, np.int64) for name in names}
    flat = {n: np.concatenate([r[n] for r in (rounds or [empty])]) for n in names}
    order = np.argsort(flat["node"], kind="stable")
    count = len(order)
    moved = np.empty(count + 1, np.int64)
    moved[order] = np.arange(count)
    moved[count] = count  # the end
    counts = np.bincount(flat["node"], minlength=len(limit))
    follow = moved[np.where(flat["follow"] < 0, count, flat["follow"])]
    return Paths(
        node_limit=limit,
        node_first=np.concatenate([[0], np.cumsum(counts)]),
        follow=np.append(follow[order], count),
        place=flat["place"][order].astype(np.float64),
        **{name: flat[name][order] for name in ("edge", "length", "part", "time")},
    )
