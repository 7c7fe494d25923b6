"""Unit quaternions, component order ``wxyz``; q and -q are the same rotation.

All functions broadcast over leading axes and work on NumPy and jax arrays alike. Degenerate input
(equal quaternions, parallel vectors, zero angles) gives finite values and finite gradients.
"""

from __future__ import annotations

import math

from jaxtyping import Float

from mgjax.core.arrays import Array, namespace

_TINY = 1e-12


def multiply(a: Float[Array, "*a 4"], b: Float[Array, "*b 4"]) -> Float[Array, "*c 4"]:
    """Hamilton product: the rotation ``b`` followed by ``a``."""
    xp = namespace(a, b)
    aw, ax, ay, az = (a[..., i] for i in range(4))
    bw, bx, by, bz = (b[..., i] for i in range(4))
    return xp.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def conjugate(q: Float[Array, "*b 4"]) -> Float[Array, "*b 4"]:
    """The inverse rotation of a unit quaternion."""
    xp = namespace(q)
    return xp.concatenate([q[..., :1], -q[..., 1:]], axis=-1)


def rotate(q: Float[Array, "*a 4"], v: Float[Array, "*b 3"]) -> Float[Array, "*c 3"]:
    """Rotates the vectors ``v`` by ``q``."""
    xp = namespace(q, v)
    w, x, y, z = (q[..., i] for i in range(4))
    vx, vy, vz = (v[..., i] for i in range(3))
    # t = 2 u × v;  v' = v + w t + u × t
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return xp.stack(
        [
            vx + w * tx + y * tz - z * ty,
            vy + w * ty + z * tx - x * tz,
            vz + w * tz + x * ty - y * tx,
        ],
        axis=-1,
    )


def normalise(q: Float[Array, "*b 4"]) -> Float[Array, "*b 4"]:
    """Scales to unit length; a zero quaternion stays zero."""
    xp = namespace(q)
    return q / xp.sqrt(xp.maximum(xp.sum(q * q, axis=-1, keepdims=True), _TINY**2))


def from_axis_angle(axis: Float[Array, "*a 3"], angle: Float[Array, "*b"]) -> Float[Array, "*c 4"]:
    """Rotation by ``angle`` (rad) about the unit vector ``axis``."""
    xp = namespace(axis, angle)
    half = 0.5 * angle
    xyz = axis * xp.sin(half)[..., None]
    w = xp.broadcast_to(xp.cos(half)[..., None], (*xyz.shape[:-1], 1))
    return xp.concatenate([w, xyz], axis=-1)


def exp(vector: Float[Array, "*b 3"]) -> Float[Array, "*b 4"]:
    """The rotation about a vector by its length, rad: the inverse of :func:`log`."""
    xp = namespace(vector)
    angle = xp.sqrt(xp.maximum(xp.sum(vector * vector, axis=-1, keepdims=True), _TINY**2))
    share = 0.5 * xp.sinc(0.5 * angle / math.pi)
    return xp.concatenate([xp.cos(0.5 * angle), share * vector], axis=-1)


def log(q: Float[Array, "*b 4"]) -> Float[Array, "*b 3"]:
    """The rotation vector of a unit quaternion: its axis times its angle, 0 … π rad."""
    xp = namespace(q)
    q = xp.where(q[..., :1] < 0, -q, q)
    sine = xp.sqrt(xp.maximum(xp.sum(q[..., 1:] ** 2, axis=-1), 1e-16))
    return (2 * xp.arctan2(sine, q[..., 0]) / sine)[..., None] * q[..., 1:]


def from_yaw(angle: Float[Array, "*b"]) -> Float[Array, "*b 4"]:
    """Rotation by ``angle`` (rad) about +Y, which turns +Z towards +X."""
    xp = namespace(angle)
    zero = xp.zeros_like(angle)
    return xp.stack([xp.cos(0.5 * angle), zero, xp.sin(0.5 * angle), zero], axis=-1)


def from_euler(angles: Float[Array, "*b k"], order: str) -> Float[Array, "*b 4"]:
    """Product of axis rotations, left to right: ``order="ZYX"`` gives Rz·Ry·Rx.

    Args:
        angles: rad, one column for each letter of ``order`` (any number, letters may repeat).
        order: letters out of X, Y, Z.
    """
    xp = namespace(angles)
    result = None
    for column, letter in enumerate(order.upper()):
        half = 0.5 * angles[..., column]
        zero = xp.zeros_like(half)
        parts = [xp.cos(half), zero, zero, zero]
        parts[1 + "XYZ".index(letter)] = xp.sin(half)
        q = xp.stack(parts, axis=-1)
        result = q if result is None else multiply(result, q)
    if result is None:
        one = xp.ones(angles.shape[:-1], dtype=angles.dtype)
        result = xp.stack([one, one * 0, one * 0, one * 0], axis=-1)
    return result


def from_matrix(matrix: Float[Array, "*b 3 3"]) -> Float[Array, "*b 4"]:
    """The rotation of an orthogonal matrix, from the largest of its four components."""
    xp = namespace(matrix)
    m = [[matrix[..., i, j] for j in range(3)] for i in range(3)]
    one = xp.ones_like(m[0][0])
    rows = [
        [one + m[0][0] + m[1][1] + m[2][2], m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]
    ]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        row = [m[k][j] - m[j][k], one, one, one]
        row[1 + i] = one + m[i][i] - m[j][j] - m[k][k]
        row[1 + j] = m[j][i] + m[i][j]
        row[1 + k] = m[k][i] + m[i][k]
        rows.append(row)
    candidates = xp.stack([xp.stack(row, axis=-1) for row in rows], axis=-2)
    squares = xp.stack([rows[0][0], rows[1][1], rows[2][2], rows[3][3]], axis=-1)
    largest = xp.argmax(squares, axis=-1)[..., None, None]
    return normalise(xp.take_along_axis(candidates, largest, axis=-2)[..., 0, :])


