"""FABRIK: a chain of joints whose end meets a target, by alternating forward and backward stages.

After Aristidou and Lasenby, *FABRIK: a fast, iterative solver for the inverse kinematics problem*
(2011), as Kalouache and Cherif use it for arms and head. Joint limits and
several targets at once are in :mod:`mgjax.hybrid.ik.tree`.
"""

from __future__ import annotations

import math
from functools import partial

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Float, Int

from mgjax.core.arrays import Array
from mgjax.core.calls.door import takes_not_finite
from mgjax.core.errors import ArgumentError
from mgjax.hybrid.ik import vectors as vec
from mgjax.hybrid.ik.closed_form import close_triangle, out_of_reach, straight_pieces

REACHED = 0
"""Status: the end is within the tolerance of the target."""
UNREACHABLE_FAR = 1
"""Status: the target is farther than the chain is long, D > Σd; it is stretched towards it."""
UNREACHABLE_NEAR = 2
"""Status: D < 2 max d − Σd: the longest bone cannot be folded back enough."""
NOT_CONVERGED = 3
"""Status: within reach, but not met: input that is not finite, or joint limits in the way."""

_TILE = 256
"""Chains solved together: their joints stay in the cache."""
_SHORT = 1e-3
"""Share of a bone's length below which the direction to its new place is not trusted."""

_UNROLL = 4
"""Joints per step of a loop along the chain; more does not run faster."""
_STRAIGHT = 1e-2
"""Distance from the root–target line, as a share of the chain, below which a chain lies on it.

The stages would keep it there, folding it at random, with slopes that grow with every joint."""


@takes_not_finite
@partial(jax.jit, static_argnames="max_iterations")
def fabrik(
    joints: Float[Array, "*b J 3"],
    target: Float[Array, "*b 3"],
    *,
    tolerance: float | Float[Array, ""] = 1e-3,
    max_iterations: int = 4,
) -> tuple[Float[Array, "*b J 3"], Int[Array, "*b"]]:
    """Moves the joints of chains so that their ends meet the targets, with bones of fixed length.

    Each iteration is the forward stage (end to target, then each joint onto the line to its old
    place, at its bone's length) and the backward stage (root back to its place, then outward); a
    chain stops as soon as its end is within the tolerance. Bone lengths come from ``joints``, and
    the root does not move. Any number of joints from 2 on, any leading batch axes.

    A target is within reach if 2 max d − Σd ≤ D ≤ Σd with the bone lengths d and its distance D
    from the root (Kalouache & Cherif, eq. 8 and the distance test). Out of reach, the chain is
    placed in closed form with its end as near to the target as can be.

    Deviation:
        What the iterations do not bring within the tolerance is met in closed form, see
        :mod:`mgjax.hybrid.ik.closed_form`. Plain FABRIK needs hundreds of iterations near the limit
        of reach, and never bends a straight chain whose target lies on its line.

    Gradients (forward and reverse mode) go through all ``max_iterations`` and the closed form.
    They are finite everywhere: where a joint would have to move to where its neighbour is, the
    direction is undefined, and the slope is bounded by ``1 / _SHORT`` there. Values with and
    without differentiation agree. The tolerance has no gradient.

    Args:
        joints: positions from root to end, m. Bones may have length zero.
        target: wanted place of the end, m.
        tolerance: distance at which the end counts as having arrived, m, > 0.
        max_iterations: iterations at most, ≥ 0.

    Returns:
        ``(joints, status)``, status one of ``REACHED``, ``UNREACHABLE_FAR``, ``UNREACHABLE_NEAR``,
        ``NOT_CONVERGED``.

    Raises:
        ArgumentError: fewer than two joints.
    """
    batch, count = target.shape[:-1], joints.shape[-2]
    if count < 2:
        raise ArgumentError(got=f"a chain of {count} joints", expected="at least two: a bone")
    joints, target = jnp.asarray(joints), jnp.asarray(target)
    flat = joints.reshape(-1, count, 3), target.reshape(-1, 3)
    tolerance = jnp.asarray(tolerance, joints.dtype)
    solved = _solve(*flat, tolerance, max_iterations)
    return solved.reshape(joints.shape), _status(*flat, solved, tolerance).reshape(batch)


