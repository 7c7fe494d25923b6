"""Edits of a drawing: each gives another drawing, or says why it cannot be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import ConfigError, PathError
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.sketch import MAX_OBSTACLES, Sketch
from mgjax.hybrid.reaching.targets import Bar, Target, make_target
from mgjax.stage.apps.sketch.drawing import MOST_TARGETS, Drawing, Goal, Obstacle, Path
from mgjax.stage.apps.sketch.strokes import meets, path_of_stroke

OBSTACLE_M = 0.2
BAR_M = 1.6
BAR_RADIUS_M = 0.03
_HEIGHTS = {"right_hand": 0.68, "left_hand": 0.68, "head": 0.8, "bar": 0.83}
"""Height at which something is placed, as a share of the body's."""
KINDS = ("obstacle", *_HEIGHTS)


def draw(drawing: Drawing, stroke: Float[np.ndarray, "N 2"]) -> Drawing:
    """Another path along a stroke; one that ends where it began is closed."""
    closed, spline = meets(stroke), drawing.smooth
    points = path_of_stroke(stroke, smooth=spline, closed=closed)
    return replace_path(drawing, Path(points=points, stroke=stroke, spline=spline, closed=closed))


def replace_path(drawing: Drawing, path: Path | None) -> Drawing:
    """The drawing with another path."""
    return replace(drawing, path=path)


def reshape(drawing: Drawing, *, smooth: bool | None = None, closed: bool | None = None) -> Drawing:
    """The path smooth or with corners, open or closed; a stroke is read again."""
    smooth = drawing.smooth if smooth is None else smooth
    drawing = replace(drawing, smooth=smooth)
    path = drawing.path
    if path is None:
        return drawing
    closed = path.closed if closed is None else closed
    changed = replace(path, spline=smooth, closed=closed)
    if path.stroke is not None:
        points = path_of_stroke(path.stroke, smooth=smooth, closed=closed)
        changed = replace(changed, points=points)
    return replace_path(drawing, changed)


def with_sketch(drawing: Drawing, sketch: Sketch) -> Drawing:
    """The drawing with the path and the obstacles of a file."""
    path = Path(
        points=sketch.points,
        spline=sketch.spline,
        closed=sketch.closed,
        speed=None if np.isnan(sketch.speed).all() else sketch.speed,
        end=sketch.end,
    )
    drawing = replace(drawing, obstacles=(), smooth=sketch.spline)
    for x, z, radius in sketch.obstacles.tolist():
        drawing = _add_obstacle(drawing, x, z, radius)
    return replace_path(drawing, path)


def with_targets(drawing: Drawing, targets: Sequence[Target]) -> Drawing:
    """The drawing with the targets of a file."""
    drawing = replace(drawing, goals=())
    for target in targets:
        drawing = _add_goal(drawing, target)
    return drawing


def add(drawing: Drawing, kind: str, place: Float[np.ndarray, "3"], height: float) -> Drawing:
    """Places a thing where the floor was clicked.

    Args:
        drawing: so far.
        kind: one of :data:`KINDS`; a bar lies across the path.
        place: on the floor, m.
        height: of the body, m.
    """
    x, z = round(float(place[0]), 3), round(float(place[2]), 3)
    if kind == "obstacle":
        return _add_obstacle(drawing, x, z, OBSTACLE_M)
    y = round(_HEIGHTS[kind] * height, 3)
    if kind != "bar":
        return _add_goal(drawing, make_target(kind, place=[x, y, z], when="passing"))
    side = 0.5 * BAR_M * _across(drawing, x, z)
    ends = np.round([[x - side[0], y, z - side[1]], [x + side[0], y, z + side[1]]], 3)
    return _add_goal(drawing, _bar(ends, BAR_RADIUS_M))


def move(
    drawing: Drawing,
    id_: str,
    place: Float[np.ndarray, "3"],
    end: Float[np.ndarray, "3"] | None = None,
) -> Drawing:
    """The drawing with a thing elsewhere; of a bar both ends, or ``<id>.from`` and ``<id>.to``."""
    name, _, part = id_.partition(".")
    place = np.round(place, 3)
    if any(o.id == name for o in drawing.obstacles):
        x, z = float(place[0]), float(place[2])
        moved = [replace(o, x=x, z=z) if o.id == name else o for o in drawing.obstacles]
        return replace(drawing, obstacles=tuple(moved))
    target = _find(drawing, name).target
    if target.bar is None:
        moved_target = _at(target, place)
    else:
        ends = target.bar.ends.copy()
        if part:
            ends[0 if part == "from" else 1] = place
        else:
            ends = np.stack([place, ends[1] + place - ends[0] if end is None else np.round(end, 3)])
        moved_target = _bar(np.maximum(ends, [-math.inf, 0.0, -math.inf]), target.bar.radius)
    return _with_target(drawing, name, moved_target)


