"""A walk along a sketched path, and what hands and head reach on it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mgjax.graph.types import MotionGraph
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.result import PathResult
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.hybrid.reaching.result import Reached, ReachResult
from mgjax.hybrid.reaching.targets import Target
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Colour, Line, Show, Span, Thing
from mgjax.stage.show.walk import edge_spans, floor_path

POST_M = 1.0
"""How high obstacles, which are circles on the floor, are drawn."""
_TARGET_M = 0.05
_DONE = ("reached", "cleared")


def path_show(
    graph: MotionGraph, sketch: Sketch, walked: PathResult, *, title: str = "A walk along a path"
) -> Show:
    """The walk, its track beside the path, obstacles, and how far it is off."""
    starts = np.minimum(walked.walk.starts(graph), walked.seconds)
    return Show(
        title=title,
        words=path_words(walked),
        seconds=walked.seconds,
        bodies=[body_of(graph.skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(walked.motion))],
        lines=[*sketch_lines(sketch), _track(walked)],
        things=sketch_things(sketch, walked),
        spans=edge_spans(graph, walked.walk, starts),
        notes=path_notes(walked, make_curve(sketch).length),
    )


def reach_show(
    graph: MotionGraph, sketch: Sketch, reached: ReachResult, *, title: str = "Reaching on the way"
) -> Show:
    """The walk with its reaches, targets in the world, and what came of each."""
    rate, motion = reached.motion.frame_rate, reached.motion
    spans = [
        Span(
            row="reaches",
            start=(row.first or 0) / rate,
            end=(row.last or 0) / rate,
            text=f"{_limb(row.target)}: {_status(row)}",
            colour=_colour(row),
        )
        for row in reached.targets
        if row.first is not None
    ]
    notes = [(_limb(row.target), reached_words(row)) for row in reached.targets]
    walked = reached.walked
    return Show(
        title=title,
        words=reach_words(reached.targets),
        seconds=(motion.num_frames - 1) / rate,
        bodies=[body_of(graph.skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(motion))],
        lines=[
            *sketch_lines(sketch),
            floor_path("track", motion, "blue"),
            *target_lines([row.target for row in reached.targets]),
        ],
        things=[
            *sketch_things(sketch, walked),
            *target_things(
                [row.target for row in reached.targets], [_colour(r) for r in reached.targets]
            ),
        ],
        spans=spans,
        notes=[*notes, *path_notes(walked, make_curve(sketch).length)],
    )


def path_words(walked: PathResult) -> str:
    """What came of a path, in one sentence."""
    off = f"{100 * walked.mean_distance:.1f} cm off on average"
    if walked.failed_at is None:
        return f"followed, {off}, {100 * walked.largest_distance:.0f} cm at most"
    x, z = walked.failed_at
    why = "lost" if walked.status == "lost" else "the time limit came first"
    return f"{why}: it leads to ({x:.2f}, {z:.2f}), after {walked.failed_s or 0.0:.2f} m; {off}"


def path_notes(walked: PathResult, length: float) -> list[tuple[str, str]]:
    """Figures of a walk along a path."""
    notes = [
        ("path", f"{length:.2f} m"),
        ("motion", f"{walked.seconds:.2f} s"),
        ("mean distance", f"{100 * walked.mean_distance:.1f} cm"),
        ("largest distance", f"{100 * walked.largest_distance:.1f} cm"),
        ("search", f"{1000 * walked.search_s:.0f} ms"),
        ("walks extended", str(walked.expanded)),
        ("feet slide", f"{1000 * walked.slide:.1f} mm a frame"),
    ]
    if not math.isnan(walked.end_off[0]):
        notes.append(("end off", f"{100 * walked.end_off[0]:.1f} cm"))
    return notes


def reach_words(rows: Sequence[Reached]) -> str:
    """How many targets were reached, and what became of the others."""
    done = sum(row.status in _DONE for row in rows)
    missed = [f"{_limb(row.target)} {_status(row)}" for row in rows if row.status not in _DONE]
    text = f"{done} of {len(rows)} reached"
    return f"{text}; {', '.join(missed)}" if missed else text


def reached_words(row: Reached) -> str:
    """What came of one target."""
    text = _status(row)
    if math.isfinite(row.error_m):
        text += f", {1000 * row.error_m:.1f} mm off"
    if math.isfinite(row.clear_m):
        text += f", {100 * row.clear_m:.0f} cm clear"
    return text


def sketch_lines(sketch: Sketch) -> list[Line]:
    """The path on the floor."""
    points = make_curve(sketch).points
    step = max(len(points) // 400, 1)
    kept = np.unique(np.append(np.arange(0, len(points), step), len(points) - 1))
    floor = np.stack([points[kept, 0], np.zeros(len(kept)), points[kept, 1]], axis=-1)
    return [Line(id="sketch", points=floor, colour="orange", width=5.0)]


def sketch_things(sketch: Sketch, walked: PathResult | None = None) -> list[Thing]:
    """Obstacles, the wanted end, and where the walk was lost."""
    things = [
        Thing(
            id=f"obstacle{i}", shape="cylinder", place=[float(x), 0.0, float(z)],
            end=[float(x), POST_M, float(z)], radius=float(radius), colour="grey",
        )
        for i, (x, z, radius) in enumerate(sketch.obstacles)
    ]  # fmt: skip
    if sketch.end is not None:
        place = [float(sketch.end[0]), 0.0, float(sketch.end[1])]
        things.append(Thing(id="end", shape="ring", place=place, radius=0.25, colour="green"))
    if walked is not None and walked.failed_at is not None:
        x, z = (float(v) for v in walked.failed_at)
        things.append(
            Thing(
                id="failed", shape="ring", place=[x, 0.0, z], radius=0.3, colour="red",
                note="not beyond here",
            )
        )  # fmt: skip
    return things


def target_things(targets: Sequence[Target], colours: Sequence[Colour]) -> list[Thing]:
    """Targets as balls, at their first place, and bars."""
    things: list[Thing] = []
    for number, (target, colour) in enumerate(zip(targets, colours, strict=True)):
        if target.bar is not None:
            a, b = (end.tolist() for end in np.asarray(target.bar.ends, float))
            things.append(
                Thing(
                    id=f"target{number}", shape="capsule", place=a, end=b,
                    radius=float(target.bar.radius), colour=colour, note="bar",
                )
            )  # fmt: skip
        else:
            things.append(
                Thing(
                    id=f"target{number}", shape="sphere", place=target.places[0].tolist(),
                    radius=_TARGET_M, colour=colour, note=_limb(target),
                )
            )  # fmt: skip
    return things


def target_lines(targets: Sequence[Target]) -> list[Line]:
    """The ways of targets that move."""
    return [
        Line(
            id=f"way{number}", dashed=True, colour="purple",
            points=target.at(np.linspace(target.seconds[0], target.seconds[-1], 32)),
        )
        for number, target in enumerate(targets)
        if len(target.seconds) > 1
    ]  # fmt: skip


def _track(walked: PathResult) -> Line:
    return floor_path("track", walked.motion, "blue")


def _limb(target: Target) -> str:
    return "bar" if target.bar is not None else target.limb.replace("_", " ")


def _status(row: Reached) -> str:
    return row.status.replace("_", " ")


def _colour(row: Reached) -> Colour:
    return "green" if row.status in _DONE else "red"
