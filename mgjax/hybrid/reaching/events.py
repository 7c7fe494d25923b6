"""Each target gets its place on the walk; the walk is extended where there is none."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mgjax.core.errors import ReachError
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.config import PathConfig, ReachConfig
from mgjax.hybrid.ik.limbs import Limb, find_limb
from mgjax.hybrid.paths.curve import Curve
from mgjax.hybrid.reaching.extension import extensions, rejoin
from mgjax.hybrid.reaching.key_pose import Key, find_key
from mgjax.hybrid.reaching.placements import inside_body, places, radius_of
from mgjax.hybrid.reaching.sampled_walk import Course, make_course
from mgjax.hybrid.reaching.targets import Target

Status = Literal["reached", "out_of_reach", "too_high", "limits", "lost", "too_fast"]
_BEFORE_M = 2.5
"""A walk that would pass a target too far away leaves its path so far before it."""


@dataclass(kw_only=True, eq=False)
class Event:
    """Targets that are reached at one time.

    Attributes:
        numbers: of the targets, in the order they were given.
        targets, limbs: one limb each.
        key: a pose that reaches them, once there is one.
        status: of all of them.
        extended_m: length of the way that was added for them.
        earliest: frame before which they are not looked for.
    """

    numbers: list[int]
    targets: list[Target]
    limbs: tuple[Limb, ...]
    key: Key | None = None
    status: Status = "out_of_reach"
    extended_m: float = 0.0
    earliest: int = 0


def make_events(graph: MotionGraph, targets: tuple[Target, ...]) -> list[Event]:
    """Targets of the same time together, except those that are passed.

    Raises:
        ReachError: two targets of one limb at one time.
    """
    together: dict[object, Event] = {}
    for number, target in enumerate(targets):
        if target.bar is not None:
            continue
        when = ("passing", number) if target.when == "passing" else target.when
        limb = find_limb(graph.skeleton, target.limb)
        event = together.setdefault(when, Event(numbers=[], targets=[], limbs=()))
        if limb in event.limbs:
            raise ReachError(
                f"got two targets of the {target.limb} with when = {target.when!r}, expected one"
            )
        event.numbers.append(number)
        event.targets.append(target)
        event.limbs += (limb,)
    return list(together.values())


def arrange(
    graph: MotionGraph,
    course: Course,
    curve: Curve,
    events: list[Event],
    config: ReachConfig,
    path: PathConfig,
) -> Course:
    """Finds a place for every event; returns the walk, extended where that was needed.

    Raises:
        ReachError: a target inside the body at the time at which it is to be reached.
    """
    _refuse_inside(course, events)
    ranks = {"start": -1.0, "end": np.inf}

    def order(event: Event) -> float:
        when = event.targets[0].when
        if when == "passing":
            return float(_nearest(course, event)) / graph.frame_rate
        return ranks[when] if isinstance(when, str) else float(when)

    ahead = 0  # what is behind it is settled
    for event in sorted(events, key=order):
        settled = _settle(course, event, ahead, config)
        if not settled and config.extend:
            course = _extend(course, curve, event, ahead, config, path)
        if event.key is not None:
            last = event.key.place.frame
            if event.targets[0].when == "end":
                course = make_course(graph, course.edges, last, course.start)
            ahead = max(ahead, last)
    return course


def _refuse_inside(course: Course, events: list[Event]) -> None:
    for event in events:
        when = event.targets[0].when
        if when in ("passing", "end"):
            continue
        frame = 0 if isinstance(when, str) else round(when * course.graph.frame_rate)
        for target in event.targets:
            points = np.broadcast_to(target.places[0], (course.frames + 1, 3))
            if frame <= course.frames and inside_body(course, points)[frame]:
                place = ", ".join(f"{v:g}" for v in target.places[0])
                raise ReachError(
                    f"got a target of the {target.limb} inside the body at ({place}) when ="
                    f" {when}, expected one outside"
                )


def _nearest(course: Course, event: Event) -> int:
    places_ = np.mean([t.places[0, ::2] for t in event.targets], axis=0)
    return int(np.linalg.norm(course.planes[:, 1:] - places_, axis=1).argmin())


def _settle(course: Course, event: Event, ahead: int, config: ReachConfig) -> bool:
    """Tries the best places on a walk; keeps the first that does, or the nearest to it."""
    when = event.targets[0].when
    tried = places(course, list(event.limbs), event.targets, config)
    if when not in ("start",):
        tried = [p for p in tried if p.frame >= max(ahead, event.earliest)]
    best: Key | None = None
    for place in tried:
        key = find_key(course, event.limbs, event.targets, place, config)
        if best is None or key.error_m < best.error_m:
            best = key
        if key.error_m <= config.hold_m:
            event.key, event.status = key, "reached"
            return True
    event.key = best
    event.status = "limits" if best is not None else "out_of_reach"
    return False


def _extend(
    course: Course,
    curve: Curve,
    event: Event,
    ahead: int,
    config: ReachConfig,
    path: PathConfig,
) -> Course:
    """Walks on to an event's targets, and then along the rest of the path."""
    when, rate = event.targets[0].when, course.graph.frame_rate
    middle = np.mean([target.places[0] for target in event.targets], axis=0)
    base = float(np.median(course.positions[:, event.limbs[0].joints[0], 1]))
    radius = min(
        radius_of(limb, t.places[0, 1], base, config.drop_m)
        for limb, t in zip(event.limbs, event.targets, strict=True)
    )
    if not radius > 0:
        event.status = "too_high"
        return course
    if when == "end":
        frame = course.frames - 1
    elif when == "start":
        frame = 0
    elif isinstance(when, str):
        steps = np.linalg.norm(np.diff(course.planes[:, 1:], axis=0), axis=1)
        arc = np.concatenate([[0.0], np.cumsum(steps)])
        frame = int(np.searchsorted(arc, arc[_nearest(course, event)] - _BEFORE_M))
    else:
        frame = round(when * rate)
    frame = int(np.clip(frame, ahead, course.frames - 1)) if frame > 0 or ahead > 0 else 0
    sides = {"left_hand": 1.0, "right_hand": -1.0, "head": 0.0}
    side = sides[event.targets[0].limb] if len(event.targets) == 1 else 0.0
    before = event.key
    found = extensions(course, frame, middle, radius, side, config, path)
    event.status = "lost" if not found else event.status
    for extension in found:
        event.earliest = extension.branch
        trial = Event(numbers=event.numbers, targets=_at_end(event), limbs=event.limbs)
        if _settle(extension.course, trial, extension.branch, config):
            assert trial.key is not None
            event.key, event.status = trial.key, trial.status
            event.extended_m = extension.length_m
            if when == "end":
                return extension.course
            return rejoin(extension.course, middle, curve, trial.key.place.frame, config, path)
        if trial.key is not None and (before is None or trial.key.error_m < before.error_m):
            event.status = trial.status
    return course


def _at_end(event: Event) -> list[Target]:
    """The same targets, to be reached where the extended walk ends."""
    return [replace(target, when="end") for target in event.targets]
