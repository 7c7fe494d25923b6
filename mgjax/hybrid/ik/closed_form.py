"""The last step of FABRIK, in closed form: any chain that can reach its target does.

A chain is an array of bone vectors ``[J−1, 3, N]`` from the root on
(:mod:`mgjax.hybrid.ik.vectors`), in units of its whole length. The target is relative to the root.

Alternating stages approach some targets forever: those almost out of reach, and those on the line
of a straight chain, from which the stages never leave. Two constructions replace the rest of the
iterations. Both bend the chain in the plane of the target and the joint in question.

- :func:`close_triangle`: one joint cuts the chain into two parts that are each turned rigidly.
  Their chords and the root–target line form a triangle where the triangle inequality holds.
- :func:`straight_pieces`: a chain of straight pieces, for where no joint does, or where the
  target is out of reach. It always exists: the bones and the line back from the target to the root
  form a closed ring; where no side is longer than half the ring, the ring can be cut into three
  runs of which none is longer than half, and those make a triangle.
"""

from __future__ import annotations

from collections.abc import Callable

import jax.numpy as jnp
from jax import lax
from jaxtyping import Bool, Float

from mgjax.core.arrays import Array
from mgjax.hybrid.ik import vectors as vec

_SLACK = 1e-4
"""How much a triangle must exceed a degenerate one, as a share of the chain."""
_NARROW = 1e-3
"""Distance from the root–target line, as a share, from which on a point says where to bend."""


def close_triangle(
    bones: Float[Array, "n 3 N"], target: Float[Array, "3 N"]
) -> tuple[Float[Array, "n 3 N"], Bool[Array, " N"]]:
    """Turns the two parts of the chain on both sides of one joint so that its end meets the target.

    The joint is the one whose triangle is farthest from degenerate.

    Returns:
        The bones, and whether there is such a joint; without one the bones are as they were.
    """
    points = jnp.cumsum(bones, axis=0)
    end, distance = points[-1], vec.norm(target)
    inner = points[:-1]
    near, far = vec.norm(inner), vec.norm(end[None] - inner)
    wide = distance[None]
    room = jnp.minimum(near + far - wide, wide - jnp.abs(near - far))
    joint = jnp.argmax(room, axis=0)
    chosen = jnp.arange(room.shape[0])[:, None] == joint[None]
    closes = jnp.max(room, axis=0) > _SLACK
    elbow = jnp.sum(jnp.where(chosen[:, None], inner, 0.0), axis=0)
    near = jnp.where(closes, jnp.sum(jnp.where(chosen, near, 0.0), axis=0), 1.0)
    far = jnp.where(closes, jnp.sum(jnp.where(chosen, far, 0.0), axis=0), 1.0)
    ahead = vec.unit(target, vec.x_axis(target), 1e-6)
    side = _side(elbow, ahead)
    sides = [
        vec.scale(a, ahead) + vec.scale(b, side)
        for a, b in _sides(near, far, jnp.where(closes, distance, 1.0))
    ]
    first = _turn(vec.scale(1 / near, elbow), sides[0])
    second = _turn(vec.scale(1 / far, end - elbow), sides[1])
    inside = jnp.arange(bones.shape[0])[:, None] <= joint[None]
    turned = vec.where(inside, first(bones), second(bones))
    return vec.where(closes[None], turned, bones), closes


