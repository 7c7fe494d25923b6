"""Path synthesis by plain loops: every walk over the edges of a graph, one frame after another."""

from __future__ import annotations

import math

import numpy as np

CREEP_M_S = 0.2


def place_at(points: np.ndarray, s: float) -> np.ndarray:
    """P(s) of a polyline [M, 2]."""
    for a, b in zip(points[:-1], points[1:], strict=True):
        length = math.dist(a, b)
        if s <= length:
            return a + (b - a) * (s / length)
        s -= length
    return points[-1]


def turned(angle: float, x: float, z: float) -> tuple[float, float]:
    return x * math.cos(angle) + z * math.sin(angle), z * math.cos(angle) - x * math.sin(angle)


def edge_track(graph, edge: int, heading: float, x: float, z: float):
    """Root places over one edge of a body that stands at (heading, x, z) at its source, and where
    the body then stands."""
    angle, px, pz = (float(v) for v in graph.node_plane[graph.edge_source[edge]])
    turn = heading - angle
    ox, oz = turned(turn, px, pz)
    ox, oz = x - ox, z - oz
    places = []
    for frame in range(graph.edge_starts[edge] + 1, graph.edge_stops[edge] + 1):
        rx, _, rz = (float(v) for v in graph.root_translation[frame])
        tx, tz = turned(turn, rx, rz)
        places.append((tx + ox, tz + oz))
    exit_angle, ex, ez = (float(v) for v in graph.edge_exit[edge])
    angle, px, pz = (float(v) for v in graph.node_plane[graph.edge_target[edge]])
    qx, qz = turned(exit_angle, px, pz)
    tx, tz = turned(turn, qx + ex, qz + ez)
    return places, (turn + exit_angle + angle, tx + ox, tz + oz)


def walk_cost(graph, edges, points, start, frames: int, blend_weight: float, near: float):
    """Cost (eqs 6-7), frames that count, and whether the walk is complete; the cost is infinite if
    it strays. At most ``frames`` frames count."""
    length = sum(math.dist(a, b) for a, b in zip(points[:-1], points[1:], strict=True))
    body, s, cost, count = tuple(start), 0.0, 0.0, 0
    last = (start[1], start[2])
    for edge in edges:
        places, body = edge_track(graph, edge, *body)
        for place in places:
            if count == frames:
                return cost, count, False
            s += max(math.dist(place, last), CREEP_M_S / graph.frame_rate)
            last = place
            count += 1
            off = math.dist(place, place_at(points, s))
            if off > near:
                return math.inf, count, False
            cost += off**2 + blend_weight * float(graph.edge_distance[edge]) ** 2
            if s >= length:
                return cost, count, True
    return cost, count, False


def exhaustive(graph, node: int, points, start, frames: int, blend_weight: float, near: float):
    """The least cost of all walks from a node that last ``frames`` frames or are complete."""
    best, chosen = math.inf, None
    stack = [(node, ())]
    while stack:
        here, edges = stack.pop()
        if edges:
            cost, count, complete = walk_cost(
                graph, edges, points, start, frames, blend_weight, near
            )
            if cost == math.inf:
                continue
            if complete or count == frames:
                if cost < best:
                    best, chosen = cost, edges
                continue
        for edge in graph.edges_from(here):
            stack.append((int(graph.edge_target[edge]), (*edges, int(edge))))
    return best, chosen
