"""The ways out of an attack beside each other, and nothing that tells them apart but a letter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.study.trials import LETTERS
from mgjax.core import planar
from mgjax.core.motion import Motion
from mgjax.core.skeleton import Skeleton
from mgjax.stage.show.body import body_of
from mgjax.stage.show.frames import frames_of
from mgjax.stage.show.selection import attack_balls
from mgjax.stage.show.types import Actor, Ball, Show

APART_M = 2.2
SEEN_FROM = np.radians(20.0)
"""The row is turned so far about the vertical: the first on the left, balls towards the camera."""
QUESTION = "Which one avoids the ball most naturally, with the least movement?"


def trial_show(
    skeleton: Skeleton,
    motions: Sequence[Motion],
    attack: Attack,
    *,
    title: str,
    words: str = "",
    now: float = 0.0,
) -> Show:
    """Candidates in a row across the flight of the ball, each with its own ball.

    Args:
        skeleton, motions: of the candidates, equally long, in the planar frame in which the attack
            is; in the order in which they stand.
        attack: its times counted from ``now``.
        title, words: of the show.
        now: second of the motions at which the character has to react.
    """
    count = len(motions)
    flight = attack.centres[-1, 0] - attack.centres[0, 0]
    turned = np.array([-np.arctan2(flight[0], flight[2]), 0.0, 0.0])
    seen = np.array([SEEN_FROM, 0.0, 0.0])
    actors: list[Actor] = []
    balls: list[Ball] = []
    for place, motion in enumerate(motions):
        letter = LETTERS[place]
        aside = np.array([0.0, (place - (count - 1) / 2) * APART_M, 0.0])
        move = planar.compose(seen, planar.compose(aside, turned))
        frames = frames_of(placed(motion, np.asarray(move)))
        actors.append(Actor(id=letter, body=0, frames=frames, colour="grey", note=letter))
        for ball in attack_balls(attack, name=f"ball{letter}", now=now):
            balls.append(replace(ball, places=planar.apply(move, ball.places)))
    return Show(
        title=title,
        words=words,
        seconds=(motions[0].num_frames - 1) / motions[0].frame_rate,
        bodies=[body_of(skeleton)],
        actors=actors,
        balls=balls,
    )


def placed(motion: Motion, move: Float[np.ndarray, "3"]) -> Motion:
    """A motion under a planar transform."""
    root, turn = planar.apply_pose(
        move,
        np.asarray(motion.root_translation, np.float64),
        np.asarray(motion.local_rotations[:, 0], np.float64),
    )
    rotations = np.array(motion.local_rotations)
    rotations[:, 0] = turn
    return replace(motion, root_translation=np.asarray(root), local_rotations=rotations)
