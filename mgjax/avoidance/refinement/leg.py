"""A leg whose foot stays in place while its hip moves, as far as changing a motion asks of it."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jaxtyping import Float

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
        shin, before: world rotations of the shin, and in the unchanged pose. [L, 4]
        target: where the ankle is to be, m. [L, 3]
        ahead: where the knee points if the leg is straight. [L, 3]
    """

    hip: Float[Array, "*b L 3"]
    knee: Float[Array, "*b L 3"]
    ankle: Float[Array, "*b L 3"]
    shin: Float[Array, "*b L 4"]
    before: Float[Array, "*b L 4"]
    target: Float[Array, "*b L 3"]
    ahead: Float[Array, "*b L 3"]


@register()
@dataclass(frozen=True, kw_only=True)
class Followed:
    """What a leg does when it follows.

    Attributes:
        knee: its place, m. [3]
        turns: of hip, knee and ankle in their parents' frames, rad. [3]
        missed: how far the ankle is from where it is to be, m. []
    """

    knee: Float[Array, "*b 3"]
    turns: Float[Array, "*b 3"]
    missed: Float[Array, "*b"]


def follow(bones: Bones, told: Float[Array, "*b L 9"]) -> Followed:
    """Legs that keep their feet where they are to be; see :mod:`mgjax.core.two_bone`."""
    turn = quaternion.exp(told[..., TURN])
    hip = bones.hip + told[..., HIP]
    thigh = quaternion.rotate(turn, bones.knee - bones.hip)
    shin = quaternion.rotate(turn, bones.ankle - bones.knee)
    target = bones.target + told[..., TARGET]
    pole = quaternion.rotate(turn, bones.ahead)
    hip_turn, knee_turn = two_bone.solve(hip, hip + thigh, hip + thigh + shin, target, pole)
    both = quaternion.multiply(hip_turn, knee_turn)
    knee = hip + quaternion.rotate(hip_turn, thigh)
    ankle = knee + quaternion.rotate(both, shin)
    foot = quaternion.multiply(
        both, quaternion.multiply(turn, quaternion.multiply(bones.shin, _back(bones.before)))
    )
    turns = jnp.stack([hip_turn, knee_turn, foot], axis=-2)
    sine = jnp.sqrt(jnp.sum(turns[..., 1:] ** 2, axis=-1) + 1e-10)
    gap = ankle - target
    return Followed(
        knee=knee,
        turns=2 * jnp.arctan2(sine, jnp.abs(turns[..., 0])),
        missed=jnp.sqrt(jnp.sum(gap * gap, axis=-1) + 1e-12),
    )


def _back(q: Array) -> Array:
    return quaternion.conjugate(q)
