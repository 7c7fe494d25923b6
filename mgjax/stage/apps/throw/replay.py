"""The last throw once more, with what else could have been played."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.choice.explain import Explained, explain
from mgjax.avoidance.play.answers import Asked
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.core.motion import Motion
from mgjax.graph.feet.played import play_at
from mgjax.stage.apps.throw.contact import track
from mgjax.stage.apps.throw.lane import COLOURS, Lane, Throw
from mgjax.stage.apps.throw.words import energy_of_words, kind_of, outcome
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.types import Actor, Ball, Show, Span
from mgjax.stage.show.words import length_words

RATE = 30.0
BEFORE_S, AFTER_S = 0.4, 0.6
MOST_GHOSTS = 6


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """What is replayed: from ``first`` on, ``seconds`` long."""

    first: float
    seconds: float

    @property
    def times(self) -> Float[np.ndarray, " T"]:
        return self.first + np.arange(max(int(self.seconds * RATE), 2)) / RATE


def replay_show(lane: Lane, throw: Throw, *, ghosts: bool) -> Show:
    """A throw that is over, from a little before it to a little after.

    Args:
        lane: the character.
        throw: at it.
        ghosts: with the candidates, the best first: clear ones and rejected ones, with the reason
            over their heads.
    """
    assert throw.answer is not None, "only what is over can be shown again"
    first = max(throw.attack.start - BEFORE_S, 0.0)
    stretch = Stretch(first=first, seconds=throw.attack.end + AFTER_S - first)
    graph = lane.prepared.graph
    frames = frames_of(lane.planner.timeline.sample(stretch.times))
    actors = [Actor(id=lane.actor_id, body=0, frames=frames, colour=COLOURS[lane.number])]
    spans = [
        Span(
            row="ball",
            start=throw.attack.start - first,
            end=throw.attack.end - first,
            text="in the air",
            colour="orange",
        )
    ]
    notes: list[tuple[str, str]] = []
    if ghosts and throw.found is not None:
        rows = candidates_of(lane, throw.found.asked)
        for place, row in enumerate(rows[:MOST_GHOSTS]):
            actors.append(_ghost(lane, throw.found.asked, row, place, stretch))
        notes = [(f"{i + 1}. {kind_of(graph, r.part)}", reason(r)) for i, r in enumerate(rows)]
    words, _ = outcome(graph, throw.answer, throw.found, throw.contact)
    return Show(
        title="Replay",
        words=words,
        seconds=stretch.seconds,
        bodies=[body_of(graph.skeleton)],
        actors=actors,
        balls=[_ball(lane, throw, first)],
        spans=spans,
        notes=notes,
        moments=_moments(throw, first),
    )


def candidates_of(lane: Lane, asked: Asked) -> list[Explained]:
    """Candidates of a search, the best first; of those that play the same, the best alone."""
    rows = explain(lane.prepared, asked.node, asked.attack, config=lane.config, checked=48)
    seen: set[tuple[int, int]] = set()
    kept: list[Explained] = []
    for row in rows:
        key = (row.part, int(row.walk.edges[0]))
        if key not in seen:
            seen.add(key)
            kept.append(row)
    return kept


def reason(row: Explained) -> str:
    """Why a candidate could be played, or could not."""
    if row.outcome == "clear":
        return f"clear by {length_words(row.clearance_m or 0)}, {energy_of_words(row.energy)}"
    if row.outcome == "hit":
        return f"hit, {length_words(-(row.clearance_m or 0))} deep"
    if row.outcome == "not adjustable":
        return "no edge may change its speed as needed"
    return {"time scale": "time scale out of range", "unchecked": "not checked"}[row.outcome]


def walk_frames(lane: Lane, asked: Asked, row: Explained, times: Float[np.ndarray, " T"]) -> Motion:
    """A candidate as it would have been played; before its beginning what was played."""
    begun = times >= asked.begins
    after = play_at(
        lane.prepared.graph,
        row.walk,
        times[begun] - asked.begins,
        rate=EXPORT_RATE,
        start=asked.place,
        begin=asked.feet,
    )
    if begun.all():
        return after
    before = lane.planner.timeline.sample(times[~begun])
    return Motion(
        root_translation=np.concatenate([before.root_translation, after.root_translation]),
        local_rotations=np.concatenate([before.local_rotations, after.local_rotations]),
        frame_rate=RATE,
    )


def _ghost(lane: Lane, asked: Asked, row: Explained, place: int, stretch: Stretch) -> Actor:
    kind = kind_of(lane.prepared.graph, row.part)
    clear = row.outcome == "clear"
    return Actor(
        id=f"candidate{place}",
        body=0,
        frames=frames_of(walk_frames(lane, asked, row, stretch.times)),
        colour="sky" if clear else "red",
        look="ghost",
        note=f"{place + 1}. {kind}: {reason(row)}",
    )


def _ball(lane: Lane, throw: Throw, first: float) -> Ball:
    times, places = track(throw.attack, throw.contact, float(throw.attack.radii[0]))
    return Ball(
        id=f"{lane.actor_id}-{throw.ball_id}",
        radius=float(throw.attack.radii[0]),
        times=times - first,
        places=places,
        colour="orange" if throw.contact is None else "red",
    )


def _moments(throw: Throw, first: float) -> list[tuple[str, float]]:
    assert throw.answer is not None
    moments = [("thrown", max(throw.attack.start - first, 0.0))]
    if throw.found is not None:
        moments.append(("path begins", throw.found.asked.begins - first))
    if throw.contact is not None:
        moments.append(("hit", throw.contact.time - first))
    return moments
