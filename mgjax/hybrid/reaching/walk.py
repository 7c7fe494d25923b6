"""Walk a sketched path and reach on the way (Kalouache & Cherif, section III.A.2)."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.core.motion import Motion, sample
from mgjax.core.shown import made_of
from mgjax.graph.plants import foot_slide
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk
from mgjax.hybrid.config import PathConfig, ReachConfig, reach_for_body, validate_reach_config
from mgjax.hybrid.paths.curve import make_curve
from mgjax.hybrid.paths.result import PathResult, track_of
from mgjax.hybrid.paths.search import follow
from mgjax.hybrid.paths.sketch import Sketch
from mgjax.hybrid.prepared import Prepared, prepared_for
from mgjax.hybrid.reaching.blend import (
    Hold,
    blend_group,
    fast_frames,
    fastest_turn,
    overlapping_groups,
    turn_speeds,
)
from mgjax.hybrid.reaching.duck import Duck, duck
from mgjax.hybrid.reaching.events import ReachEvent, make_events, place_events
from mgjax.hybrid.reaching.result import ReachResult, bar_row, target_row
from mgjax.hybrid.reaching.sampled_walk import SampledWalk, make_sampled_walk
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
    walked: PathResult | None = None,
    prepared: Prepared | None = None,
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
        walked: of :func:`mgjax.hybrid.follow` with the same sketch, where it is known; targets may
            be moved then without another search.
        prepared: of :func:`mgjax.hybrid.prepare` with ``config``; None: computed once for each
            graph, and kept for the graphs used last.

    Raises:
        ReachError: a target inside the body, two for one limb at one time.
        PathError, GraphError, ConfigError: as :func:`mgjax.hybrid.follow`.
    """
    config, path = config or ReachConfig(), path or PathConfig()
    validate_reach_config(config)
    config = reach_for_body(config, graph.body_scale)
    events = make_events(graph, targets)
    prepared = prepared_for(graph, config, prepared)
    if walked is None:
        walked = follow(graph, sketch, config=path, node=node, start=start, prepared=prepared)
    begun = time.perf_counter()
    edges = tuple(walked.walk.edges.tolist())
    first = make_sampled_walk(graph, prepared, edges, walked.frames, walked.start)
    sampled = place_events(first, make_curve(sketch, graph.body_scale), events, config, path)
    if sampled is not first:
        walked = _extended(graph, walked, sampled, sketch)
    kept = [event for event in events if event.status == "reached"]
    motion, plain, played, holds, ducks = _move(sampled, kept, targets, config)
    _mark_fast(motion, plain, kept, holds, config)
    rows = [
        bar_row(prepared.reach_body, motion, target, ducks[number], config.drop_m)
        if target.bar is not None
        else target_row(graph, prepared.reach_body, motion, target, number, events, holds, config)
        for number, target in enumerate(targets)
    ]
    plants = sampled.plants[np.round(played.frames).astype(int)]
    result = ReachResult(
        walked=walked,
        motion=made_of(motion, graph.skeleton),
        plain=made_of(plain, graph.skeleton),
        shown=played.frames,
        targets=tuple(rows),
        fastest_deg_s=fastest_turn(motion, plain),
        fastest_plain_deg_s=float(turn_speeds(plain).max()),
        slide=foot_slide(graph.skeleton, motion, plants)[0],
        solve_s=time.perf_counter() - begun,
    )
    return made_of(result, graph, sketch)


