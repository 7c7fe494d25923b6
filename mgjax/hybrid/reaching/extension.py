"""A walk that is extended towards a target out of reach."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import GraphError, PathError
from mgjax.hybrid.config import PathConfig, ReachConfig
from mgjax.hybrid.paths.curve import Curve
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import make_sketch
from mgjax.hybrid.reaching.dubins import dubins
from mgjax.hybrid.reaching.placements import AHEAD_M
from mgjax.hybrid.reaching.sampled_walk import SampledWalk

_HEADINGS = 12
"""Directions from which a target is approached."""
_TRIED = 6
"""Most ways that are walked, the shortest first."""
_STEP_M = 0.1
"""Distance of the points of an adult's way."""
_REJOIN_M = 1.5
"""So far beyond the place nearest to the target an adult's walk is back on its path."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Extension:
    """One way on towards a target.

    Attributes:
        sampled: the walk up to the target.
        branch: the frame at which it leaves the walk before.
        length_m: of the way that was searched for.
    """

    sampled: SampledWalk
    branch: int
    length_m: float


def extensions(
    sampled: SampledWalk,
    frame: int,
    target: Float[np.ndarray, "3"],
    radius: float,
    side: float,
    config: ReachConfig,
    path: PathConfig,
) -> list[Extension]:
    """Walks that leave another at a frame and lead to where a target is in reach.

    The paper moves the root to P₁ + H (T − P₁)/D and lets the search branch there. Here the graph
    search follows ways of two turns and a straight line that end with the target before the body,
    from all directions; so a target beside or behind the body is walked around to, not only one
    far ahead.

    Args:
        sampled: what is walked so far.
        frame: where to leave it, at the first node from there on.
        target: place, m.
        radius: within which it is in reach on the floor, m.
        side: +1 for the left hand, −1 for the right, 0 for the head.
        config, path: settings.
    """
    number = sampled.edge_at(frame) + 1 if frame > 0 else 0
    begin = sampled.plane_after(number)
    scale = sampled.body.scale
    ahead = min(scale * AHEAD_M, 0.7 * radius)
    lines: list[tuple[float, np.ndarray]] = []
    for heading in 2 * math.pi * np.arange(_HEADINGS) / _HEADINGS + begin[0]:
        forward = np.array([math.sin(heading), math.cos(heading)])
        left = np.array([forward[1], -forward[0]])
        stand = target[::2] - ahead * forward - 0.15 * scale * side * left
        line = dubins(begin, np.array([heading, *stand]), config.radius_m, scale * _STEP_M)
        lines.append((float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()), line))
    lines.sort(key=lambda pair: pair[0])
    walks = []
    for length, line in lines[:_TRIED]:
        edges = _walk(sampled, sampled.node_after(number), begin, line, path)
        if edges is not None:
            kept = sampled.edges[:number] + edges
            frames = int(sampled.graph.edge_frames[list(kept)].sum())
            longer = sampled.with_edges(kept, frames)
            walks.append(
                Extension(sampled=longer, branch=sampled.frame_of(number), length_m=length)
            )
    return walks


def rejoin(sampled: SampledWalk, target: Float[np.ndarray, "3"], curve: Curve, frame: int,
           config: ReachConfig, path: PathConfig) -> SampledWalk:  # fmt: skip
    """The walk that goes on from a frame along the rest of the path, as far as there is one."""
    scale = sampled.body.scale
    away = np.linalg.norm(curve.points - target[::2], axis=1)
    arc = float(curve.arc[int(np.argmin(away))]) + scale * _REJOIN_M
    if arc > curve.length - 0.5 * scale:
        return sampled
    number = sampled.edge_at(frame) + 1
    begin = sampled.plane_after(number)
    meets, after = curve.at(np.array(arc)), curve.at(np.array(arc + 0.1 * scale))
    heading = math.atan2(*(after - meets))
    line = dubins(begin, np.array([heading, *meets]), config.radius_m, scale * _STEP_M)
    rest = curve.at(np.arange(arc + scale * _STEP_M, curve.length, scale * _STEP_M))
    points = np.concatenate([line, rest])
    edges = _walk(sampled, sampled.node_after(number), begin, points, path)
    if edges is None:
        return sampled
    kept = sampled.edges[:number] + edges
    frames = int(sampled.graph.edge_frames[list(kept)].sum())
    return sampled.with_edges(kept, frames)


def _walk(
    sampled: SampledWalk, node: int, begin: np.ndarray, line: np.ndarray, path: PathConfig
) -> tuple[int, ...] | None:
    """The edges of a walk along a line, as far as it leads; None where there is none."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    line = line[np.concatenate([[True], steps > 1e-3 * sampled.body.scale])]
    if steps.sum() < 2 * sampled.body.scale * _STEP_M:
        return None
    try:
        sketch = make_sketch(line)
        quick = replace(path, method="beam", time_limit_s=0.0)
        walked = follow(
            sampled.graph, sketch, config=quick, node=node, start=begin, prepared=sampled.prepared
        )
    except (PathError, GraphError):
        return None
    # Also a walk that loses its way may have come near enough: that is tried next.
    return tuple(walked.walk.edges.tolist())
