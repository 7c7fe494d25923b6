"""When a foot is planted, and how far it travels over the floor."""

from __future__ import annotations

from jaxtyping import Bool, Float

from mgjax.core.arrays import Array, namespace
from mgjax.core.body.roles import find_role, require_roles
from mgjax.core.kinematics import joint_velocities
from mgjax.core.skeleton import Skeleton

PLANT_HEIGHT_M = 0.05
PLANT_SPEED_M_S = 0.2
"""A point of an adult's foot that is lower and slower than this stands."""


def foot_joints(skeleton: Skeleton) -> tuple[int, int]:
    """The joints that are tested and kept in place: the balls of the left and right foot.

    Where a foot has no toe joint, the end of the foot; where it has no end, the ankle.
    """
    joints: list[int] = []
    for side in ("left", "right"):
        toe = find_role(skeleton, f"{side}_toe")
        if toe is None:
            (toe,) = require_roles(skeleton, (f"{side}_ankle",))
            toe = next((j for j in skeleton.end_joints if skeleton.parents[j] == toe), toe)
        joints.append(toe)
    return joints[0], joints[1]


def planted(
    positions: Float[Array, "F K 3"],
    frame_rate: float,
    *,
    height: float = PLANT_HEIGHT_M,
    speed: float = PLANT_SPEED_M_S,
    scale: float = 1.0,
) -> Bool[Array, "F K"]:
    """Which points stand on the floor (y = 0): those that are low and slow.

    Args:
        positions: of points of the feet, m.
        frame_rate: frames per second.
        height, speed: below which an adult's stand, m and m/s.
        scale: of the body; see :func:`mgjax.core.body.height.body_scale`.
    """
    xp = namespace(positions)
    height, speed = scale * height, scale * speed
    velocity = joint_velocities(positions, frame_rate)
    return (positions[..., 1] < height) & (xp.sum(velocity**2, axis=-1) < speed**2)


def stays_planted(plants: Bool[Array, "*f"]) -> Bool[Array, "*g"]:
    """Between which frames a foot should stand still: it is planted in both. [F − 1, …]"""
    return plants[1:] & plants[:-1]


def floor_steps(positions: Float[Array, "*f 3"], *, softening: float = 0.0) -> Float[Array, "*g"]:
    """Metres that points travel over the floor from each frame to the next. [F − 1, …]

    Args:
        positions: m.
        softening: m², added under the root; above 0 the slope is finite for points at rest.
    """
    step = positions[1:, ..., ::2] - positions[:-1, ..., ::2]
    square = namespace(positions).sum(step * step, axis=-1)
    return namespace(positions).sqrt(square + softening if softening else square)