def _extended(
    graph: MotionGraph, walked: PathResult, sampled: SampledWalk, sketch: Sketch
) -> PathResult:
    """The result of the path search for a walk that goes on elsewhere."""
    chosen = np.array(sampled.edges)
    blend = np.repeat(
        graph.edge_distance[chosen].astype(np.float64) ** 2, graph.edge_frames[chosen]
    )
    track = track_of(graph, sampled.motion, blend[: sampled.frames])
    curve = make_curve(sketch, graph.body_scale)
    slide, share = foot_slide(graph.skeleton, sampled.motion, sampled.plants)
    return replace(
        walked,
        walk=make_walk(graph, chosen),
        frames=sampled.frames,
        seconds=sampled.frames / graph.frame_rate,
        motion=sampled.motion,
        plants=sampled.plants,
        track=track,
        error=float(track.squares(curve).sum()),
        distance=curve.nearest(track.places, track.arc)[0],
        slide=slide,
        slide_share=share,
    )


def _schedule(
    sampled: SampledWalk, events: list[ReachEvent], blend: int
) -> tuple[Playback, dict[int, Hold]]:
    """The walk with its stops, and the frames in which targets are held, by event."""
    rate = sampled.graph.frame_rate
    ordered = sorted(events, key=lambda e: e.key.place.frame if e.key else 0)
    stops: list[Stop] = []
    leads: list[int] = []
    for event in ordered:
        assert event.key is not None
        place = event.key.place
        if place.stop:
            hold = _hold_frames(event, rate)
            before = blend if place.frame == 0 else blend // 2
            after = blend if place.frame == sampled.frames else blend // 2
            stops.append(Stop(frame=place.frame, frames=before + hold + after))
            leads.append(before)
    played = play(sampled.frames, rate, stops)
    holds: dict[int, Hold] = {}
    number = 0
    for event in ordered:
        assert event.key is not None
        hold = _hold_frames(event, rate)
        if event.key.place.stop:
            first = played.stands[number][0] + leads[number]
            number += 1
        else:
            first = played.shown(event.key.place.frame)
        holds[id(event)] = Hold(
            first=first,
            last=min(first + hold, len(played.frames) - 1),
            targets=tuple(event.targets),
            key=event.key,
            key_frame=min(first + hold // 2, len(played.frames) - 1),
        )
    return played, holds


def _hold_frames(event: ReachEvent, rate: float) -> int:
    return round(max(target.hold_s for target in event.targets) * rate)


def _mark_fast(
    motion: Motion,
    plain: Motion,
    events: list[ReachEvent],
    holds: dict[int, Hold],
    config: ReachConfig,
) -> None:
    """Events around which a joint turns too fast, in spite of all, are not reached as asked."""
    fast = np.flatnonzero(fast_frames(motion, plain) > config.turn_deg_s)
    for event in events if fast.size else []:
        near = [min(abs(fast - s.first).min(), abs(fast - s.last).min()) for s in holds.values()]
        hold = holds[id(event)]
        if min(abs(fast - hold.first).min(), abs(fast - hold.last).min()) == min(near):
            event.status = "too_fast"


def _move(
    sampled: SampledWalk,
    events: list[ReachEvent],
    targets: tuple[Target, ...],
    config: ReachConfig,
) -> tuple[Motion, Motion, Playback, dict[int, Hold], dict[int, Duck]]:
    """The walk played with its stops, ducks and reaches blended in.

    Where a joint turns too fast, all blends are made longer; not those that have no length.
    """
    graph, body, blend = sampled.graph, sampled.body, config.blend_s
    for attempt in range(_TIMES):
        frames = round(blend * graph.frame_rate)
        played, holds = _schedule(sampled, events, frames)
        plain = sample(sampled.motion, played.frames)
        motion: Motion = plain
        ducks: dict[int, Duck] = {}
        for number, target in enumerate(targets):
            if target.bar is not None:
                ducks[number] = duck(body, motion, target.bar, frames, config)
                motion = ducks[number].motion
        for group in overlapping_groups(list(holds.values()), frames):
            motion = blend_group(graph, body, motion, group, frames, config)
        last = attempt + 1 == _TIMES or blend == 0
        if last or fastest_turn(motion, plain) <= config.turn_deg_s:
            return motion, plain, played, holds, ducks
        blend *= _LONGER
    raise AssertionError("the last attempt returns")
