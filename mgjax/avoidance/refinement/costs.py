"""What is asked of a change of a motion, and what it costs beside the clearance that is missing."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.avoidance.refinement.inside import deepest
from mgjax.avoidance.refinement.rig import Rig
from mgjax.avoidance.refinement.slopes import Base, Changed
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

INSIDE = 0.9
"""Share of the caps at which soft bounds begin."""
MOVED_WEIGHT = 0.5
"""Weight of the mean square of how far joints are moved."""
_SOFT_M = 0.002
_SOFT_RAD = float(np.radians(0.4))
_SOFT_FOOT_M = 0.001
"""What is beyond a soft bound by so much costs as much as a change of 1 unit."""


@register()
@dataclass(frozen=True, kw_only=True)
class Problem:
    """A motion, and an attack that it is to be clear of.

    Attributes:
        base: the poses at T moments at which the attack is near, in ascending order, and then at
            any others at which bounds are to hold.
        basis: value of each spline. [M, K]
        attack: centres of its spheres, m. [T, I, 3]
        radii: of these, m. [I]
        absent: 1 where a sphere is not there between two moments, else 0. [T − 1, I]
        size: Q of :func:`mgjax.avoidance.refinement.splines.size_matrix`. [K, K]
        unit: what of each channel weighs as much as 1. [C]
        margin: wanted clearance, m.
        max_m, max_rad: caps on how far a joint moves and turns.
        deep: how far limbs may be in the body beyond the capture, where they were not anyway, m.
    """

    base: Base
    basis: Float[Array, "M K"]
    attack: Float[Array, "T I 3"]
    radii: Float[Array, " I"]
    absent: Float[Array, "V I"]
    size: Float[Array, "K K"]
    unit: Float[Array, " C"]
    margin: Float[Array, ""]
    max_m: Float[Array, ""]
    max_rad: Float[Array, ""]
    deep: Float[Array, ""]


def soft_costs(
    rig: Rig,
    problem: Problem,
    places: Float[Array, "T J 3"],
    now: Changed,
    channels: Float[Array, "T C"],
    bounds: tuple[Float[Array, "T P"], Float[Array, ""]],
) -> tuple[Float[Array, "T R"], Float[Array, "T R C"], Float[Array, ""]]:
    """What a change costs beside the size of its curves, its derivatives, and the largest move or
    turn as a share of its cap.

    Args:
        rig, problem: the problem.
        places: of joints before.
        now: changed poses.
        channels: what they are changed by.
        bounds: how deep limbs are in the body before, and the move from which on it costs, m.
    """
    were_deep, begins = bounds
    groups, legs = len(rig.groups), len(rig.legs)
    moments, joints = places.shape[:2]
    split = 3 + 3 * groups
    shift = now.places - places
    length = jnp.sqrt(jnp.sum(shift * shift, axis=-1) + 1e-10)
    to_length = jnp.einsum("tjx,tjxc->tjc", shift / length[..., None], now.to_places)
    vectors = channels[:, 3:split].reshape(moments, groups, 3)
    turn = jnp.sqrt(jnp.sum(vectors * vectors, axis=-1) + 1e-10)
    to_turn = jnp.zeros((moments, groups, rig.channels), dtype=places.dtype)
    for group in range(groups):
        own = slice(3 + 3 * group, 6 + 3 * group)
        to_turn = to_turn.at[:, group, own].set(vectors[:, group] / turn[:, group, None])
    # Of a foot only what is free counts; it never goes down.
    feet = jnp.zeros((moments, legs, rig.channels), dtype=places.dtype)
    sunk = jnp.zeros((moments, legs), dtype=places.dtype)
    for leg in range(legs):
        row = split + 3 * leg + 1
        sunk = sunk.at[:, leg].set(-channels[:, row])
        feet = feet.at[:, leg, row].set(-1.0)
    largest = jnp.max(rig.shares, axis=1)
    bound = INSIDE * problem.max_rad
    turns = 3 * legs
    inner = now.bounds.shape[1] - turns - legs
    weak = jnp.sqrt(MOVED_WEIGHT / (moments * joints)) / problem.unit[0]
    blocks = [
        (shift.reshape(moments, -1) * weak, now.to_places.reshape(moments, 3 * joints, -1) * weak),
        _hinge(length - begins, to_length, 0.01),
        _hinge(length - INSIDE * problem.max_m, to_length, _SOFT_M),
        _hinge(turn * largest[None] - bound, to_turn * largest[None, :, None], _SOFT_RAD),
        _hinge(now.bounds[:, :turns] - bound, now.to_bounds[:, :turns], _SOFT_RAD),
        _hinge(
            now.bounds[:, turns : turns + inner] - 1e-3,
            now.to_bounds[:, turns : turns + inner],
            _SOFT_RAD,
        ),
        _hinge(
            now.bounds[:, turns + inner :] - 3e-4, now.to_bounds[:, turns + inner :], _SOFT_FOOT_M
        ),
        _hinge(sunk, feet, _SOFT_FOOT_M),
        _hinge(*deepest(rig, now, jnp.maximum(were_deep, problem.deep)), _SOFT_M),
    ]
    values, slopes = zip(*blocks, strict=True)
    turned = jnp.maximum(jnp.max(turn * largest[None]), jnp.max(now.bounds[:, :turns], initial=0.0))
    used = jnp.maximum(jnp.max(length) / problem.max_m, turned / problem.max_rad)
    return jnp.concatenate(values, axis=1), jnp.concatenate(slopes, axis=1), used


def _hinge(value: Array, slopes: Array, scale: float) -> tuple[Array, Array]:
    """max(0, value) in units of a scale, with its derivatives."""
    on = (value > 0).astype(value.dtype) / scale
    return value * on, slopes * on[..., None]
