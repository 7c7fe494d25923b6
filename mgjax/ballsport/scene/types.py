"""What a rally is made of: touches, and the flights of the ball between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.scene.kick import Kick

THROWN_IN = -1
"""Number of a flight that is no pass: the ball is thrown in."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What is asked of whoever decides the hits.

    Attributes:
        touch: number of the touch, from 0.
        player: who hits.
        deadline_s: when the ball is launched towards that player, scene time.
        hits: stored hits that are possible.
    """

    touch: int
    player: str
    deadline_s: float
    hits: tuple[int, ...]


Choose = Callable[[Asked], int | None]
"""Returns the stored hit of a touch, or None where the scene's own choice shall stand."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Touch:
    """A hit on the scene's time axis.

    Attributes:
        number: from 0.
        player: who hits.
        kick: the stored hit and its frame.
        time: scene frame of the contact.
        centre: of the ball then, m. [3]
        bone: velocity of the hit bone then, m/s. [3]
        warp: how many times faster the link motion before it was played.
        cost: D_p of a frame in the sections before it, summed, m.
        by_user: whether the user's motion decided the hit.
    """

    number: int
    player: str
    kick: Kick
    time: int
    centre: Float[np.ndarray, "3"]
    bone: Float[np.ndarray, "3"]
    warp: float
    cost: float
    by_user: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class BallStart:
    """Where and when a flight of the ball begins.

    Attributes:
        number: of the pass from 0, or ``THROWN_IN``.
        time: scene frame.
        place: of the ball's centre, m. [3]
        bone: velocity of the bone that hits it, m/s; None for a throw. [3]
        bounces: wanted before the next touch.
    """

    number: int
    time: int
    place: Float[np.ndarray, "3"]
    bone: Float[np.ndarray, "3"] | None
    bounces: int


@dataclass(frozen=True, kw_only=True, eq=False)
class BallFlight:
    """The ball between two touches.

    Attributes:
        number: of the pass from 0, or ``THROWN_IN``; the last touch begins one more that is no
            pass.
        start, stop: scene frames.
        place, velocity: of the ball at the start, m, m/s. [3]
        target: where it shall be at the stop, m. [3]
        bounces: wanted.
        status: of the aim.
        miss: of the aim, m.
    """

    number: int
    start: int
    stop: int
    place: Float[np.ndarray, "3"]
    velocity: Float[np.ndarray, "3"]
    target: Float[np.ndarray, "3"]
    bounces: int
    status: int
    miss: float
