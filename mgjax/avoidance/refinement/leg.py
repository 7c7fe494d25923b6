"""A leg whose foot stays in place while its hip moves, as far as changing a motion asks of it."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.avoidance.refinement.rig import Rig, outside
from mgjax.core import quaternion, two_bone
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

HIP, TURN, TARGET = slice(0, 3), slice(3, 6), slice(6, 9)
"""What a leg is told: how its hip moves, m, how the pelvis turns with it, a rotation vector in the
world, and how its ankle is to move, m. [9]"""


@register()
@dataclass(frozen=True, kw_only=True)
class Bones:
    """The legs of a body at one moment, after the trunk has turned and before they follow.

    Attributes:
        hip, knee, ankle: places, m. [L, 3]
        parent, thigh, shin: world rotations of the hip's parent, hip and knee. [L, 4]
        before: world rotation of the shin in the unchanged pose. [L, 4]
        target: where the ankle is to be, m. [L, 3]
    """

    hip: Float[Array, "*b L 3"]
    knee: Float[Array, "*b L 3"]
    ankle: Float[Array, "*b L 3"]
    parent: Float[Array, "*b L 4"]
    thigh: Float[Array, "*b L 4"]
    shin: Float[Array, "*b L 4"]
    before: Float[Array, "*b L 4"]
    target: Float[Array, "*b L 3"]


@register()
@dataclass(frozen=True, kw_only=True)
class Followed:
    """What a leg does when it follows.

    Attributes:
        knee: its place, m. [3]
        turns: of hip, knee and ankle in their parents' frames, rad. [3]
        outside: by how much hip and knee are outside the captured range, rad. [2]
        missed: how far the ankle is from where it is to be, m. []
    """

    knee: Float[Array, "*b 3"]
    turns: Float[Array, "*b 3"]
    outside: Float[Array, "*b 2"]
    missed: Float[Array, "*b"]


def follow(rig: Rig, bones: Bones, told: Float[Array, "*b L 9"]) -> Followed:
    """Legs that keep their feet where they are to be; see :mod:`mgjax.core.two_bone`."""
    turn = quaternion.exp(told[..., TURN])
    hip = bones.hip + told[..., HIP]
    thigh = quaternion.rotate(turn, bones.knee - bones.hip)
    shin = quaternion.rotate(turn, bones.ankle - bones.knee)
    target = bones.target + told[..., TARGET]
    shin_turn = quaternion.multiply(turn, bones.shin)
    ahead = jnp.broadcast_to(jnp.array([0.0, 0.0, 1.0], dtype=hip.dtype), hip.shape)
    pole = quaternion.rotate(shin_turn, ahead)
    hip_turn, knee_turn = two_bone.solve(hip, hip + thigh, hip + thigh + shin, target, pole)
    both = quaternion.multiply(hip_turn, knee_turn)
    knee = hip + quaternion.rotate(hip_turn, thigh)
    ankle = knee + quaternion.rotate(both, shin)
    parent = quaternion.multiply(turn, bones.parent)
    thigh_turn = quaternion.multiply(turn, bones.thigh)
    hip_local = _local(parent, quaternion.multiply(hip_turn, thigh_turn))
    # Joints between hip and knee turn with the thigh.
    knee_local = _local(thigh_turn, quaternion.multiply(knee_turn, shin_turn))
    still = jnp.zeros_like(both).at[..., 0].set(1.0)
    foot = quaternion.multiply(both, quaternion.multiply(shin_turn, _back(bones.before)))
    turns = [quaternion.angle_between(still, x) for x in (hip_turn, knee_turn, foot)]
    legs = [
        row for leg in rig.legs for row in (rig.limited.index(leg[0]), rig.limited.index(leg[1]))
    ]
    limits = jax.tree.map(lambda x: jnp.asarray(x)[np.array(legs, dtype=np.int64)], rig.limits)
    pairs = jnp.stack([hip_local, knee_local], axis=-2)
    flat = outside(pairs.reshape(*pairs.shape[:-3], -1, 4), limits)
    gap = ankle - target
    return Followed(
        knee=knee,
        turns=jnp.stack(turns, axis=-1),
        outside=flat.reshape(*flat.shape[:-1], -1, 2),
        missed=jnp.sqrt(jnp.sum(gap * gap, axis=-1) + 1e-12),
    )


def _back(q: Array) -> Array:
    return quaternion.conjugate(q)


def _local(parent: Array, joint: Array) -> Array:
    return quaternion.multiply(_back(parent), joint)