def straight_pieces(
    bones: Float[Array, "n 3 N"], lengths: Float[Array, "n N"], target: Float[Array, "3 N"]
) -> Float[Array, "n 3 N"]:
    """The chain in straight pieces, its end as near to the target as its bones allow.

    Out of reach: stretched towards the target, or, where the longest bone is longer than all
    others and the target together, that bone towards it and all others back. Within reach: bent
    once where that is enough, else with its first bones folded back, then bent.
    """
    distance = vec.norm(target)
    ahead = vec.unit(target, vec.x_axis(target), 1e-6)
    side = _side(jnp.mean(jnp.cumsum(bones, axis=0), axis=0), ahead)
    reached = jnp.cumsum(lengths, axis=0)
    folded, bent = _cuts(lengths, reached, distance)
    first, second = _sides(bent - folded, 1 - bent, distance + folded)
    before = reached - lengths < (bent - 1e-6)[None]
    before = jnp.cumsum(~before, axis=0) == 0
    a, b = (jnp.where(before, f[None], s[None]) for f, s in zip(first, second, strict=True))
    too_far, too_near = out_of_reach(lengths, distance)
    index = jnp.arange(lengths.shape[0])[:, None]
    longest = index == jnp.argmax(lengths, axis=0)[None]
    straight = (too_far | too_near)[None] | (reached <= (folded + 1e-6)[None])
    forward = too_far[None] | (too_near[None] & longest)
    a = jnp.where(straight, jnp.where(forward, 1.0, -1.0), a) * lengths
    b = jnp.where(straight, 0.0, b) * lengths
    return vec.scale(a, ahead[None]) + vec.scale(b, side[None])


def out_of_reach(
    lengths: Float[Array, "n N"], distance: Float[Array, " N"]
) -> tuple[Bool[Array, " N"], Bool[Array, " N"]]:
    """Whether a target at some distance is too far, and whether it is too near; Σd is 1."""
    return distance > 1, distance < 2 * jnp.max(lengths, axis=0) - 1


def _cuts(lengths: Array, reached: Array, distance: Array) -> tuple[Array, Array]:
    """Where the folded run ends and where the chain bends, as lengths along it.

    One bend is enough where a joint has ``|a − b| ≤ distance`` for the lengths on its two sides;
    the most even one is taken. Otherwise the first bones lie folded back, as many as leave the run
    with the line to the target at most half of the ring; the next bone is then the second side,
    and the rest, which is shorter than half, the third.
    """
    fits = distance[None] + (reached - lengths) <= 0.5 * (1 + distance)[None]
    folded = jnp.max(jnp.where(fits, reached - lengths, 0.0), axis=0)
    bent = jnp.max(jnp.where(fits, reached, 0.0), axis=0)
    if lengths.shape[0] == 1:
        return folded, bent
    uneven = jnp.abs(2 * reached[:-1] - 1)
    least = jnp.min(uneven, axis=0)
    bend = jnp.max(jnp.where(uneven == least[None], reached[:-1], 0.0), axis=0)
    once = least <= distance
    return jnp.where(once, 0.0, folded), jnp.where(once, bend, bent)


def _sides(
    first: Array, second: Array, base: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Directions of the two sides of a triangle on its base, as parts along it and square to it."""
    along = (first * first + base * base - second * second) / (2 * jnp.maximum(base, 1e-6))
    along = jnp.clip(along, -first, first)
    across = vec.root(first * first - along * along, 1e-9)
    return _direction(along, across), _direction(base - along, -across)


def _direction(along: Array, across: Array) -> tuple[Array, Array]:
    """The unit vector of a vector in the plane; (1, 0) for none."""
    square = along * along + across * across
    none = square <= 1e-12
    size = lax.rsqrt(jnp.where(none, 1.0, square))
    return jnp.where(none, 1.0, along * size), across * size


def _side(point: Array, ahead: Array) -> Array:
    """Direction in which ``point`` lies off the line along ``ahead``; any where it lies on it."""
    off = point - vec.scale(vec.dot(point, ahead), ahead)
    return vec.unit(off, vec.square_to(ahead), _NARROW)


def _turn(old: Array, new: Array) -> Callable[[Array], Array]:
    """The smallest rotation from one unit vector to another, as a function of bones.

    Where the two are nearly opposite, a half turn about an axis square to ``old`` comes first.
    """
    opposite = vec.dot(old, new) < -0.99
    axis = vec.square_to(old)[None]
    start = vec.where(opposite, -old, old)
    cosine, normal = vec.dot(start, new)[None], vec.cross(start, new)[None]
    share = 1 / jnp.maximum(1 + cosine, 5e-3)

    def apply(v: Array) -> Array:
        flipped = vec.scale(2 * vec.dot(axis, v), axis) - v
        v = vec.where(opposite[None], flipped, v)
        along = vec.scale(share * vec.dot(normal, v), normal)
        return vec.scale(cosine, v) + vec.cross(normal, v) + along

    return apply
