"""What a hit is compared by: how the bone travels between the key poses, how long, how fast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from mgjax.ballsport.config import AnalysisConfig
from mgjax.ballsport.hits.detect import Hit
from mgjax.ballsport.hits.smoothing import smooth
from mgjax.core import planar
from mgjax.core.arrays import Array
from mgjax.core.body.roles import require_roles
from mgjax.core.errors import SkeletonError
from mgjax.core.kinematics import joint_velocities
from mgjax.core.skeleton import Skeleton, rest_positions
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True)
class MotionVectors:
    """Motion vectors of one hit, or of many with leading axes.

    Attributes:
        displacements: of the hit bone from key pose to key pose, in the character's planar frame
            at the first, m.
        seconds: how long each takes, s.
        v_max: largest speed of the hit bone in S_H, m/s.
    """

    displacements: Float[Array, "*b 4 3"]
    seconds: Float[Array, "*b 4"]
    v_max: Float[Array, "*b"]


def motion_vector(
    hit: Hit,
    positions: Float[np.ndarray, "F 3"],
    heading: float,
    frame_rate: float,
    config: AnalysisConfig | None = None,
) -> MotionVectors:
    """The motion vector of one hit (Fig. 3).

    Args:
        hit: from the analysis of ``positions``.
        positions: of the hit bone, m.
        heading: of the character at the first key pose, the angle of its planar frame, rad.
        frame_rate: frames per second.
        config: the one of the analysis; its smoothing is applied here too.
    """
    places = smooth(
        np.asarray(positions, np.float64), frame_rate, (config or AnalysisConfig()).smoothing_s
    )
    keys = np.array(hit.key_frames)
    turn = np.array([-heading, 0.0, 0.0])
    speed = np.linalg.norm(joint_velocities(places[:, None], frame_rate)[:, 0], axis=-1)
    return MotionVectors(
        displacements=np.asarray(planar.apply(turn, np.diff(places[keys], axis=0)), np.float32),
        seconds=(np.diff(keys) / frame_rate).astype(np.float32),
        v_max=np.asarray(speed[hit.start : hit.stop].max(), np.float32),
    )


def stack(vectors: Sequence[MotionVectors]) -> MotionVectors:
    """Motion vectors of many hits from those of each."""
    return MotionVectors(
        displacements=np.array([v.displacements for v in vectors], np.float32).reshape(-1, 4, 3),
        seconds=np.array([v.seconds for v in vectors], np.float32).reshape(-1, 4),
        v_max=np.array([v.v_max for v in vectors], np.float32).reshape(-1),
    )


def scaled(vectors: MotionVectors, ratio: float) -> MotionVectors:
    """The vectors of a body whose legs are ``ratio`` times as long and that takes as much time."""
    return replace(
        vectors,
        displacements=vectors.displacements * np.float32(ratio),
        v_max=vectors.v_max * np.float32(ratio),
    )


def leg_length(skeleton: Skeleton) -> float:
    """From the left hip over the knee to the ankle, m."""
    hip, knee, ankle = require_roles(skeleton, ("left_hip", "left_knee", "left_ankle"))
    places = rest_positions(skeleton)
    length = float(
        np.linalg.norm(places[knee] - places[hip]) + np.linalg.norm(places[ankle] - places[knee])
    )
    if length < 1e-3:
        raise SkeletonError(f"got legs of {length:g} m, expected a body with legs")
    return length
