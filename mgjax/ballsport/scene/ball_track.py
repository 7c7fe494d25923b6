"""The ball over the whole scene: where it is in every frame, and what happens to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.aiming.solve import OK
from mgjax.ballsport.ball.physics import BallPhysics
from mgjax.ballsport.ball.trajectory import contact_times, fly
from mgjax.ballsport.scene.types import THROWN, Leg
from mgjax.core.xla.padding import bucket_size, pad_axis

_LEAST = 256
"""Times per call of the flight; more are padded to twice as many."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Event:
    """Something that happens to the ball.

    Attributes:
        time: s.
        place: of the ball's centre, m. [3]
        what: throw, hit, bounce or miss.
        who: the player who throws at nobody, hits or is missed; "" for the ground.
        leg: number of the leg in the scene.
    """

    time: float
    place: Float[np.ndarray, "3"]
    what: str
    who: str
    leg: int


@dataclass(frozen=True, kw_only=True, eq=False)
class BallTrack:
    """The ball's centre in all frames, and its events in order of time.

    Attributes:
        places: m. [F, 3]
        leg: number of the leg of each frame, the one that begins where two meet. [F]
        arrivals: where the ball is at the end of each leg, m. [L, 3]
        events: throws, hits, bounces, misses.
    """

    places: Float[np.ndarray, "F 3"]
    leg: np.ndarray
    arrivals: Float[np.ndarray, "L 3"]
    events: tuple[Event, ...]


def track(
    legs: Sequence[Leg], players: Sequence[tuple[str, str]], rate: float, physics: BallPhysics
) -> BallTrack:
    """Flies all legs one after the other.

    After a pass that could not be, the ball goes on to fly until the next is thrown in; before the
    first throw it is where it is thrown from.

    Args:
        legs: in order.
        players: by whom and to whom each leg goes, "" for nobody.
        rate: frames per second.
        physics: of the ball.
    """
    frames = legs[-1].stop + 1
    places = np.tile(legs[0].place, (frames, 1))
    number = np.zeros(frames, np.int64)
    arrivals: list[np.ndarray] = []
    events: list[Event] = []
    for n, leg in enumerate(legs):
        until = legs[n + 1].start if n + 1 < len(legs) else frames
        begin = leg.start / rate
        bounces = np.asarray(
            contact_times(
                leg.place.astype(np.float32), leg.velocity.astype(np.float32), physics=physics
            )
        )
        times = np.arange(until - leg.start + 1) / rate
        bounces = bounces[(bounces > 1e-6) & (bounces < times[-1] - 1e-5)]
        flown = _flown(
            leg, np.concatenate([times, bounces, [(leg.stop - leg.start) / rate]]), physics
        )
        places[leg.start : until] = flown[: until - leg.start]
        number[leg.start : until] = n
        arrivals.append(flown[-1])
        by, to = players[n]
        what = "throw" if leg.number == THROWN else "hit"
        events.append(Event(time=begin, place=leg.place, what=what, who=by, leg=n))
        more = [
            Event(time=begin + float(t), place=p, what="bounce", who="", leg=n)
            for t, p in zip(bounces, flown[len(times) : -1], strict=True)
        ]
        if leg.status != OK:
            time = leg.stop / rate
            more.append(Event(time=time, place=flown[-1], what="miss", who=to, leg=n))
        events += sorted(more, key=lambda event: event.time)
    return BallTrack(places=places, leg=number, arrivals=np.array(arrivals), events=tuple(events))


def _flown(leg: Leg, times: np.ndarray, physics: BallPhysics) -> np.ndarray:
    """Places at some times after the start of a leg; the start itself is exact."""
    padded = pad_axis(times.astype(np.float32), bucket_size(len(times), _LEAST))
    place, velocity = leg.place.astype(np.float32), leg.velocity.astype(np.float32)
    flown = np.asarray(fly(place, velocity, padded, physics=physics), np.float64)[: len(times)]
    return np.where(times[:, None] == 0, leg.place, flown)


def csv_text(ball: BallTrack, rate: float) -> str:
    """``t,x,y,z,event``: a row for each frame and one for each event between frames, by time.

    Events are ``throw``, ``hit NAME``, ``bounce`` and ``miss NAME``; those on a frame stand in its
    row.
    """
    rows = {round(f / rate, 6): (*place, "") for f, place in enumerate(ball.places.tolist())}
    for event in ball.events:
        time, name = round(event.time, 6), f"{event.what} {event.who}".strip()
        rows[time] = (*event.place.tolist(), name)
    lines = ["t,x,y,z,event"]
    for time, (x, y, z, name) in sorted(rows.items()):
        lines.append(f"{time:.6f},{x:.6f},{y:.6f},{z:.6f},{name}")
    return "\n".join(lines) + "\n"
