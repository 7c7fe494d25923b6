"""What the players of a scene can do: idle, turn on the spot, hit, and how one leads to another."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import numpy as np
from jaxtyping import Float, Int

from mgjax.ballsport.clipset.ball_contact import Contacts, contacts
from mgjax.ballsport.clipset.build import NO_LINK, ClipSet
from mgjax.ballsport.clipset.transition import find_transitions
from mgjax.ballsport.config import TransitionConfig
from mgjax.clips.synthetic_turns import synthetic_turns
from mgjax.core.errors import MotionError
from mgjax.core.kinematics import global_positions, planar_frames
from mgjax.core.motion import Motion
from mgjax.graph.blending.alignment import align

TURN_DEG = 10
"""Turns exist in steps of this."""

_IDLE = "ball_idle"
_PART_S = 0.215
"""A link motion has one best section for each of its parts of this length, s, so that there are
many moments to leave it."""
_NEAR_S = 1.5
"""How much of the link motion around a hit is used, s: a captured run-up can be long."""

_align = jax.jit(align)


@dataclass(frozen=True, kw_only=True, eq=False)
class Repertoire:
    """The motion of a scene.

    A run is a stretch of link motion that can be played through; a part is a piece of a run with
    transition sections of its own.

    Attributes:
        clips: the clip set; behind its frames are those of the turns.
        window: frames of a blend.
        starts, stops: parts, in frames. [M]
        runs: run of each part. [M]
        run_stops: end of each run, frames.
        distance: D_p of a frame in the best section between two parts. [M, M]
        leave, arrive: first frames of the section in either part. [M, M]
        idle: parts of the idle motion. [I]
        rest: the part that is the rest pose before and after a turn.
        turns: start and stop frames of the turns by angle in degrees.
        before: parts of the run that leads into each hit; hits without one cannot be used.
        after: run that follows each hit.
        touch: where each hit that can be used meets the ball.
    """

    clips: ClipSet
    window: int
    starts: Int[np.ndarray, " M"]
    stops: Int[np.ndarray, " M"]
    runs: Int[np.ndarray, " M"]
    run_stops: dict[int, int]
    distance: Float[np.ndarray, "M M"]
    leave: Int[np.ndarray, "M M"]
    arrive: Int[np.ndarray, "M M"]
    idle: np.ndarray
    rest: int
    turns: dict[int, tuple[int, int]]
    before: dict[int, np.ndarray]
    after: dict[int, int]
    touch: dict[int, Contacts]

    @property
    def frame_rate(self) -> float:
        return self.clips.motion.frame_rate

    def seam(self, leave: int, arrive: int) -> Float[np.ndarray, "3"]:
        """The planar transform of what is arrived at, in the coordinates of what is left."""
        places, w = self.clips.positions, self.window
        even = np.full(places.shape[1], 1 / places.shape[1], np.float32)
        transform = _align(places[leave : leave + w], places[arrive : arrive + w], even)
        return np.asarray(transform, np.float64)


def make_repertoire(
    clips: ClipSet, *, ball_radius: float, transition: TransitionConfig | None = None, seed: int = 0
) -> Repertoire:
    """Adds turns, cuts link motions into parts and finds the sections between all of them.

    Raises:
        MotionError: no hit lies between two link motions that are long enough for a blend.
    """
    transition = transition or TransitionConfig()
    window = round(transition.seconds * clips.motion.frame_rate)
    extended, turns, rest = _with_turns(clips, window, seed)
    spans = _runs(clips, window)
    spans[NO_LINK] = rest
    parts = [(run, *part) for run, span in spans.items() for part in _parts(span, window, extended)]
    runs, starts, stops = (np.array(x, np.int64) for x in zip(*parts, strict=True))
    cut = replace(extended, link_clip=0 * runs, link_starts=starts, link_stops=stops)
    table = find_transitions(cut, transition)
    before = {
        hit: np.flatnonzero((runs == clips.link_before[hit]) & (stops <= clips.hit_starts[hit]))
        for hit in _usable(clips, window)
    }
    touch = {hit: contacts(clips, hit, ball_radius) for hit in before}
    usable = [hit for hit in before if len(before[hit]) and touch[hit].mask.any()]
    if not usable:
        raise MotionError("got no hit between two link motions, expected at least one")
    return Repertoire(
        clips=extended,
        window=window,
        starts=starts,
        stops=stops,
        runs=runs,
        run_stops={run: stop for run, (_, stop) in spans.items()},
        distance=table.distance / window,
        leave=table.leave,
        arrive=table.arrive,
        idle=np.flatnonzero(runs == _idle_link(clips)),
        rest=int(np.flatnonzero(runs == NO_LINK)[0]),
        turns=turns,
        before={hit: before[hit] for hit in usable},
        after={hit: int(clips.link_after[hit]) for hit in usable},
        touch={hit: touch[hit] for hit in usable},
    )


def _with_turns(
    clips: ClipSet, window: int, seed: int
) -> tuple[ClipSet, dict[int, tuple[int, int]], tuple[int, int]]:
    """The clip set with turns and the rest pose behind it, and where they are."""
    rate = clips.motion.frame_rate
    angles = [a for a in range(-180, 181, TURN_DEG) if a]
    motions = [c.motion for c in synthetic_turns(tuple(angles), seed=seed, frame_rate=rate)]
    still = motions[0]
    motions.append(
        Motion(
            root_translation=np.repeat(still.root_translation[:1], window, axis=0),
            local_rotations=np.repeat(still.local_rotations[:1], window, axis=0),
            frame_rate=rate,
        )
    )
    stops = clips.motion.num_frames + np.cumsum([m.num_frames for m in motions])
    starts = stops - [m.num_frames for m in motions]
    more = Motion(
        root_translation=np.concatenate([m.root_translation for m in motions]),
        local_rotations=np.concatenate([m.local_rotations for m in motions]),
        frame_rate=rate,
    )
    places = np.asarray(global_positions(clips.skeleton, more))
    planes = np.asarray(planar_frames(clips.skeleton, places))
    old = clips.motion
    extended = replace(
        clips,
        motion=replace(
            old,
            root_translation=np.concatenate([old.root_translation, more.root_translation]),
            local_rotations=np.concatenate([old.local_rotations, more.local_rotations]),
        ),
        positions=np.concatenate([clips.positions, places]),
        planes=np.concatenate([clips.planes, planes]),
        clip_names=(*clips.clip_names, *(f"turn_{a}" for a in angles), "rest"),
        clip_starts=np.concatenate([clips.clip_starts, starts]),
        clip_stops=np.concatenate([clips.clip_stops, stops]),
    )
    ranges = [(int(a), int(b)) for a, b in zip(starts, stops, strict=True)]
    return extended, dict(zip(angles, ranges, strict=False)), ranges[-1]


def _usable(clips: ClipSet, window: int) -> list[int]:
    """Hits between two link motions that are long enough."""
    long = clips.link_stops - clips.link_starts >= 2 * window
    around = zip(clips.link_before, clips.link_after, strict=True)
    return [
        hit
        for hit, (a, b) in enumerate(around)
        if a != NO_LINK and b != NO_LINK and long[a] and long[b]
    ]


def _idle_link(clips: ClipSet) -> int:
    clip = clips.clip_names.index(_IDLE)
    links = np.flatnonzero(clips.link_clip == clip)
    return int(links[np.argmax((clips.link_stops - clips.link_starts)[links])])


def _runs(clips: ClipSet, window: int) -> dict[int, tuple[int, int]]:
    """Start and stop of the link motions that are used, by their number."""
    near = round(_NEAR_S * clips.motion.frame_rate)
    idle = _idle_link(clips)
    spans = {idle: (int(clips.link_starts[idle]), int(clips.link_stops[idle]))}
    for hit in _usable(clips, window):
        for link in (int(clips.link_before[hit]), int(clips.link_after[hit])):
            start, stop = int(clips.link_starts[link]), int(clips.link_stops[link])
            if stop - start <= 2 * near:
                spans[link] = (start, stop)
            elif link == clips.link_before[hit] and link not in spans:
                spans[link] = (stop - near, stop)
            elif link not in spans:
                spans[link] = (start, start + near)
    return spans


def _parts(span: tuple[int, int], window: int, clips: ClipSet) -> list[tuple[int, int]]:
    """Pieces of a run that together hold each of its windows once."""
    start, stop = span
    step = max(2, round(_PART_S * clips.motion.frame_rate))
    last = stop - window
    return [(first, min(first + step - 1, last) + window) for first in range(start, last + 1, step)]
