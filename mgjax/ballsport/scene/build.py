"""A scene: several players who pass a ball to one another, as motion and as the ball's path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.clipset.build import build_clip_set
from mgjax.ballsport.clipset.repertoire import Repertoire, make_repertoire
from mgjax.ballsport.scene.ball_track import BallTrack, track_ball
from mgjax.ballsport.scene.config import SceneConfig, validate_scene
from mgjax.ballsport.scene.gaze import look_at
from mgjax.ballsport.scene.player import Actor
from mgjax.ballsport.scene.rally import Rally
from mgjax.ballsport.scene.types import THROWN_IN, BallFlight, Choose, Touch
from mgjax.clips.folder import load_clips
from mgjax.core.kinematics import global_positions
from mgjax.core.motion import Motion
from mgjax.core.shown import Shown, made_of
from mgjax.core.skeleton import Skeleton


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene(Shown):
    """Everything that happens; all motion has one length and begins at time 0.

    Attributes:
        config: what was asked.
        moves: what it was made of.
        motions: of each player by name.
        positions: of their joints, m.
        touches: hits in order.
        flights: the ball between them in order; the last belongs to the last touch and goes to
            nobody.
        ends: by whom and to whom each flight goes, "" for nobody.
        ball: its path.
        seams: of each player's motion, start and stop, s.
        turns: of each player on the spot: when, s, and how far, degrees.
    """

    config: SceneConfig
    moves: Repertoire
    motions: Mapping[str, Motion]
    positions: Mapping[str, Float[np.ndarray, "F J 3"]]
    touches: tuple[Touch, ...]
    flights: tuple[BallFlight, ...]
    ends: tuple[tuple[str, str], ...]
    ball: BallTrack
    seams: Mapping[str, Float[np.ndarray, "S 2"]]
    turns: Mapping[str, list[tuple[float, int]]]

    @property
    def skeleton(self) -> Skeleton:
        return self.moves.clips.skeleton

    @property
    def frame_rate(self) -> float:
        return self.moves.frame_rate


def prepare_scene(config: SceneConfig) -> Repertoire:
    """The clip set of a scene with all transitions; may serve several scenes.

    Raises:
        ConfigError: a scene that cannot be begun.
        MotionError: a folder without clips, or without a usable hit.
    """
    validate_scene(config)
    clips = load_clips(config.clips, exclude=config.exclude)[0] if config.clips else []
    built = build_clip_set(
        clips,
        config=config.clip_set,
        seed=config.seed,
        takes=config.takes,
    )
    return make_repertoire(
        built,
        ball_radius=float(config.physics.radius),
        transition=config.transition,
        seed=config.seed,
    )


def build_scene(
    config: SceneConfig, *, moves: Repertoire | None = None, choose: Choose | None = None
) -> Scene:
    """Makes a scene (Choi et al. 2019, §4–5).

    Touch by touch: a stored hit and the frame in which it meets the ball; links that lead to it and
    a flight time that suit each other; the pass aimed at where that foot will be, at that frame.
    Players who are free turn to the ball by stepping on the spot, and everybody looks at it.

    Deviation:
        The paper turns a hit to one of eight headings. Here players step round beforehand, in
        steps of 10°, so that a hit needs no other heading than straight ahead.

    Args:
        config: players, passes, physics.
        moves: from :func:`prepare_scene`; made where not given.
        choose: the user's motion: asked for the hit of each touch whose kind is "any", at the
            latest when the ball is launched to it.

    Raises:
        ConfigError: a scene that cannot be; a pass out of reach is no error but a miss, after which
            a ball is thrown in.
    """
    validate_scene(config)
    moves = prepare_scene(config) if moves is None else moves
    rally = Rally(config, moves, choose)
    while not rally.done:
        rally.step()
    return finish_scene(rally)


def finish_scene(rally: Rally) -> Scene:
    """The motion and the ball's path of all that a rally has planned."""
    ends = tuple(_ends(rally, flight) for flight in rally.flights)
    return make_scene(
        rally.config,
        rally.moves,
        rally.actors,
        touches=rally.touches,
        flights=rally.flights,
        ends=ends,
    )


def make_scene(
    config: SceneConfig,
    moves: Repertoire,
    actors: Mapping[str, Actor],
    *,
    touches: Sequence[Touch],
    flights: Sequence[BallFlight],
    ends: Sequence[tuple[str, str]],
) -> Scene:
    """A scene of what players do and how the ball flies.

    Args:
        config: of the scene.
        moves: what it was made of.
        actors: the players by name; they are made to idle after their last touch.
        touches: in order.
        flights: in order, numbered as the touches that begin them.
        ends: by whom and to whom each goes, "" for nobody.
    """
    rate = moves.frame_rate
    ball = track_ball(flights, ends, rate, config.physics)
    motions: dict[str, Motion] = {}
    seams: dict[str, np.ndarray] = {}
    for name, actor in actors.items():
        motion, blends = actor.motion(len(ball.places))
        looking = look_at(moves.clips.skeleton, motion, ball.places)
        motions[name] = made_of(looking, moves.clips.skeleton)
        seams[name] = blends / rate
    return Scene(
        config=config,
        moves=moves,
        motions=motions,
        positions={
            name: np.asarray(global_positions(moves.clips.skeleton, motion))
            for name, motion in motions.items()
        },
        touches=tuple(touches),
        flights=tuple(flights),
        ends=tuple(ends),
        ball=ball,
        seams=seams,
        turns={
            name: [(time / rate, angle) for time, angle in actor.turns]
            for name, actor in actors.items()
        },
    )


def _ends(rally: Rally, flight: BallFlight) -> tuple[str, str]:
    """By whom and to whom a flight goes."""
    if flight.number != THROWN_IN:
        by = rally.order[flight.number]
        return by, rally.order[flight.number + 1] if flight.number + 1 < len(rally.order) else ""
    later = [touch for touch in rally.touches if touch.time == flight.stop]
    return "", later[0].player
