"""Walk a sketched path and reach on the way (Kalouache & Cherif, section III.A.2)."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.core.motion import Motion, sample
from mgjax.graph.plants import foot_slide
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk
from mgjax.hybrid.config import PathConfig, ReachConfig
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.result import PathResult, track_of
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.hybrid.reaching.blend import (
    Span,
    blend_group,
    fast_frames,
    fastest_turn,
    groups,
    turn_speeds,
)
from mgjax.hybrid.reaching.duck import Duck, duck
from mgjax.hybrid.reaching.events import Event, arrange, make_events
from mgjax.hybrid.reaching.result import ReachResult, bar_row, target_row
from mgjax.hybrid.reaching.sampled_walk import Course, make_course
from mgjax.hybrid.reaching.stops import Playback, Stop, play
from mgjax.hybrid.reaching.targets import Target

_LONGER = 1.4
"""A blend in which a joint turns too fast is made so much longer, again and again."""
_TIMES = 5


def reach(
    graph: MotionGraph,
    sketch: Sketch,
    targets: tuple[Target, ...],
    *,
    config: ReachConfig | None = None,
    path: PathConfig | None = None,
    node: int | None = None,
    start: Float[np.ndarray, "3"] | None = None,
) -> ReachResult:
    """The walk along a sketched path whose hands and head are where targets want them.

    The walk is found first; each target then gets the time at which the body stands best to it
    and a key pose reaches it. Where there is none the graph search extends the walk towards the
    target and then back to the path. Arms are solved in each frame from the frame before, starting
    from the key pose, and blended in and out, while the legs keep the walk.

    Args:
        graph, sketch, path, node, start: as for :func:`mgjax.hybrid.follow`.
        targets: in any order.
        config: settings.

    Raises:
        ReachError: a target inside the body, two for one limb at one time.
        PathError, GraphError, ConfigError: as :func:`mgjax.hybrid.follow`.
    """
    config, path = config or ReachConfig(), path or PathConfig()
    events = make_events(graph, targets)
    walked = follow(graph, sketch, config=path, node=node, start=start)
    begun = time.perf_counter()
    first = make_course(graph, tuple(walked.walk.edges.tolist()), walked.frames, walked.start)
    course = arrange(graph, first, make_curve(sketch), events, config, path)
    if course is not first:
        walked = _extended(graph, walked, course, sketch)
    kept = [event for event in events if event.status == "reached"]
    motion, plain, played, spans, ducks = _move(graph, course, kept, targets, config)
    _mark_fast(motion, plain, kept, spans, config)
    rows = [
        bar_row(graph, motion, target, ducks[number], config.drop_m)
        if target.bar is not None
        else target_row(graph, motion, target, number, events, spans)
        for number, target in enumerate(targets)
    ]
    plants = course.plants[np.round(played.frames).astype(int)]
    return ReachResult(
        walked=walked,
        motion=motion,
        plain=plain,
        targets=tuple(rows),
        fastest_deg_s=fastest_turn(motion, plain),
        fastest_plain_deg_s=float(turn_speeds(plain).max()),
        slide=foot_slide(graph.skeleton, motion, plants)[0],
        solve_s=time.perf_counter() - begun,
    )


def _extended(graph: MotionGraph, walked: PathResult, course: Course, sketch: Sketch) -> PathResult:
    """The result of the path search for a walk that goes on elsewhere."""
    chosen = np.array(course.edges)
    blend = np.repeat(
        graph.edge_distance[chosen].astype(np.float64) ** 2, graph.edge_frames[chosen]
    )
    track = track_of(graph, course.motion, blend[: course.frames])
    curve = make_curve(sketch)
    slide, share = foot_slide(graph.skeleton, course.motion, course.plants)
    return replace(
        walked,
        walk=make_walk(graph, chosen),
        frames=course.frames,
        seconds=course.frames / graph.frame_rate,
        motion=course.motion,
        track=track,
        error=float(track.squares(curve).sum()),
        distance=curve.nearest(track.places, track.arc)[0],
        slide=slide,
        slide_share=share,
    )


def _schedule(course: Course, events: list[Event], blend: int) -> tuple[Playback, dict[int, Span]]:
    """The walk with its stops, and the frames in which targets are held, by event."""
    rate = course.graph.frame_rate
    ordered = sorted(events, key=lambda e: e.key.place.frame if e.key else 0)
    stops: list[Stop] = []
    leads: list[int] = []
    for event in ordered:
        assert event.key is not None
        place = event.key.place
        if place.stop:
            hold = _hold(event, rate)
            before = blend if place.frame == 0 else blend // 2
            after = blend if place.frame == course.frames else blend // 2
            stops.append(Stop(frame=place.frame, frames=before + hold + after))
            leads.append(before)
    played = play(course.frames, rate, stops)
    spans: dict[int, Span] = {}
    number = 0
    for event in ordered:
        assert event.key is not None
        hold = _hold(event, rate)
        if event.key.place.stop:
            first = played.stands[number][0] + leads[number]
            number += 1
        else:
            first = played.shown(event.key.place.frame)
        spans[id(event)] = Span(
            first=first,
            last=min(first + hold, len(played.frames) - 1),
            targets=tuple(event.targets),
            key=event.key,
            key_frame=min(first + hold // 2, len(played.frames) - 1),
        )
    return played, spans


def _hold(event: Event, rate: float) -> int:
    return round(max(target.hold_s for target in event.targets) * rate)


def _mark_fast(
    motion: Motion, plain: Motion, events: list[Event], spans: dict[int, Span], config: ReachConfig
) -> None:
    """Events around which a joint turns too fast, in spite of all, are not reached as asked."""
    fast = np.flatnonzero(fast_frames(motion, plain) > config.turn_deg_s)
    for event in events if fast.size else []:
        near = [min(abs(fast - s.first).min(), abs(fast - s.last).min()) for s in spans.values()]
        span = spans[id(event)]
        if min(abs(fast - span.first).min(), abs(fast - span.last).min()) == min(near):
            event.status = "too_fast"


def _move(
    graph: MotionGraph,
    course: Course,
    events: list[Event],
    targets: tuple[Target, ...],
    config: ReachConfig,
) -> tuple[Motion, Motion, Playback, dict[int, Span], dict[int, Duck]]:
    """The walk played with its stops, ducks and reaches blended in.

    Where a joint turns too fast, all blends are made longer.
    """
    blend = config.blend_s
    for attempt in range(_TIMES):
        frames = round(blend * graph.frame_rate)
        played, spans = _schedule(course, events, frames)
        plain = sample(course.motion, played.frames)
        motion: Motion = plain
        ducks: dict[int, Duck] = {}
        for number, target in enumerate(targets):
            if target.bar is not None:
                ducks[number] = duck(graph, motion, target.bar, frames, config)
                motion = ducks[number].motion
        for group in groups(list(spans.values()), frames):
            motion = blend_group(graph, motion, group, frames, config)
        if attempt + 1 == _TIMES or fastest_turn(motion, plain) <= config.turn_deg_s:
            return motion, plain, played, spans, ducks
        blend *= _LONGER
    raise AssertionError("the last attempt returns")
