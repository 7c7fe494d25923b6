"""The hit a touch is made with: which stored one, in which frame, and how far from its own ball."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.aiming.hit_frame import SCALES
from mgjax.ballsport.aiming.passes import aim_batch
from mgjax.ballsport.aiming.solve import OK
from mgjax.ballsport.aiming.timed import SIZE
from mgjax.ballsport.ball.physics import BallPhysics
from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.core import planar
from mgjax.core.xla.padding import bucket_size, pad_axis

_EXPECTED_S = 1.3
"""Flight time to stay near, s: about what a receiver needs to get ready."""
_TIME_WEIGHT = 20.0
"""What a second off that counts beside a m/s."""
_SLOW = 0.5
"""What a frame in which the bone stands still counts, beside one in which it is fastest and whose
ball is changed by as much as the bone's speed: a strong hit is not to be used for a short pass."""


@dataclass(frozen=True, kw_only=True)
class Kick:
    """A stored hit and the frame of S_B in which it meets the ball.

    Attributes:
        hit: number in the clip set.
        frame: on the axis of the clip set.
        centre: of the ball then, in the planar frame of the body at the first frame of S_H, m. [3]
        velocity: of the bone then, likewise, m/s. [3]
        aside: direction of that velocity over the floor, rad; 0 is straight ahead.
    """

    hit: int
    frame: int
    centre: Float[np.ndarray, "3"]
    velocity: Float[np.ndarray, "3"]
    aside: float


def kicks_of(moves: Repertoire, hit: int) -> list[Kick]:
    """The kicks of a hit in all frames of its S_B that can meet the ball."""
    touch = moves.touch[hit]
    back = np.asarray(planar.inverse(moves.clips.planes[moves.clips.hit_starts[hit]]), np.float64)
    turn = np.array([back[0], 0.0, 0.0])
    rows = touch.mask
    rows_of_contacts = zip(
        touch.frames[rows],
        np.asarray(planar.apply(back, touch.centres[rows])),
        np.asarray(planar.apply(turn, touch.velocities[rows])),
        strict=True,
    )
    return [
        Kick(hit=hit, frame=int(f), centre=c, velocity=v, aside=float(np.arctan2(v[0], v[2])))
        for f, c, v in rows_of_contacts
    ]


def choose_kick(
    moves: Repertoire,
    hits: Sequence[int],
    distance: float,
    *,
    height: float,
    bounces: int,
    physics: BallPhysics,
    max_speed: float,
) -> Kick:
    """The frame, of all of some hits, whose ball goes a distance over the floor with least change.

    The place is straight ahead of the kick, since the body can be turned. The change is that of
    :func:`kick_change`; where no frame meets the place, the one that comes nearest is taken.

    Deviation:
        :func:`mgjax.ballsport.aiming.hit_frame.choose_frame` takes the frame whose own ball ends
        nearest and adjusts it exactly, as the paper's Table 1 is read. Here the ball of every frame
        is adjusted, and the least adjustment counts: frames that cannot meet the place drop out by
        themselves, and frames of different hits can be compared.

    Args:
        moves: what can be done.
        hits: stored hits to choose from.
        distance: from the body to the place over the floor, m.
        height: of the place, m.
        bounces: wanted.
        physics: of the ball.
        max_speed: m/s.
    """
    kicks = [kick for hit in hits for kick in kicks_of(moves, hit)]
    centres = np.array([kick.centre for kick in kicks])
    bones = np.array([kick.velocity for kick in kicks])
    aside = np.array([kick.aside for kick in kicks])
    ahead = np.stack([np.sin(aside), 0 * aside, np.cos(aside)], axis=1)
    size = bucket_size(len(kicks), SIZE)
    starts, targets, guesses = (
        pad_axis(x.astype(np.float32), size)
        for x in (centres, distance * ahead + np.array([0.0, height, 0.0]), bones)
    )
    aims = aim_batch(
        starts,
        targets,
        bounces=bounces,
        guesses=guesses,
        physics=physics,
        max_speed=max_speed,
        flight_times=np.full(size, _EXPECTED_S, np.float32),
        time_weight=_TIME_WEIGHT,
    )
    balls = np.asarray(aims.velocity, np.float64)[: len(kicks)]
    change = kick_change(balls, bones)
    miss = np.where(aims.status == OK, 0.0, 1e3 + aims.miss)[: len(kicks)]
    peak = {hit: np.linalg.norm(moves.touch[hit].velocities, axis=1).max() for hit in hits}
    slow = 1 - np.linalg.norm(bones, axis=1) / np.array([peak[kick.hit] for kick in kicks])
    return kicks[int(np.argmin(change + _SLOW * slow + miss))]


def kick_change(
    balls: Float[np.ndarray, "N 3"], bones: Float[np.ndarray, "#N 3"]
) -> Float[np.ndarray, " N"]:
    """How far the ball's velocity is from the bone's times the best factor within ``SCALES``.

    As a share of the bone's speed, for each of N; one bone may serve all.
    """
    square = np.sum(bones * bones, axis=-1)
    factor = np.clip(np.sum(balls * bones, axis=-1) / square, *SCALES)
    return np.linalg.norm(balls - factor[:, None] * bones, axis=-1) / np.sqrt(square)
