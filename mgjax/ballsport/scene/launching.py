"""Flights of the ball as a rally launches them: to a place and time, past it, or to nobody."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from mgjax.ballsport.aiming.passes import aim
from mgjax.ballsport.aiming.solve import OK
from mgjax.ballsport.aiming.timed import aim_timed
from mgjax.ballsport.ball.trajectory import fly
from mgjax.ballsport.scene.config import SceneConfig
from mgjax.ballsport.scene.types import THROWN_IN, BallFlight, BallStart, Touch

_THROW_HEIGHT_M = 1.3
"""Height of a throw for which no place is given."""
_THROW_UP_M_S = 2.0
"""Upward velocity of the first guess of a throw."""


@dataclass(frozen=True, kw_only=True)
class Launcher:
    """Launches balls in one scene.

    Attributes:
        config: its physics, net and largest speed.
        rate: scene frames per second.
        middle: between the players, m. [3]
    """

    config: SceneConfig
    rate: float
    middle: Float[np.ndarray, "3"]

    def throw_in(self, time: int) -> BallStart:
        """A ball that is thrown in at a scene frame."""
        place = self.config.throw_in
        over = self.middle + np.array([0.0, _THROW_HEIGHT_M, 0.0])
        over = over if place is None else np.array(place, np.float64)
        return BallStart(number=THROWN_IN, time=time, place=over, bone=None, bounces=0)

    def velocities(
        self,
        start: BallStart,
        targets: Float[np.ndarray, "N 3"],
        times: Int[np.ndarray, " N"],
    ) -> tuple[Float[np.ndarray, "N 3"], Bool[np.ndarray, " N"]]:
        """Velocities that bring the ball to each target at each scene frame, and which of them do.

        See :func:`mgjax.ballsport.aiming.timed.aim_timed`.
        """
        guess = start.bone
        if guess is None:
            guess = (targets[0] - start.place) + np.array([0.0, _THROW_UP_M_S, 0.0])
        return aim_timed(
            np.tile(start.place, (len(times), 1)),
            targets,
            (times - start.time) / self.rate,
            bounces=start.bounces,
            guesses=np.tile(guess, (len(times), 1)),
            physics=self.config.physics,
            max_speed=self.config.max_speed,
            net=self.config.net,
        )

    def nearest(self, start: BallStart, target: Float[np.ndarray, "3"]) -> BallFlight:
        """The flight of a pass that cannot be: it goes as near to its target as it can."""
        assert start.bone is not None
        nearest = aim(
            start.place.astype(np.float32),
            target.astype(np.float32),
            bounces=start.bounces,
            guess=start.bone.astype(np.float32),
            physics=self.config.physics,
            max_speed=self.config.max_speed,
            net=self.config.net,
        )
        return make_flight(
            start,
            stop=start.time + max(1, round(float(nearest.time) * self.rate)),
            velocity=np.asarray(nearest.velocity),
            target=target,
            status=int(nearest.status),
            miss=float(nearest.miss),
        )

    def last(self, touch: Touch) -> BallFlight:
        """The flight after the last touch, to nobody: the ball goes as the bone sends it."""
        stop = touch.time + round(self.config.end_s * self.rate)
        time = np.array([(stop - touch.time) / self.rate], np.float32)
        flown = fly(
            touch.centre.astype(np.float32),
            touch.bone.astype(np.float32),
            time,
            physics=self.config.physics,
        )
        start = BallStart(
            number=touch.number, time=touch.time, place=touch.centre, bone=touch.bone, bounces=0
        )
        target = np.asarray(flown, np.float64)[0]
        return make_flight(start, stop=stop, velocity=touch.bone, target=target)


def make_flight(
    start: BallStart,
    *,
    stop: int,
    velocity: Float[np.ndarray, "3"],
    target: Float[np.ndarray, "3"],
    status: int = OK,
    miss: float = 0.0,
) -> BallFlight:
    """The flight that begins so; by default one that meets its target."""
    return BallFlight(
        number=start.number,
        start=start.time,
        stop=stop,
        place=start.place,
        velocity=velocity.astype(np.float64),
        target=target,
        bounces=start.bounces,
        status=status,
        miss=miss,
    )
