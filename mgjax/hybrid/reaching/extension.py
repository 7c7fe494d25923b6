"""A walk that is extended towards a target out of reach."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import GraphError, PathError
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.config import PathConfig, ReachConfig
from mgjax.hybrid.paths.curve import Curve
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import make_sketch
from mgjax.hybrid.reaching.dubins import dubins
from mgjax.hybrid.reaching.placements import AHEAD_M
from mgjax.hybrid.reaching.sampled_walk import Course, make_course

_HEADINGS = 12
"""Directions from which a target is approached."""
_TRIED = 6
"""Most ways that are walked, the shortest first."""
_STEP_M = 0.1
"""Distance of a way's points."""
_REJOIN_M = 1.5
"""So far beyond the place nearest to the target the walk is back on its path."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Extension:
    """One way on towards a target.

    Attributes:
        course: the walk up to the target.
        branch: the frame at which it leaves the walk before.
        length_m: of the way that was searched for.
    """

    course: Course
    branch: int
    length_m: float


def extensions(
    course: Course,
    frame: int,
    target: Float[np.ndarray, "3"],
    radius: float,
    side: float,
    config: ReachConfig,
    path: PathConfig,
) -> list[Extension]:
    """Walks that leave a course at a frame and lead to where a target is in reach.

    The paper moves the root to P₁ + H (T − P₁)/D and lets the search branch there. Here the graph
    search follows ways of two turns and a straight line that end with the target before the body,
    from all directions; so a target beside or behind the body is walked around to, not only one
    far ahead.

    Args:
        course: what is walked so far.
        frame: where to leave it, at the first node from there on.
        target: place, m.
        radius: within which it is in reach on the floor, m.
        side: +1 for the left hand, −1 for the right, 0 for the head.
        config, path: settings.
    """
    number = course.edge_at(frame) + 1 if frame > 0 else 0
    begin = course.plane_after(number)
    ahead = min(AHEAD_M, 0.7 * radius)
    ways: list[tuple[float, np.ndarray]] = []
    for heading in 2 * math.pi * np.arange(_HEADINGS) / _HEADINGS + begin[0]:
        forward = np.array([math.sin(heading), math.cos(heading)])
        left = np.array([forward[1], -forward[0]])
        stand = target[::2] - ahead * forward - 0.15 * side * left
        line = dubins(begin, np.array([heading, *stand]), config.radius_m, _STEP_M)
        ways.append((float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()), line))
    ways.sort(key=lambda way: way[0])
    found = []
    for length, line in ways[:_TRIED]:
        edges = _walk(course.graph, course.node_after(number), begin, line, path)
        if edges is not None:
            kept = course.edges[:number] + edges
            frames = int(course.graph.edge_frames[list(kept)].sum())
            longer = make_course(course.graph, kept, frames, course.start)
            found.append(Extension(course=longer, branch=course.frame_of(number), length_m=length))
    return found


def rejoin(course: Course, target: Float[np.ndarray, "3"], curve: Curve, frame: int,
           config: ReachConfig, path: PathConfig) -> Course:  # fmt: skip
    """A course that goes on from a frame along the rest of the path, as far as there is one."""
    away = np.linalg.norm(curve.points - target[::2], axis=1)
    arc = float(curve.arc[int(np.argmin(away))]) + _REJOIN_M
    if arc > curve.length - 0.5:
        return course
    number = course.edge_at(frame) + 1
    begin = course.plane_after(number)
    there, after = curve.at(np.array(arc)), curve.at(np.array(arc + 0.1))
    heading = math.atan2(*(after - there))
    line = dubins(begin, np.array([heading, *there]), config.radius_m, _STEP_M)
    rest = curve.at(np.arange(arc + _STEP_M, curve.length, _STEP_M))
    points = np.concatenate([line, rest])
    edges = _walk(course.graph, course.node_after(number), begin, points, path)
    if edges is None:
        return course
    kept = course.edges[:number] + edges
    frames = int(course.graph.edge_frames[list(kept)].sum())
    return make_course(course.graph, kept, frames, course.start)


def _walk(
    graph: MotionGraph, node: int, begin: np.ndarray, line: np.ndarray, path: PathConfig
) -> tuple[int, ...] | None:
    """The edges of a walk along a line, as far as it leads; None where there is none."""
    apart = np.linalg.norm(np.diff(line, axis=0), axis=1)
    line = line[np.concatenate([[True], apart > 1e-3])]
    if apart.sum() < 2 * _STEP_M:
        return None
    try:
        sketch = make_sketch(line)
        quick = replace(path, method="beam", time_limit_s=0.0)
        walked = follow(graph, sketch, config=quick, node=node, start=begin)
    except (PathError, GraphError):
        return None
    # Also a walk that loses its way may have come near enough: that is tried next.
    return tuple(walked.walk.edges.tolist())
