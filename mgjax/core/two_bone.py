"""Two-bone inverse kinematics: a hip and a knee (shoulder, elbow) that put an ankle in place."""

from __future__ import annotations

from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.arrays import Array, namespace

_REACH = 0.9995
"""Share of the full length that is used at most: a straight leg has no defined knee direction."""


def solve(
    hip: Float[Array, "*b 3"],
    knee: Float[Array, "*b 3"],
    ankle: Float[Array, "*b 3"],
    target: Float[Array, "*b 3"],
    pole: Float[Array, "*b 3"],
) -> tuple[Float[Array, "*b 4"], Float[Array, "*b 4"]]:
    """World rotations to apply to the hip and then to the knee so that the ankle meets ``target``.

    The knee bends in the plane of the leg; where the leg is straight, in the plane spanned by the
    leg and ``pole`` (the direction in which the knee points). A target out of reach is
    approached as far as the bones allow. Finite, with finite gradients, for straight legs and for
    a target on the hip.

    Args:
        hip, knee, ankle: present joint positions, m.
        target: wanted ankle position, m.
        pole: direction towards which the knee points, need not be a unit vector.

    Returns:
        ``(hip_turn, knee_turn)``: the new world rotation of the thigh is ``hip_turn · old``, that
        of the shin is ``hip_turn · knee_turn · old``.
    """
    xp = namespace(hip, knee, ankle, target, pole)

    def norm(v: Array) -> Array:
        return xp.sqrt(xp.maximum(xp.sum(v * v, axis=-1), 1e-14))

    def dot(a: Array, b: Array) -> Array:
        return xp.sum(a * b, axis=-1)

    def cross(a: Array, b: Array) -> Array:
        ax, ay, az = (a[..., i] for i in range(3))
        bx, by, bz = (b[..., i] for i in range(3))
        return xp.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)

    thigh, shin = knee - hip, ankle - knee
    a, b = norm(thigh), norm(shin)
    reach = xp.clip(norm(target - hip), xp.abs(a - b) * 1.001 + 1e-4, (a + b) * _REACH)

    # Angle between the bones at the knee: now, and as the target's distance needs it.
    normal = cross(thigh, shin)
    now = xp.arctan2(norm(normal), -dot(thigh, shin))
    cosine = (a * a + b * b - reach * reach) / (2 * a * b)
    wanted = xp.arccos(xp.clip(cosine, -1 + 1e-6, 1 - 1e-6))
    straight = dot(normal, normal) < (1e-4 * a * b) ** 2
    ahead = cross(pole, thigh)
    # A pole along the leg (or none) says nothing: then any axis square to the thigh will do.
    x, y, z = (thigh[..., i] for i in range(3))
    use_x = (xp.abs(x) < 0.6 * a)[..., None]
    square = xp.where(use_x, xp.stack([0 * x, -z, y], axis=-1), xp.stack([z, 0 * y, -x], axis=-1))
    pole_length = xp.sqrt(xp.maximum(dot(pole, pole), 1e-14))
    blind = dot(ahead, ahead) < (1e-4 * a * pole_length) ** 2
    ahead = xp.where(blind[..., None], square, ahead)
    normal = xp.where(straight[..., None], ahead, normal)
    normal = normal / norm(normal)[..., None]
    # Opening the knee turns the shin against the normal of (thigh × shin).
    knee_turn = quaternion.from_axis_angle(normal, now - wanted)
    new_ankle = knee + quaternion.rotate(knee_turn, shin)
    hip_turn = quaternion.from_two_vectors(new_ankle - hip, target - hip)
    return hip_turn, knee_turn


def local_rotations(
    hip_turn: Float[Array, "*b 4"],
    knee_turn: Float[Array, "*b 4"],
    above: tuple[Float[Array, "*b 4"], Float[Array, "*b 4"], Float[Array, "*b 4"]],
    leg: tuple[Float[Array, "*b 4"], Float[Array, "*b 4"], Float[Array, "*b 4"]],
) -> tuple[Float[Array, "*b 4"], Float[Array, "*b 4"], Float[Array, "*b 4"]]:
    """Local rotations of hip, knee and ankle after the turns that :func:`solve` finds.

    The foot keeps its orientation in the world. Joints between hip, knee and ankle (twist bones)
    keep their local rotations: they turn with the bone that they are in.

    Args:
        hip_turn, knee_turn: as :func:`solve` returns them.
        above: present world rotations of the parents of hip, knee and ankle.
        leg: present world rotations of hip, knee and ankle.
    """
    thigh, shin = hip_turn, quaternion.multiply(hip_turn, knee_turn)

    def local(parent: Array, joint: Array) -> Array:
        return quaternion.multiply(quaternion.conjugate(parent), joint)

    return (
        local(above[0], quaternion.multiply(thigh, leg[0])),
        local(quaternion.multiply(thigh, above[1]), quaternion.multiply(shin, leg[1])),
        local(quaternion.multiply(shin, above[2]), leg[2]),
    )
