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
from mgjax.hybrid.reaching.key_pose import KeyPose, find_key_pose
from mgjax.hybrid.reaching.placements import find_placements, inside_body, radius_of
from mgjax.hybrid.reaching.sampled_walk import SampledWalk
from mgjax.hybrid.reaching.targets import Target

Status = Literal["reached", "out_of_reach", "too_high", "limits", "lost", "too_fast"]
_BEFORE_M = 2.5
"""So far before a target that is passed an adult leaves the path for it."""
"""A walk that would pass a target too far away leaves its path so far before it."""


@dataclass(kw_only=True, eq=False)
class ReachEvent:
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
    key: KeyPose | None = None
    status: Status = "out_of_reach"
    extended_m: float = 0.0
    earliest: int = 0


def make_events(graph: MotionGraph, targets: tuple[Target, ...]) -> list[ReachEvent]:
    """Targets of the same time together, except those that are passed.

    Raises:
        ReachError: two targets of one limb at one time.
    """
    together: dict[object, ReachEvent] = {}
    for number, target in enumerate(targets):
        if target.bar is not None:
            continue
        when = ("passing", number) if target.when == "passing" else target.when
        limb = find_limb(graph.skeleton, target.limb)
        event = together.setdefault(when, ReachEvent(numbers=[], targets=[], limbs=()))
        if limb in event.limbs:
            raise ReachError(
                f"got two targets of the {target.limb} with when = {target.when!r}, expected one"
            )
        event.numbers.append(number)
        event.targets.append(target)
        event.limbs += (limb,)
    return list(together.values())


def place_events(
    sampled: SampledWalk,
    curve: Curve,
    events: list[ReachEvent],
    config: ReachConfig,
    path: PathConfig,
) -> SampledWalk:
    """Finds a place for every event; returns the walk, extended where that was needed.

    Raises:
        ReachError: a target inside the body at the time at which it is to be reached.
    """
    _refuse_inside(sampled, events)
    ranks = {"start": -1.0, "end": np.inf}

    def order(event: ReachEvent) -> float:
        when = event.targets[0].when
        if when == "passing":
            return float(_nearest(sampled, event)) / sampled.graph.frame_rate
        return ranks[when] if isinstance(when, str) else float(when)

    ahead = 0  # what is behind it is settled
    for event in sorted(events, key=order):
        settled = _try_placements(sampled, event, ahead, config)
        if not settled and config.extend:
            sampled = _extend(sampled, curve, event, ahead, config, path)
        if event.key is not None:
            last = event.key.place.frame
            if event.targets[0].when == "end":
                sampled = sampled.with_edges(sampled.edges, last)
            ahead = max(ahead, last)
    return sampled


def _refuse_inside(sampled: SampledWalk, events: list[ReachEvent]) -> None:
    for event in events:
        when = event.targets[0].when
        if when in ("passing", "end"):
            continue
        frame = 0 if isinstance(when, str) else round(when * sampled.graph.frame_rate)
        for target in event.targets:
            points = np.broadcast_to(target.places[0], (sampled.frames + 1, 3))
            if frame <= sampled.frames and inside_body(sampled, points)[frame]:
                place = ", ".join(f"{v:g}" for v in target.places[0])
                raise ReachError(
                    f"got a target of the {target.limb} inside the body at ({place}) when ="
                    f" {when}, expected one outside"
                )


def _nearest(sampled: SampledWalk, event: ReachEvent) -> int:
    places_ = np.mean([t.places[0, ::2] for t in event.targets], axis=0)
    return int(np.linalg.norm(sampled.planes[:, 1:] - places_, axis=1).argmin())


def _try_placements(
    sampled: SampledWalk, event: ReachEvent, ahead: int, config: ReachConfig
) -> bool:
    """Tries the best places on a walk; keeps the first that does, or the nearest to it."""
    when = event.targets[0].when
    tried = find_placements(sampled, list(event.limbs), event.targets, config)
    if when not in ("start",):
        tried = [p for p in tried if p.frame >= max(ahead, event.earliest)]
    best: KeyPose | None = None
    for place in tried:
        key = find_key_pose(sampled, event.limbs, event.targets, place, config)
        if best is None or key.error_m < best.error_m:
            best = key
        if key.error_m <= config.hold_m:
            event.key, event.status = key, "reached"
            return True
    event.key = best
    event.status = "limits" if best is not None else "out_of_reach"
    return False


def _extend(
    sampled: SampledWalk,
    curve: Curve,
    event: ReachEvent,
    ahead: int,
    config: ReachConfig,
    path: PathConfig,
) -> SampledWalk:
    """Walks on to an event's targets, and then along the rest of the path."""
    when, rate = event.targets[0].when, sampled.graph.frame_rate
    middle = np.mean([target.places[0] for target in event.targets], axis=0)
    base = float(np.median(sampled.positions[:, event.limbs[0].joints[0], 1]))
    radius = min(
        radius_of(limb, t.places[0, 1], base, config.drop_m)
        for limb, t in zip(event.limbs, event.targets, strict=True)
    )
    if not radius > 0:
        event.status = "too_high"
        return sampled
    if when == "end":
        frame = sampled.frames - 1
    elif when == "start":
        frame = 0
    elif isinstance(when, str):
        steps = np.linalg.norm(np.diff(sampled.planes[:, 1:], axis=0), axis=1)
        arc = np.concatenate([[0.0], np.cumsum(steps)])
        frame = int(
            np.searchsorted(arc, arc[_nearest(sampled, event)] - sampled.body.scale * _BEFORE_M)
        )
    else:
        frame = round(when * rate)
    frame = int(np.clip(frame, ahead, sampled.frames - 1)) if frame > 0 or ahead > 0 else 0
    side = event.limbs[0].type.sign if len(event.limbs) == 1 else 0.0
    before = event.key
    longer = extensions(sampled, frame, middle, radius, side, config, path)
    event.status = "lost" if not longer else event.status
    for extension in longer:
        event.earliest = extension.branch
        trial = ReachEvent(numbers=event.numbers, targets=_at_end(event), limbs=event.limbs)
        if _try_placements(extension.sampled, trial, extension.branch, config):
            assert trial.key is not None
            event.key, event.status = trial.key, trial.status
            event.extended_m = extension.length_m
            if when == "end":
                return extension.sampled
            return rejoin(extension.sampled, middle, curve, trial.key.place.frame, config, path)
        if trial.key is not None and (before is None or trial.key.error_m < before.error_m):
            event.status = trial.status
    return sampled


def _at_end(event: ReachEvent) -> list[Target]:
    """An event's targets, to be reached where the extended walk ends."""
    return [replace(target, when="end") for target in event.targets]