def to_euler_zyx(q: Float[Array, "*b 4"]) -> Float[Array, "*b 3"]:
    """Angles (z, y, x) in rad with q = Rz·Ry·Rx; at the pole y = ±π/2, x is 0."""
    xp = namespace(q)
    w, x, y, z = (q[..., i] for i in range(4))
    # With half angles: (w + y, z - x) = √2 sin(y/2 + π/4) (cos, sin)((z - x)/2) and
    # (w - y, z + x) = √2 cos(y/2 + π/4) (cos, sin)((z + x)/2). Unlike an arcsine this stays exact
    # near the poles, where one of the two pairs vanishes, and does not need a unit quaternion.
    upper, lower = (w + y) ** 2 + (z - x) ** 2, (w - y) ** 2 + (z + x) ** 2
    north, south = lower < 1e-12, upper < 1e-12
    pitch = 2 * xp.arctan2(
        xp.sqrt(xp.where(south, 1e-24, upper)), xp.sqrt(xp.where(north, 1e-24, lower))
    )
    difference = xp.arctan2(xp.where(south, 0.0 * w, z - x), xp.where(south, 0.0 * w + 1, w + y))
    total = xp.arctan2(xp.where(north, 0.0 * w, z + x), xp.where(north, 0.0 * w + 1, w - y))
    yaw = xp.where(north, 2 * difference, xp.where(south, 2 * total, total + difference))
    roll = xp.where(north | south, 0.0 * w, total - difference)

    def wrap(angle: Array) -> Array:
        turn = 2 * math.pi
        return angle - turn * xp.round(angle / turn)

    return xp.stack([wrap(yaw), pitch - 0.5 * math.pi, wrap(roll)], axis=-1)


def from_two_vectors(a: Float[Array, "*a 3"], b: Float[Array, "*a 3"]) -> Float[Array, "*a 4"]:
    """The smallest rotation that turns the direction of ``a`` into that of ``b`` (the swing).

    Opposite directions give a half turn about some axis square to ``a``; a zero vector gives the
    identity.
    """
    xp = namespace(a, b)

    def unit(v: Array) -> Array:
        return v / xp.sqrt(xp.maximum(xp.sum(v * v, axis=-1, keepdims=True), 1e-20))

    a, b = unit(a), unit(b)
    cosine = xp.sum(a * b, axis=-1, keepdims=True)
    ax, ay, az = (a[..., i] for i in range(3))
    bx, by, bz = (b[..., i] for i in range(3))
    cross = xp.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)
    # Half turn: about the cross product of a with the coordinate axis least aligned with it.
    zero = xp.zeros_like(ax)
    use_x = xp.abs(ax) < 0.6
    square = xp.stack(
        [xp.where(use_x, zero, -az), xp.where(use_x, az, zero), xp.where(use_x, -ay, ax)], axis=-1
    )
    opposite = cosine < -1 + 1e-6
    raw = xp.concatenate([1 + cosine, cross], axis=-1)
    turn = xp.concatenate([xp.zeros_like(cosine), unit(square)], axis=-1)
    nothing = xp.sum(a * a, axis=-1, keepdims=True) * xp.sum(b * b, axis=-1, keepdims=True) < 0.5
    identity = xp.concatenate([xp.ones_like(cosine), xp.zeros_like(cross)], axis=-1)
    return normalise(xp.where(nothing, identity, xp.where(opposite, turn, raw)))


def slerp(
    a: Float[Array, "*a 4"], b: Float[Array, "*b 4"], t: Float[Array, "*t"]
) -> Float[Array, "*c 4"]:
    """Shortest arc from ``a`` (t = 0) to ``b`` (t = 1) at constant angular speed."""
    xp = namespace(a, b, t)
    cosine = xp.sum(a * b, axis=-1)
    b = xp.where((cosine < 0)[..., None], -b, b)
    cosine = xp.abs(cosine)
    near = cosine > 1 - 1e-6
    # Both branches are finite everywhere, so that gradients are too.
    angle = xp.arccos(xp.where(near, 0.5, xp.minimum(cosine, 1 - 1e-7)))
    sine = xp.sin(angle)
    weight_a = xp.where(near, 1 - t, xp.sin((1 - t) * angle) / sine)
    weight_b = xp.where(near, t, xp.sin(t * angle) / sine)
    return normalise(a * weight_a[..., None] + b * weight_b[..., None])


def angle_between(a: Float[Array, "*a 4"], b: Float[Array, "*b 4"]) -> Float[Array, "*c"]:
    """Angle in rad, 0 … π, of the rotation from ``a`` to ``b``."""
    xp = namespace(a, b)
    d = multiply(conjugate(a), b)
    sine = xp.sqrt(xp.maximum(xp.sum(d[..., 1:] ** 2, axis=-1), 1e-20))
    return xp.asarray(2 * xp.arctan2(sine, xp.abs(d[..., 0])))
