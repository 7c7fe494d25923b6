"""A solution as the page draws it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.core.skeleton import Skeleton
from mgjax.hybrid.paths.result import PathResult
from mgjax.stage.apps.sketch.drawing import Drawing, Goal
from mgjax.stage.apps.sketch.solve import Solution
from mgjax.stage.apps.sketch.words import DONE, figures, sentence, target_words, way_added
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Colour, Line, Show, Span, Thing

WALKER = "walker"
GOAL_M = 0.055
_OBSTACLE_HIGH_M = 0.8
_POINTS_M = 0.05
_READABLE_S = 0.6
"""Shorter spans have no room for a word."""
_COLOURS: dict[str, Colour] = {
    "right_hand": "orange", "left_hand": "purple", "head": "green", "bar": "green",
}  # fmt: skip


def actors_of(solution: Solution) -> list[Actor]:
    """Who walks; nobody without a path."""
    motion = solution.motion
    if motion is None:
        return []
    return [Actor(id=WALKER, body=0, frames=frames_of(motion), colour="blue")]


def lines_of(solution: Solution) -> list[Line]:
    """The path that is drawn, and beside it the track of the root."""
    curve = solution.curve
    if curve is None:
        path = solution.drawing.path
        if path is None:
            return []
        return [Line(id="path", points=_floor(path.points), colour="red", width=4, dashed=True)]
    arc = np.linspace(0.0, curve.length, max(2, 1 + int(curve.length / _POINTS_M)))
    lines = [Line(id="path", points=_floor(curve.at(arc)), colour="grey", width=7)]
    if solution.route is not None:
        track = solution.route.track.places
        lines.append(Line(id="track", points=_floor(track), colour="blue", width=3))
    return lines


def things_of(solution: Solution) -> list[Thing]:
    """What stands on the floor, and marks of where it goes wrong."""
    names = solution.drawing.names()
    things = [
        Thing(
            id=o.id, shape="cylinder", place=(o.x, 0.0, o.z), end=(o.x, _OBSTACLE_HIGH_M, o.z),
            radius=max(o.radius, 0.02), colour="grey", drag="floor", note=names[o.id],
        )
        for o in solution.drawing.obstacles
    ]  # fmt: skip
    for number, goal in enumerate(solution.drawing.goals):
        things += _goal_things(solution, goal, number, names[goal.id])
    return things + _marks(solution)


def _goal_things(solution: Solution, goal: Goal, number: int, name: str) -> list[Thing]:
    colour = _COLOURS[goal.kind]
    if solution.reached is not None and solution.reached.targets[number].status not in DONE:
        colour, name = "red", f"{name}: not reached"
    bar = goal.target.bar
    if bar is None:
        place = tuple(goal.target.places[0].tolist())
        one = Thing(id=goal.id, shape="sphere", place=place, radius=GOAL_M, colour=colour,
                    drag="space", note=name)  # fmt: skip
        return [one]
    start, end = (tuple(p) for p in bar.ends.tolist())
    whole = Thing(id=goal.id, shape="capsule", place=start, end=end, radius=max(bar.radius, 0.015),
                  colour=colour, drag="space", note=name.replace("not reached", "hit"))  # fmt: skip
    ends = [
        Thing(id=f"{goal.id}.{part}", shape="sphere", place=place, radius=GOAL_M, colour=colour,
              drag="space")
        for part, place in (("from", start), ("to", end))
    ]  # fmt: skip
    return [whole, *ends]


def _marks(solution: Solution) -> list[Thing]:
    """Rings on the floor: where the walk is farthest off, or where it ends too early."""
    route = solution.route
    if route is None:
        return []
    if route.failed_at is not None:
        x, z = route.failed_at.tolist()
        text = "no further" if route.status == "lost" else "so far in the time given"
        return [Thing(id="failed", shape="ring", place=(x, 0.0, z), radius=0.18, colour="red",
                      note=text)]  # fmt: skip
    if way_added(solution):
        return []
    worst, off = worst_of(route)
    x, z = route.track.places[worst].tolist()
    text = f"{100 * off:.0f} cm off"
    return [Thing(id="worst", shape="ring", place=(x, 0.0, z), radius=max(off, 0.1),
                  colour="orange", note=text)]  # fmt: skip


def worst_of(route: PathResult) -> tuple[int, float]:
    """The frame in which the root is farthest from the path, and how far that is, m."""
    worst = int(np.argmax(route.distance))
    return worst, float(route.distance[worst])


def spans_of(solution: Solution) -> list[Span]:
    """When targets are held and bars passed, in seconds of what is played."""
    if solution.reached is None:
        return []
    rate = solution.reached.motion.frame_rate
    names = list(solution.drawing.names().values())[len(solution.drawing.obstacles) :]
    spans = []
    for goal, row, name in zip(
        solution.drawing.goals, solution.reached.targets, names, strict=True
    ):
        if row.first is not None and row.last is not None:
            text = "ducks" if row.target.bar is not None else "holds"
            text = text if row.last - row.first > _READABLE_S * rate else ""
            spans.append(Span(row=name, start=row.first / rate, end=row.last / rate, text=text,
                              colour=_COLOURS[goal.kind]))  # fmt: skip
    return spans


def moments_of(solution: Solution) -> list[tuple[str, float]]:
    """When the root is farthest from the path."""
    route, motion = solution.route, solution.motion
    if route is None or motion is None or route.failed_at is not None or way_added(solution):
        return []
    place = route.track.places[worst_of(route)[0]]
    roots = np.asarray(motion.root_translation, np.float64)[:, ::2]
    frame = int(np.argmin(np.linalg.norm(roots - place, axis=1)))
    return [("farthest", frame / motion.frame_rate)]


def show_of(solution: Solution, skeleton: Skeleton) -> Show:
    """All of it, to be played elsewhere: nothing there can be moved."""
    motion = solution.motion
    assert motion is not None
    names = solution.drawing.names()
    reached = [
        (names[goal.id], target_words(solution, number))
        for number, goal in enumerate(solution.drawing.goals)
    ]
    return Show(
        title="Sketch",
        seconds=(motion.num_frames - 1) / motion.frame_rate,
        words=sentence(solution)[0],
        bodies=[body_of(skeleton)],
        actors=actors_of(solution),
        lines=lines_of(solution),
        things=[replace(thing, drag=None) for thing in things_of(solution)],
        spans=spans_of(solution),
        notes=[*figures(solution), *reached],
        moments=moments_of(solution),
    )


def items_of(drawing: Drawing, words: Sequence[str]) -> list[dict[str, object]]:
    """Things as the panel edits them."""
    names = drawing.names()
    items: list[dict[str, object]] = [
        {"id": o.id, "kind": "obstacle", "name": names[o.id], "radius": o.radius}
        for o in drawing.obstacles
    ]
    for goal, text in zip(drawing.goals, words, strict=True):
        target = goal.target
        still = target.bar is None and len(target.seconds) == 1
        items.append(
            {
                "id": goal.id,
                "kind": goal.kind,
                "name": names[goal.id],
                "when": target.when if still else None,
                "hold": target.hold_s if still else None,
                "words": text,
            }
        )
    return items


def _floor(places: Float[np.ndarray, "N 2"]) -> Float[np.ndarray, "N 3"]:
    flat = np.zeros((len(places), 3))
    flat[:, ::2] = places
    return flat
