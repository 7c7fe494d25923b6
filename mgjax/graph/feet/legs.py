"""The legs of a skeleton, as feet are kept with them."""

from __future__ import annotations

from dataclasses import dataclass

from mgjax.core.body.roles import require_roles
from mgjax.core.contacts import foot_joints
from mgjax.core.skeleton import Skeleton


@dataclass(frozen=True, kw_only=True)
class FootChains:
    """Hip, knee, ankle and the ball of the foot, of the left and the right leg."""

    hips: tuple[int, int]
    knees: tuple[int, int]
    ankles: tuple[int, int]
    balls: tuple[int, int]


def foot_chains(skeleton: Skeleton) -> FootChains:
    """The legs of a skeleton.

    Raises:
        SkeletonError: a joint of the legs is missing; it is named.
    """
    joints = require_roles(
        skeleton, [f"{s}_{j}" for j in ("hip", "knee", "ankle") for s in ("left", "right")]
    )
    return FootChains(
        hips=(joints[0], joints[1]),
        knees=(joints[2], joints[3]),
        ankles=(joints[4], joints[5]),
        balls=foot_joints(skeleton),
    )
