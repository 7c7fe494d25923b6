"""Inverse kinematics of an arm that meets something: shoulder, elbow, and how the elbow lies."""

from __future__ import annotations

from dataclasses import dataclass

from jaxtyping import Float

from mgjax.core import quaternion, two_bone
from mgjax.core.arrays import Array, namespace
from mgjax.core.xla.pytree import register


@register()
@dataclass(frozen=True, kw_only=True)
class ArmPose:
    """An arm at one moment, in the world.

    Attributes:
        shoulder, elbow, wrist, tip: places, m. [3]
        shoulder_turn, elbow_turn: rotations of these joints. [4]
    """

    shoulder: Float[Array, "*b 3"]
    elbow: Float[Array, "*b 3"]
    wrist: Float[Array, "*b 3"]
    tip: Float[Array, "*b 3"]
    shoulder_turn: Float[Array, "*b 4"]
    elbow_turn: Float[Array, "*b 4"]


def meet(
    arm: ArmPose,
    point: Float[Array, "*b 3"],
    target: Float[Array, "*b 3"],
    swivel: Float[Array, "*b"],
) -> tuple[Float[Array, "*b 2 3"], Float[Array, "*b"]]:
    """How shoulder and elbow turn so that a point of the forearm or hand comes to a place.

    Two-bone inverse kinematics (:mod:`mgjax.core.two_bone`) with the point as the end: the elbow
    bends in the plane in which it is bent, so it never flips. The arm is then turned about the line
    from the shoulder to the target, which moves the elbow alone. The wrist keeps its rotation.

    Args:
        arm: the arm.
        point: fixed to the forearm, m.
        target: where it is to be, m.
        swivel: angle of the last turn, rad.

    Returns:
        Rotation vectors of shoulder and elbow in their own frames, rad, and how far the point stays
        from the target, m.
    """
    xp = namespace(arm.shoulder, target)
    behind = xp.zeros_like(target) - xp.stack(
        [xp.zeros_like(swivel), xp.zeros_like(swivel), xp.ones_like(swivel)], axis=-1
    )
    pole = quaternion.rotate(arm.elbow_turn, behind)
    upper, lower = two_bone.solve(arm.shoulder, arm.elbow, point, target, pole)
    line = target - arm.shoulder
    length = xp.sqrt(xp.maximum(xp.sum(line * line, axis=-1, keepdims=True), 1e-12))
    upper = quaternion.multiply(quaternion.from_axis_angle(line / length, swivel), upper)
    vectors = xp.stack(
        [
            quaternion.rotate(quaternion.conjugate(arm.shoulder_turn), quaternion.log(upper)),
            quaternion.rotate(quaternion.conjugate(arm.elbow_turn), quaternion.log(lower)),
        ],
        axis=-2,
    )
    gap = end_of(arm, upper, lower, point) - target
    return vectors, xp.sqrt(xp.sum(gap * gap, axis=-1))


def turned(arm: ArmPose, vectors: Float[Array, "*b 2 3"]) -> ArmPose:
    """The arm with shoulder and elbow turned by rotation vectors in their own frames, rad."""
    first, second = (quaternion.exp(vectors[..., k, :]) for k in range(2))
    upper = _in_world(arm.shoulder_turn, first)
    lower = _in_world(arm.elbow_turn, second)
    both = quaternion.multiply(upper, lower)
    return ArmPose(
        shoulder=arm.shoulder,
        elbow=arm.shoulder + quaternion.rotate(upper, arm.elbow - arm.shoulder),
        wrist=end_of(arm, upper, lower, arm.wrist),
        tip=end_of(arm, upper, lower, arm.tip),
        shoulder_turn=quaternion.multiply(upper, arm.shoulder_turn),
        elbow_turn=quaternion.multiply(both, arm.elbow_turn),
    )


def end_of(
    arm: ArmPose,
    upper: Float[Array, "*b 4"],
    lower: Float[Array, "*b 4"],
    point: Float[Array, "*b 3"],
) -> Float[Array, "*b 3"]:
    """Where a point of the forearm comes to by turns of the world: of the elbow, then of both."""
    elbow = arm.shoulder + quaternion.rotate(upper, arm.elbow - arm.shoulder)
    both = quaternion.multiply(upper, lower)
    return elbow + quaternion.rotate(both, point - arm.elbow)


def _in_world(world: Float[Array, "*b 4"], turn: Float[Array, "*b 4"]) -> Float[Array, "*b 4"]:
    """A turn in a joint's own frame, as one of the world."""
    return quaternion.multiply(quaternion.multiply(world, turn), quaternion.conjugate(world))
