"""What is played after a path until the attack is over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.body.poses import PosedGraph
from mgjax.avoidance.checks.fast import clearance_between
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.rates import CLEAR_M
from mgjax.graph.walk import Walk, extend

MAX_CONTINUATIONS = 50
"""Edges that are tried when a walk has to go on past its end without being hit. Of 700 random
attacks one needed more; where an attack stays around, no number of them helps, and each takes most
of a millisecond, for every candidate anew."""


@dataclass(frozen=True, kw_only=True)
class Continuation:
    """A path with what is played after it, and how near the attack comes.

    Attributes:
        walk: the path and what follows it.
        clearance: signed distance of attack and body, m.
        clear_until: seconds until which it is clear where nothing clear could follow the path.
    """

    walk: Walk
    clearance: float
    clear_until: float | None


def continue_clear(
    posed: PosedGraph, attack: Attack, path: Walk, config: AvoidanceConfig
) -> Continuation:
    """Continues a path along out-edges that stay clear until the attack is over.

    Depth first, longest edge first (fewer seams); after ``MAX_CONTINUATIONS`` edges the longest
    clear continuation stands and the result says until when it is clear.
    """
    graph = posed.graph
    until = attack.end + config.settle_s
    end = float(path.starts(graph)[-1])
    first = clearance_between(posed, attack, path, 0.0, min(end, until))
    if first < CLEAR_M:
        return Continuation(walk=extend(graph, path, until), clearance=first, clear_until=None)
    stack = [(path, end, first)]
    furthest = (path, end, first)
    tried = 0
    while stack:
        walk, end, clear = stack.pop()
        if end > furthest[1]:
            furthest = (walk, end, clear)
        if end >= until:
            return Continuation(walk=walk, clearance=clear, clear_until=None)
        edges = graph.edges_from(int(graph.edge_target[walk.edges[-1]]))
        edges = edges[np.argsort(graph.edge_frames[edges], kind="stable")]
        for edge in edges:
            tried += 1
            if tried > MAX_CONTINUATIONS:
                break
            longer = Walk(edges=np.append(walk.edges, edge), scales=np.append(walk.scales, 1.0))
            stop = end + float(graph.edge_frames[edge]) / graph.frame_rate
            # The last stretch before the seam leads to the new edge, so it counts again.
            seam = end - float(walk.scales[-1]) / graph.frame_rate
            gap = clearance_between(posed, attack, longer, seam, min(stop, until))
            if gap >= CLEAR_M:
                stack.append((longer, stop, min(clear, gap)))
        if tried > MAX_CONTINUATIONS:
            break
    walk, end, clear = max([furthest, *stack], key=lambda item: item[1])
    return Continuation(walk=extend(graph, walk, until), clearance=clear, clear_until=end)
