"""Several attacks one after another, and one motion that avoids them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.selection import Selection
from mgjax.avoidance.timing.walk_warps import part_moments
from mgjax.core import planar
from mgjax.core.kinematics import forward, planar_frames
from mgjax.core.motion import Motion, sample
from mgjax.graph.types import MotionGraph
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.selection import attack_balls, part_words, selection_words
from mgjax.stage.show.types import Actor, Ball, Show, Span
from mgjax.stage.show.walk import floor_path
from mgjax.stage.show.words import status_colour


@dataclass(frozen=True, kw_only=True, eq=False)
class Thrown:
    """One attack of several.

    Attributes:
        now: second of the motion at which the character has to react.
        attack: in the planar frame of its pose then.
        selection: what it does.
        place: that planar frame, in the world; None: of the pose that the motion has then. [3]
    """

    now: float
    attack: Attack
    selection: Selection
    place: Float[np.ndarray, "3"] | None = None


def throws_show(
    graph: MotionGraph, motion: Motion, throws: Sequence[Thrown], *, title: str = "Throws"
) -> Show:
    """The whole motion, all balls where they fly, and what came of each on the timeline."""
    avoided = sum(throw.selection.status == "avoided" for throw in throws)
    balls = [
        ball
        for number, throw in enumerate(throws, 1)
        for ball in world_balls(graph, motion, throw, f"ball {number}")
    ]
    spans: list[Span] = []
    for throw in throws:
        spans += _spans(graph, throw)
    return Show(
        title=title,
        words=f"{avoided} of {len(throws)} balls avoided",
        seconds=(motion.num_frames - 1) / motion.frame_rate,
        bodies=[body_of(graph.skeleton)],
        actors=[Actor(id="body", body=0, frames=frames_of(motion))],
        balls=balls,
        lines=[floor_path("path", motion)],
        spans=spans,
        notes=[
            (f"ball {number}", selection_words(graph, throw.selection))
            for number, throw in enumerate(throws, 1)
        ],
    )


def world_balls(graph: MotionGraph, motion: Motion, throw: Thrown, name: str) -> list[Ball]:
    """The balls of an attack in the world of the motion, on its clock."""
    frame = throw.place
    if frame is None:
        pose = sample(motion, np.array([throw.now * motion.frame_rate]))
        places, _ = forward(graph.skeleton, pose.root_translation, pose.local_rotations)
        frame = np.asarray(planar_frames(graph.skeleton, np.asarray(places)), np.float64)[0]
    parry = throw.selection.parry
    attack = throw.attack if parry is None else parry.left_of(throw.attack)
    return [
        replace(ball, places=np.asarray(planar.apply(frame, ball.places)))
        for ball in attack_balls(attack, name=name, now=throw.now)
    ]


def _spans(graph: MotionGraph, throw: Thrown) -> list[Span]:
    """The avoidance, and the time in which the ball is near."""
    chosen, spans = throw.selection, []
    if chosen.part is not None:
        captured = part_moments(graph, chosen.walk, chosen.path_length, chosen.part)
        first, _, last = (throw.now + float(t) for t in chosen.timing.when(captured))
        colour = status_colour(chosen.status)
        text = part_words(graph, chosen.part)
        spans.append(Span(row="avoidance", start=first, end=last, text=text, colour=colour))
    if chosen.crop is not None:
        start, end = throw.now + chosen.crop.start, throw.now + chosen.crop.end
        spans.append(Span(row="ball near", start=start, end=end, text="", colour="orange"))
    return spans
