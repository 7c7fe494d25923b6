"""Paths and graphs for the experiments on walking."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from mgjax.clips.folder import load_clips
from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.files import load_graph
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.paths.sketch import Sketch, make_sketch

EMBEDDED = ("walk", "walk_curve", "steps", "turns")
EMBEDDED_M = 0.05
"""Threshold for the embedded clips."""


def sketches(scale: float = 1.0) -> dict[str, Sketch]:
    """A line of 10 m, a circle of 3 m radius, a square of 4 m, an S-curve and a figure eight."""
    angle = np.linspace(0, 2 * np.pi, 65)[:-1]
    eight = np.stack([2.5 * np.sin(2 * angle), 4 * np.sin(angle)], axis=-1)
    circle = np.stack([3 - 3 * np.cos(angle), 3 * np.sin(angle)], axis=-1)
    bend = np.array([[0, 0], [1.5, 2.5], [0, 5], [-1.5, 7.5], [0, 10]])
    square = np.array([[0, 0], [0, 4], [4, 4], [4, 0]])
    return {
        "line": make_sketch(scale * np.array([[0, 0], [0, 10]])),
        "circle": make_sketch(scale * circle, closed=True, spline=True),
        "square": make_sketch(scale * square, closed=True),
        "s_curve": make_sketch(scale * bend, spline=True),
        "eight": make_sketch(scale * eight, closed=True, spline=True),
    }


@lru_cache(maxsize=4)
def clips_of(folder: str, names: tuple[str, ...] = ()) -> list[Clip]:
    """The clips below a folder, or those whose file is named so; "" means the embedded ones."""
    if not folder:
        return [clip for clip in synthetic_clips()[0] if clip.name in (names or EMBEDDED)]
    clips, _ = load_clips(folder)
    return [clip for clip in clips if not names or clip.name.split("/")[-1].split(".")[0] in names]


def graph_config(folder: str, neighbourhood: int, **more: object) -> GraphConfig:
    """Settings of the graph; the embedded clips have a threshold of their own."""
    given = {} if folder else {"threshold_m": EMBEDDED_M}
    return GraphConfig(neighbourhood=neighbourhood, **(given | more))  # pyright: ignore


def graph_of(graph: str, folder: str, neighbourhood: int, names: Sequence[str] = ()) -> MotionGraph:
    """A graph from its folder, or that of clips."""
    if graph:
        return load_graph(graph)
    return build_graph(clips_of(folder, tuple(names)), config=graph_config(folder, neighbourhood))