@partial(jax.custom_jvp, nondiff_argnums=(3,))
def _solve(joints: Array, target: Array, tolerance: Array, max_iterations: int) -> Array:
    """[N,J,3] new joints. Not differentiated: iterates only while a chain of the tile needs it."""
    return _solve_tiles(joints, target, tolerance, max_iterations, fixed=False)


@_solve.defjvp
def _solve_jvp(max_iterations: int, primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    """New joints and their slopes, by a fixed number of iterations, each one kept."""
    joints, target, tolerance = primals

    def fixed(joints: Array, target: Array) -> Array:
        return _solve_tiles(joints, target, tolerance, max_iterations, fixed=True)

    return jax.jvp(fixed, (joints, target), tangents[:2])


def _solve_tiles(
    joints: Array, target: Array, tolerance: Array, max_iterations: int, *, fixed: bool
) -> Array:
    chains, count = joints.shape[:2]
    if chains == 0:
        return joints
    tile = min(_TILE, chains)
    tiles = math.ceil(chains / tile)
    bones = jnp.swapaxes(joints[:, 1:] - joints[:, :-1], 0, 1)
    offset = target - joints[:, 0]
    missing = tiles * tile - chains
    # [tiles, J−1, 3, tile]: the chains last.
    bones = jnp.pad(bones, ((0, 0), (0, missing), (0, 0)), mode="edge")
    bones = bones.reshape(count - 1, tiles, tile, 3).transpose(1, 0, 3, 2)
    offset = jnp.pad(offset, ((0, missing), (0, 0)), mode="edge")
    offset = offset.reshape(tiles, tile, 3).transpose(0, 2, 1)

    def one(arguments: tuple[Array, Array]) -> Array:
        return _solve_tile(*arguments, tolerance, max_iterations, fixed)

    moved = lax.map(one, (bones, offset)).transpose(0, 3, 1, 2)
    moved = jnp.cumsum(moved.reshape(tiles * tile, count - 1, 3)[:chains], axis=1)
    return jnp.concatenate([joints[:, :1], joints[:, :1] + moved], axis=1)


def _solve_tile(
    bones: Array, target: Array, tolerance: Array, max_iterations: int, fixed: bool
) -> Array:
    """[J−1,3,T] new bone vectors.

    Args:
        bones: bone vectors. [J−1, 3, T]
        target: relative to the root. [3, T]
        tolerance: m.
        max_iterations: at most, or exactly where ``fixed``.
        fixed: whether the number of iterations is fixed, as differentiation needs it.
    """
    lengths = vec.norm(bones)
    total = jnp.sum(lengths, axis=0)
    share = 1 / jnp.where(total > 0, total, 1.0)
    # From here on the chain's length is the unit.
    start, lengths = vec.scale(share[None], bones), lengths * share[None]
    target, limit = vec.scale(share, target), (tolerance * share) ** 2
    too_far, too_near = out_of_reach(lengths, vec.norm(target))
    within = ~(too_far | too_near)
    points = jnp.cumsum(start, axis=0)
    iterated = within & ~_on_a_line(points, target)

    # Straight code for several joints is faster, but its derivative takes a minute to compile.
    unroll = 1 if fixed else _UNROLL

    def away(end: Array) -> Array:
        return vec.dot(end - target, end - target) > limit

    def step(_: Array | int, points: Array) -> Array:
        moving = away(points[-1]) & iterated
        return vec.where(moving[None], _iterate(points, lengths, target, unroll), points)

    if fixed:
        points = lax.fori_loop(0, max_iterations, step, points)
    else:
        _, points = lax.while_loop(
            lambda s: (s[0] < max_iterations) & jnp.any(away(s[1][-1]) & iterated),
            lambda s: (s[0] + 1, step(0, s[1])),
            (0, points),
        )
    solved = _exact(points, start, lengths)
    missed = away(jnp.sum(solved, axis=0)) | ~within
    solved = lax.cond(
        jnp.any(missed),
        lambda b: vec.where(missed[None], _finish(b, lengths, target, within), b),
        lambda b: b,
        solved,
    )
    return vec.scale(jnp.where(total > 0, total, 0.0)[None], solved)


def _on_a_line(points: Array, target: Array) -> Array:
    """Whether the whole chain lies on the line through root and target, or nearly."""
    ahead = vec.unit(target, vec.x_axis(target), 1e-6)[None]
    off = points - vec.scale(vec.dot(points, ahead), ahead)
    return jnp.max(vec.dot(off, off), axis=0) < _STRAIGHT**2


def _iterate(points: Array, lengths: Array, target: Array, unroll: int) -> Array:
    """One forward and one backward stage; the root is the origin and not among the points."""
    origin = jnp.zeros_like(target)

    def inward(joint: Array, inner: tuple[Array, Array]) -> tuple[Array, Array]:
        return _place(joint, *inner), joint

    def outward(joint: Array, outer: tuple[Array, Array]) -> tuple[Array, Array]:
        placed = _place(joint, *outer)
        return placed, placed

    old = jnp.concatenate([origin[None], points[:-1]])
    _, forward = lax.scan(inward, target, (old, lengths), reverse=True, unroll=unroll)
    return lax.scan(outward, origin, (forward, lengths), unroll=unroll)[1]


def _place(start: Array, towards: Array, length: Array) -> Array:
    """The point at ``length`` from ``start`` on the way to a point.

    Nearer to it than a thousandth of the length the slope would grow without bound; there the
    result falls short of ``length``, which :func:`_exact` makes good.
    """
    displacement = towards - start
    shortest = (_SHORT * length) ** 2 + vec.TINY
    return start + vec.scale(
        length * lax.rsqrt(jnp.maximum(vec.dot(displacement, displacement), shortest)), displacement
    )


def _exact(points: Array, start: Array, lengths: Array) -> Array:
    """Bones along the chain with their lengths; one that has collapsed gets its old direction."""
    bones = points - jnp.concatenate([jnp.zeros_like(points[:1]), points[:-1]])
    square = vec.dot(bones, bones)
    collapsed = square <= 0.25 * lengths * lengths
    factor = lengths * lax.rsqrt(jnp.where(collapsed, 1.0, square))
    return vec.where(collapsed, start, vec.scale(factor, bones))


def _finish(bones: Array, lengths: Array, target: Array, within: Array) -> Array:
    straight = straight_pieces(bones, lengths, target)
    if bones.shape[0] == 1:
        return straight
    closed, closes = close_triangle(bones, target)
    return vec.where((closes & within)[None], closed, straight)


def _status(joints: Array, target: Array, solved: Array, tolerance: Array) -> Array:
    """[N] status of each chain."""
    lengths = jnp.sqrt(jnp.sum((joints[:, 1:] - joints[:, :-1]) ** 2, axis=-1))
    distance = jnp.sqrt(jnp.sum((target - joints[:, 0]) ** 2, axis=-1))
    total, longest = jnp.sum(lengths, axis=-1), jnp.max(lengths, axis=-1)
    miss = jnp.sqrt(jnp.sum((solved[:, -1] - target) ** 2, axis=-1))
    status = jnp.where(distance < 2 * longest - total, UNREACHABLE_NEAR, NOT_CONVERGED)
    status = jnp.where(distance > total, UNREACHABLE_FAR, status)
    return jnp.where(miss <= tolerance, REACHED, status).astype(jnp.int32)
