"""Walk a sketched path and reach on the way (Kalouache & Cherif, section III.A.2)."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion, sample
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import make_walk
from mgjax.hybrid.limbs import find_limb
from mgjax.hybrid.path_config import PathConfig
from mgjax.hybrid.path_curve import make_curve
from mgjax.hybrid.path_feet import foot_slide
from mgjax.hybrid.path_result import PathResult, track_of
from mgjax.hybrid.path_search import follow
from mgjax.hybrid.path_sketch import Sketch
from mgjax.hybrid.reach_blend import Span, blend_group, groups, turn_speeds
from mgjax.hybrid.reach_body import arm_clearance, body_of
from mgjax.hybrid.reach_config import ReachConfig
from mgjax.hybrid.reach_course import Course, make_course
from mgjax.hybrid.reach_duck import CLEAR_M, clearance, duck
from mgjax.hybrid.reach_events import Event, arrange, make_events
from mgjax.hybrid.reach_playback import Playback, Stop, play
from mgjax.hybrid.reach_targets import Target

_LONGER = 1.4
"""A blend in which a joint turns too fast is made so much longer, again and again."""
_TIMES = 5


@dataclass(frozen=True, kw_only=True, eq=False)
class Reached:
    """What came of one target.

    Attributes:
        status: ``"reached"``; ``"out_of_reach"``: nowhere on the walk; ``"too_high"``: the target
            is more than 0.95 Σd above the base; ``"limits"``: near enough, but the joints do not
            allow it, or not over the whole hold; ``"lost"``: no way leads there. A bar is
            ``"cleared"`` or ``"hit"``.
        error_m: distance of the end to the target at the beginning of the hold; of a bar NaN.
        hold_m: the largest one over the hold.
        first, last: frames of the hold, or of being down; None if there is none.
        extended_m: length of the way that was added to the walk, m; 0 for none.
        stopped: the walk stands still meanwhile.
        drop_m: how far the pelvis is down.
        clear_m: of a bar, what is left between it and the body; of a hand, between arm and body.
    """

    target: Target
    status: str
    error_m: float
    hold_m: float
    first: int | None
    last: int | None
    extended_m: float
    stopped: bool
    drop_m: float
    clear_m: float


@dataclass(frozen=True, kw_only=True, eq=False)
class ReachResult:
    """A walk with reaches.

    Attributes:
        walked: the walk as it is walked, with what extends it, before limbs reach.
        motion: with the reaches.
        plain: the same with stops, but without reaches.
        targets: one result for each target.
        fastest_deg_s: fastest turn of a joint, degrees/s.
        fastest_plain_deg_s: that of the walk without reaches.
        slide: metres that planted feet travel per frame, both together, with the reaches.
        solve_s: seconds spent on everything after the first walk.
    """

    walked: PathResult
    motion: Motion
    plain: Motion
    targets: tuple[Reached, ...]
    fastest_deg_s: float
    fastest_plain_deg_s: float
    slide: float
    solve_s: float


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
    played, spans = _schedule(course, kept, config)
    plain = sample(course.motion, played.frames.astype(np.float64))
    motion, ducks = plain, {}
    blend = round(config.blend_s * graph.frame_rate)
    for number, target in enumerate(targets):
        if target.bar is not None:
            ducks[number] = duck(graph, motion, target.bar, blend, config)
            motion = ducks[number].motion
    motion = _with_reaches(graph, motion, plain, list(spans.values()), blend, config)
    rows = [
        _bar_row(graph, motion, target, ducks[number])
        if target.bar is not None
        else _row(graph, motion, target, number, events, spans)
        for number, target in enumerate(targets)
    ]
    plants = course.plants[np.round(played.frames).astype(int)]
    return ReachResult(
        walked=walked,
        motion=motion,
        plain=plain,
        targets=tuple(rows),
        fastest_deg_s=float(turn_speeds(motion).max()),
        fastest_plain_deg_s=float(turn_speeds(plain).max()),
        slide=foot_slide(graph.skeleton, motion, plants)[0],
        solve_s=time.perf_counter() - begun,
    )


def _extended(
    graph: MotionGraph, walked: PathResult, course: Course, sketch: Sketch
) -> PathResult:
    """The result of the path search for a walk that goes on elsewhere."""
    chosen = np.array(course.edges)
    blend = np.repeat(graph.edge_distance[chosen].astype(np.float64) ** 2, graph.edge_frames[chosen])
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


def _schedule(
    course: Course, events: list[Event], config: ReachConfig
) -> tuple[Playback, dict[int, Span]]:
    """The walk with its stops, and the frames in which targets are held, by event."""
    rate = course.graph.frame_rate
    blend = round(config.blend_s * rate)
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


def _with_reaches(
    graph: MotionGraph,
    motion: Motion,
    plain: Motion,
    spans: list[Span],
    blend: int,
    config: ReachConfig,
) -> Motion:
    """Blends all reaches in; where a joint turns too fast, over a longer time."""
    allowed = max(config.turn_deg_s, float(turn_speeds(plain).max()))
    longest = blend
    for _ in range(_TIMES):
        moved = motion
        for group in groups(spans, longest):
            moved = blend_group(graph, moved, group, longest, config)
        if turn_speeds(moved).max() <= allowed:
            return moved
        longest = round(longest * _LONGER)
    return moved


def _row(
    graph: MotionGraph,
    motion: Motion,
    target: Target,
    number: int,
    events: list[Event],
    spans: dict[int, Span],
) -> Reached:
    event = next(event for event in events if number in event.numbers)
    span = spans.get(id(event))
    if span is None or event.key is None:
        return Reached(
            target=target, status=event.status, first=None, last=None, extended_m=0.0,
            error_m=event.key.error_m if event.key else np.nan,
            hold_m=np.nan, stopped=False, drop_m=0.0, clear_m=np.nan,
        )  # fmt: skip
    positions = np.asarray(global_positions(graph.skeleton, motion), np.float64)
    rows = np.arange(span.first, span.last + 1)
    wanted = target.at((rows - span.first) / graph.frame_rate)
    joint = find_limb(graph.skeleton, target.limb).joints[-1]
    off = np.linalg.norm(positions[rows, joint] - wanted, axis=-1)
    body = body_of(graph.skeleton)
    hand = target.limb != "head"
    return Reached(
        target=target,
        status=event.status,
        error_m=float(off[0]),
        hold_m=float(off.max()),
        first=span.first,
        last=span.last,
        extended_m=event.extended_m,
        stopped=event.key.place.stop,
        drop_m=event.key.drop_m,
        clear_m=float(arm_clearance(body, positions[rows], target.limb).min()) if hand else np.nan,
    )


def _bar_row(graph: MotionGraph, motion: Motion, target: Target, ducked) -> Reached:  # noqa: ANN001
    assert target.bar is not None
    left = float(clearance(graph, motion, target.bar).min())
    frames = ducked.frames or (None, None)
    return Reached(
        target=target, status="cleared" if left >= 0 else "hit", error_m=np.nan, hold_m=np.nan,
        first=frames[0], last=frames[1], extended_m=0.0, stopped=False,
        drop_m=0.0, clear_m=left,
    )  # fmt: skip
