"""The ball over the whole scene: where it is in every frame, and what happens to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.aiming.solve import OK
from mgjax.ballsport.ball.physics import BallPhysics
from mgjax.ballsport.ball.trajectory import contact_times, fly
from mgjax.ballsport.scene.types import THROWN_IN, BallFlight
from mgjax.core.xla.padding import bucket_size, pad_axis

_LEAST = 256
"""Times per call of the flight; more are padded to twice as many."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BallEvent:
    """Something that happens to the ball.

    Attributes:
        time: s.
        place: of the ball's centre, m. [3]
        what: throw, hit, bounce or miss.
        who: the player who throws at nobody, hits or is missed; "" for the ground.
        flight: number of the flight in the scene.
    """

    time: float
    place: Float[np.ndarray, "3"]
    what: str
    who: str
    flight: int


@dataclass(frozen=True, kw_only=True, eq=False)
class BallTrack:
    """The ball's centre in all frames, and its events in order of time.

    Attributes:
        places: m. [F, 3]
        flight: number of the flight of each frame, the one that begins where two meet. [F]
        arrivals: where the ball is at the end of each flight, m. [L, 3]
        events: throws, hits, bounces, misses.
    """

    places: Float[np.ndarray, "F 3"]
    flight: np.ndarray
    arrivals: Float[np.ndarray, "L 3"]
    events: tuple[BallEvent, ...]


def track_ball(
    flights: Sequence[BallFlight],
    players: Sequence[tuple[str, str]],
    rate: float,
    physics: BallPhysics,
) -> BallTrack:
    """Flies all flights one after the other.

    After a pass that could not be, the ball goes on to fly until the next is thrown in; before the
    first throw it is where it is thrown from.

    Args:
        flights: in order.
        players: by whom and to whom each flight goes, "" for nobody.
        rate: frames per second.
        physics: of the ball.
    """
    frames = flights[-1].stop + 1
    places = np.tile(flights[0].place, (frames, 1))
    number = np.zeros(frames, np.int64)
    arrivals: list[np.ndarray] = []
    events: list[BallEvent] = []
    for n, flight in enumerate(flights):
        until = flights[n + 1].start if n + 1 < len(flights) else frames
        begin = flight.start / rate
        bounces = np.asarray(
            contact_times(
                flight.place.astype(np.float32), flight.velocity.astype(np.float32), physics=physics
            )
        )
        times = np.arange(until - flight.start + 1) / rate
        bounces = bounces[(bounces > 1e-6) & (bounces < times[-1] - 1e-5)]
        flown = _flown(
            flight, np.concatenate([times, bounces, [(flight.stop - flight.start) / rate]]), physics
        )
        places[flight.start : until] = flown[: until - flight.start]
        number[flight.start : until] = n
        arrivals.append(flown[-1])
        by, to = players[n]
        what = "throw" if flight.number == THROWN_IN else "hit"
        events.append(BallEvent(time=begin, place=flight.place, what=what, who=by, flight=n))
        more = [
            BallEvent(time=begin + float(t), place=p, what="bounce", who="", flight=n)
            for t, p in zip(bounces, flown[len(times) : -1], strict=True)
        ]
        if flight.status != OK:
            time = flight.stop / rate
            more.append(BallEvent(time=time, place=flown[-1], what="miss", who=to, flight=n))
        events += sorted(more, key=lambda event: event.time)
    return BallTrack(
        places=places, flight=number, arrivals=np.array(arrivals), events=tuple(events)
    )


def _flown(flight: BallFlight, times: np.ndarray, physics: BallPhysics) -> np.ndarray:
    """Places at some times after the start of a flight; the start itself is exact."""
    padded = pad_axis(times.astype(np.float32), bucket_size(len(times), _LEAST))
    place, velocity = flight.place.astype(np.float32), flight.velocity.astype(np.float32)
    flown = np.asarray(fly(place, velocity, padded, physics=physics), np.float64)[: len(times)]
    return np.where(times[:, None] == 0, flight.place, flown)


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
