"""A walk over a motion graph: its motion, its way on the floor, and what it plays when."""

from __future__ import annotations

import numpy as np

from mgjax.core.motion import Motion
from mgjax.graph.feet.played import play_walk
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.graph.walk import Walk
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Colour, Line, Show, Span

_LEAST_M = 0.05


def walk_show(graph: MotionGraph, walk: Walk, *, title: str = "A walk") -> Show:
    """The motion of a walk, from the origin."""
    starts = walk.starts(graph)
    count = max(int(np.floor(starts[-1] * graph.frame_rate + 1e-6)) + 1, 2)
    motion = play_walk(graph, walk, np.arange(count) / graph.frame_rate)
    blends = int((graph.edge_clip[walk.edges] == NO_CLIP).sum())
    return Show(
        title=title,
        seconds=(count - 1) / graph.frame_rate,
        bodies=[body_of(graph.skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(motion))],
        lines=[floor_path("path", motion)],
        spans=edge_spans(graph, walk, starts),
        notes=[("edges", str(len(walk.edges))), ("transitions", str(blends))],
    )


def edge_spans(
    graph: MotionGraph, walk: Walk, starts: np.ndarray, *, path_length: int = 0
) -> list[Span]:
    """What a walk plays when: clips, which follow on, as one span, and transitions.

    Args:
        graph, walk: the walk.
        starts: seconds at which each edge begins, and the last ends.
        path_length: so many edges are the path to an avoidance; the others follow it.
    """
    spans: list[Span] = []
    for number, edge in enumerate(walk.edges.tolist()):
        clip = int(graph.edge_clip[edge])
        text = "transition" if clip == NO_CLIP else _name(graph.clip_names[clip])
        colour: Colour = "sky" if clip == NO_CLIP else "blue" if number < path_length else "grey"
        start, end = float(starts[number]), float(starts[number + 1])
        if spans and (spans[-1].text, spans[-1].colour) == (text, colour):
            start = spans.pop().start
        spans.append(Span(row="walk", start=start, end=end, text=text, colour=colour))
    return spans


def _name(clip: str) -> str:
    return clip.rsplit("/", 1)[-1].rsplit(".", 1)[0]


def floor_path(name: str, motion: Motion, colour: Colour = "grey") -> Line:
    """The way of a body on the floor."""
    places = np.array(motion.root_translation, dtype=np.float32)
    places[:, 1] = 0.0
    kept = [0]
    for frame in range(1, len(places)):
        if np.linalg.norm(places[frame] - places[kept[-1]]) > _LEAST_M:
            kept.append(frame)
    if kept[-1] != len(places) - 1 or len(kept) == 1:
        kept.append(len(places) - 1)
    return Line(id=name, points=places[kept], colour=colour, width=2.0)
