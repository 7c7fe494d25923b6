"""One touch planned: the way of its player to the hit and the flight of the ball, chosen together.

Nothing here changes the rally: a :class:`Plan` holds the player as the plan leaves it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.ballsport.scene.flight_cost import cheapest, flight_cost
from mgjax.ballsport.scene.kick import Kick
from mgjax.ballsport.scene.launching import Launcher, make_flight
from mgjax.ballsport.scene.link_paths import LinkPaths
from mgjax.ballsport.scene.player import Actor
from mgjax.ballsport.scene.types import THROWN_IN, Asked, BallFlight, BallStart, Choose, Touch
from mgjax.core import planar
from mgjax.core.errors import ConfigError

_SHORTEST_S, _LONGEST_S, _EVERY = 0.3, 4.0, 2
"""Flight times that are looked at, the last in frames."""
_CHOICE_S = 3.0
"""Link paths to a hit are to last up to this and more; else the player idles before."""
_TRIES = 12
"""Arrivals that are tried with the exact place, in rising order of their cost."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Request:
    """What a touch is to be.

    Attributes:
        number: of the touch, from 0.
        player: who hits.
        kick: the stored hit and its frame.
        heading: of the body at the first frame of S_H, rad.
        now: scene frame from which on the player may act.
        by_user: whether the user's motion decided the hit.
        start: of the ball that comes.
        bystanders: where players stand who take no part, m. [3] each
    """

    number: int
    player: str
    kick: Kick
    heading: float
    now: int
    by_user: bool
    start: BallStart
    bystanders: Sequence[Float[np.ndarray, "3"]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A touch and the flight to it, or a miss.

    Attributes:
        player: who is to hit.
        actor: the player as the plan leaves it.
        touch: the hit; None where no flight meets the player.
        flight: of the ball to the touch; the one that comes nearest where there is none.
    """

    player: str
    actor: Actor
    touch: Touch | None
    flight: BallFlight


def plan_touch(launcher: Launcher, actor: Actor, request: Request) -> Plan:
    """Chooses flight time and links together.

    Args:
        launcher: of the scene.
        actor: the player who hits; left as it is.
        request: what the touch is to be.

    Raises:
        ConfigError: a throw that cannot reach the player, or no link motion into the hit.
    """
    actor = actor.copy()
    paths = _paths_to_hit(actor, request, launcher.rate)
    arrival = _first_arrival(launcher, actor, request, paths)
    if arrival is not None:
        touch, flight = arrival
        return Plan(player=request.player, actor=actor, touch=touch, flight=flight)
    if request.start.number == THROWN_IN:
        raise ConfigError(
            f"got a throw from {_shown(request.start.place)} to {request.player}, expected one that"
            f" reaches the player at up to {launcher.config.max_speed:g} m/s"
        )
    flight = launcher.nearest(request.start, _expected(actor, request))
    return Plan(player=request.player, actor=actor, touch=None, flight=flight)


def heading_of(displacement: Float[np.ndarray, "3"]) -> float:
    """Direction over the floor, rad; 0 is +z."""
    return float(np.arctan2(displacement[0], displacement[2]))


def _paths_to_hit(actor: Actor, request: Request, rate: float) -> LinkPaths:
    """Link paths to the hit; where all would arrive too soon the player idles first."""
    hit, now = request.kick.hit, request.now
    actor.leave_in_time(now)
    targets = actor.moves.before[hit]
    paths = actor.link_paths(targets, now=now, turn=actor.turn_to(request.heading))
    least = now - actor.time + round(_CHOICE_S * rate)
    if paths.frames.max(initial=0) < least:  # the link motion after a hit is soon over
        actor.idle_until(max(now, actor.time))
        paths = actor.link_paths(targets, now=now, turn=actor.turn_to(request.heading))
    if not len(paths.frames):
        raise ConfigError(f"got no link motion into hit {hit}, expected one")
    return paths


def _first_arrival(
    launcher: Launcher, actor: Actor, request: Request, paths: LinkPaths
) -> tuple[Touch, BallFlight] | None:
    """The cheapest touch that is met, to which the actor goes, and its flight; None: none is."""
    clips, kick, start = actor.moves.clips, request.kick, request.start
    first = int(clips.hit_starts[kick.hit])
    times = np.arange(
        start.time + round(_SHORTEST_S * launcher.rate),
        start.time + round(_LONGEST_S * launcher.rate),
        _EVERY,
    )
    tried: set[int] = set()
    for row, column in _by_cost(launcher, actor, request, paths, times):
        if len(tried) >= _TRIES or column in tried:
            continue
        tried.add(column)
        placement = actor.placed(paths.hops[row])
        centre = _ball_centre(actor, placement, kick)
        velocity, met = launcher.velocities(start, centre[None], times[column : column + 1])
        if not met[0]:
            continue
        time = int(times[column])
        plane = clips.planes[first].astype(np.float64)
        turn = np.array([placement[0] + plane[0], 0.0, 0.0])
        warp = actor.hit(paths, row, kick, now=request.now, time=time)
        touch = Touch(
            number=request.number,
            player=request.player,
            kick=kick,
            time=time,
            centre=centre,
            bone=np.asarray(planar.apply(turn, kick.velocity)),
            warp=warp,
            cost=float(paths.cost[row]),
            by_user=request.by_user,
        )
        return touch, make_flight(start, stop=time, velocity=velocity[0], target=centre)
    return None


def _by_cost(
    launcher: Launcher, actor: Actor, request: Request, paths: LinkPaths, times: np.ndarray
) -> list[tuple[int, int]]:
    """Pairs of a link path and an arrival, cheapest first, with the place that is expected."""
    kick, start = request.kick, request.start
    first = int(actor.moves.clips.hit_starts[kick.hit])
    begin = max(request.now, actor.time)
    # Frames that may be warped, and those from the first frame of S_H to the contact.
    free = paths.frames + (first - paths.entry) - (begin - actor.time)
    fixed = kick.frame - first
    target = _expected(actor, request)
    velocities, met = launcher.velocities(start, np.tile(target, (len(times), 1)), times)
    seconds = (times - start.time) / launcher.rate
    flight = flight_cost(
        start, velocities, met, seconds, request.bystanders, launcher.config.physics
    )
    return cheapest(paths, free, fixed, begin, times, flight)


def _ball_centre(
    actor: Actor, placement: Float[np.ndarray, "3"], kick: Kick
) -> Float[np.ndarray, "3"]:
    """Where the ball is at the contact if the hit's clip is placed so, m."""
    contacts = actor.moves.touch[kick.hit]
    row = int(np.flatnonzero(contacts.frames == kick.frame)[0])
    return np.asarray(planar.apply(placement, contacts.centres[row]))


def _expected(actor: Actor, request: Request) -> Float[np.ndarray, "3"]:
    """Where the ball is at the contact before it is known how the player gets there, m."""
    _, x, z = actor.stand
    return np.asarray(planar.apply(np.array([request.heading, x, z]), request.kick.centre))


def _shown(place: np.ndarray) -> str:
    return "(" + ", ".join(f"{x:.2f}" for x in place) + ")"


def possible_hits(config: SceneConfig, moves: Repertoire, number: int) -> list[int]:
    """Stored hits of the kind and bone that a pass asks for; the last touch is a toss.

    Raises:
        ConfigError: there is none.
    """
    last = number == len(config.passes)
    kind = "toss" if last else config.passes[number].kind
    bone = "any" if last else config.passes[number].bone
    clips = moves.clips
    hits = [
        hit
        for hit in moves.touch
        if kind in ("any", clips.hit_kind[hit]) and bone in ("any", clips.hit_bone[hit])
    ]
    if not hits:
        raise ConfigError(f"touch {number + 1}: got no stored {kind} by {bone}, expected one")
    return hits


def unasked_hits(config: SceneConfig, moves: Repertoire, number: int) -> list[int]:
    """Stored hits among which the scene itself chooses: attacks only where they are asked for."""
    hits = possible_hits(config, moves, number)
    if number < len(config.passes) and config.passes[number].kind == "any":
        kinds = moves.clips.hit_kind
        return [hit for hit in hits if kinds[hit] != "attack"] or hits
    return hits


def user_may_decide(config: SceneConfig, choose: Choose | None, number: int) -> bool:
    """Whether the user's motion may decide a touch: somebody is asked, and its kind is "any"."""
    passes = config.passes
    return choose is not None and number < len(passes) and passes[number].kind == "any"


def user_hit(
    config: SceneConfig,
    moves: Repertoire,
    choose: Choose | None,
    *,
    number: int,
    player: str,
    deadline_s: float,
) -> int | None:
    """The hit that the user's motion decides; None where the scene chooses itself.

    Raises:
        ConfigError: the answer is none of the hits that are possible.
    """
    if choose is None or not user_may_decide(config, choose, number):
        return None
    hits = possible_hits(config, moves, number)
    hit = choose(Asked(touch=number, player=player, deadline_s=deadline_s, hits=tuple(hits)))
    if hit is not None and hit not in hits:
        raise ConfigError(f"touch {number + 1}: got hit {hit}, expected one of {hits}")
    return hit