def resize(drawing: Drawing, id_: str, radius: float) -> Drawing:
    """An obstacle of another radius, m."""
    if all(o.id != id_ for o in drawing.obstacles):
        raise _unknown(id_)
    changed = [replace(o, radius=radius) if o.id == id_ else o for o in drawing.obstacles]
    return replace(drawing, obstacles=tuple(changed))


def retime(drawing: Drawing, id_: str, *, when: Any = None, hold_s: float | None = None) -> Drawing:
    """A target at another time, or held for another time."""
    target = _find(drawing, id_).target
    if target.bar is not None or len(target.seconds) > 1:
        raise ConfigError(got="a time for a bar or a track", expected="a target that stands still")
    changed = make_target(
        target.limb,
        place=target.places[0].tolist(),
        when=target.when if when is None else when,
        hold_s=target.hold_s if hold_s is None else hold_s,
    )
    return _with_target(drawing, id_, changed)


def remove(drawing: Drawing, id_: str) -> Drawing:
    """The drawing without a thing."""
    name = id_.partition(".")[0]
    obstacles = tuple(o for o in drawing.obstacles if o.id != name)
    goals = tuple(g for g in drawing.goals if g.id != name)
    if len(obstacles) + len(goals) == len(drawing.obstacles) + len(drawing.goals):
        raise _unknown(name)
    return replace(drawing, obstacles=obstacles, goals=goals)


def _add_obstacle(drawing: Drawing, x: float, z: float, radius: float) -> Drawing:
    if len(drawing.obstacles) == MAX_OBSTACLES:
        raise PathError(got=f"{MAX_OBSTACLES + 1} obstacles", expected=f"at most {MAX_OBSTACLES}")
    number = drawing.count + 1
    one = Obstacle(id=f"obstacle-{number}", x=x, z=z, radius=radius)
    return replace(drawing, obstacles=(*drawing.obstacles, one), count=number)


def _add_goal(drawing: Drawing, target: Target) -> Drawing:
    if len(drawing.goals) == MOST_TARGETS:
        raise ConfigError(got=f"{MOST_TARGETS + 1} targets", expected=f"at most {MOST_TARGETS}")
    number = drawing.count + 1
    kind = "bar" if target.bar is not None else "target"
    goal = Goal(id=f"{kind}-{number}", target=target)
    return replace(drawing, goals=(*drawing.goals, goal), count=number)


def _with_target(drawing: Drawing, id_: str, target: Target) -> Drawing:
    goals = [Goal(id=id_, target=target) if g.id == id_ else g for g in drawing.goals]
    return replace(drawing, goals=tuple(goals))


def _find(drawing: Drawing, id_: str) -> Goal:
    for goal in drawing.goals:
        if goal.id == id_:
            return goal
    raise _unknown(id_)


def _unknown(id_: str) -> ConfigError:
    return ConfigError(got=f"a thing {id_!a:.30}", expected="one that is on the stage")


def _at(target: Target, place: Float[np.ndarray, "3"]) -> Target:
    """A target that begins elsewhere; a track goes along."""
    places = target.places + (place - target.places[0])
    return replace(target, places=np.maximum(places, [-math.inf, 0.0, -math.inf]))


def _bar(ends: Float[np.ndarray, "2 3"], radius: float) -> Target:
    made = make_target("head", bar=(ends[0].tolist(), ends[1].tolist(), radius))
    assert isinstance(made.bar, Bar)
    return made


def _across(drawing: Drawing, x: float, z: float) -> Float[np.ndarray, "2"]:
    """The direction across the path where it comes nearest to a place; x without a path."""
    if drawing.path is None:
        return np.array([1.0, 0.0])
    curve = make_curve(drawing.sketch())
    arc = np.linspace(0.0, curve.length, 400)
    nearest = float(arc[np.argmin(np.linalg.norm(curve.at(arc) - [x, z], axis=1))])
    low, high = max(nearest - 0.1, 0.0), min(nearest + 0.1, curve.length)
    ahead = curve.at(np.array(high)) - curve.at(np.array(low))
    ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    return np.array([ahead[1], -ahead[0]])
