"""Where the ball is while it touches the bone that hits it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.config import hit_bone
from mgjax.core import planar

SLOWEST = 0.35
"""Share of the largest speed in S_B below which a frame does not hit: the bone has no direction."""

AHEAD_M = 0.05
"""Least distance of the ball's centre ahead of the body's middle, m."""

SPARE_M = 0.005
"""Least height of the ball over its rest height while it is hit, m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Contacts:
    """The frames in which a hit can meet the ball, in the coordinates of the hit's clip.

    Attributes:
        frames: on the axis of the clip set. [F]
        centres: of the ball, m. [F, 3]
        velocities: of the bone, m/s. [F, 3]
        mask: frames in which the bone is fast enough and does not come down, and the ball is ahead
            of the body. [F]
    """

    frames: np.ndarray
    centres: Float[np.ndarray, "F 3"]
    velocities: Float[np.ndarray, "F 3"]
    mask: Bool[np.ndarray, " F"]


def contacts(clips: ClipSet, hit: int, ball_radius: float) -> Contacts:
    """Where the ball's centre is if hit in each frame of S_B: ahead of the bone, surfaces touching.

    Ahead is where the bone moves to, since a ball without spin leaves along the normal. Near the
    ground the normal is raised until the ball is clear of it.
    """
    path, velocity = clips.bone_path(hit)
    path, velocity = np.asarray(path, np.float64), np.asarray(velocity, np.float64)
    speed = np.linalg.norm(velocity, axis=1)
    reach = ball_radius + hit_bone(clips.hit_bone[hit]).radius_m
    normal = velocity / np.maximum(speed, 1e-9)[:, None]
    # sin of the elevation that keeps the ball off the ground; a bone below it cannot hit.
    lowest = (ball_radius + SPARE_M - path[:, 1]) / reach
    mask = (speed >= SLOWEST * speed.max()) & (lowest < 1)
    up = np.clip(np.maximum(normal[:, 1], lowest), -1, 1)
    flat = np.hypot(normal[:, 0], normal[:, 2])
    mask &= flat > 1e-6
    share = np.sqrt(1 - up**2) / np.maximum(flat, 1e-9)
    normal = np.stack([normal[:, 0] * share, up, normal[:, 2] * share], axis=1)
    frames = np.arange(int(clips.ball_starts[hit]), int(clips.ball_stops[hit]))
    centres = path + reach * normal
    back = np.asarray(planar.inverse(clips.planes[frames].astype(np.float64)))
    mask &= np.asarray(planar.apply(back, centres))[:, 2] >= AHEAD_M
    mask &= velocity[:, 1] >= 0  # what comes down drives the ball into the ground
    return Contacts(
        frames=frames,
        centres=centres,
        velocities=velocity,
        mask=mask,
    )
