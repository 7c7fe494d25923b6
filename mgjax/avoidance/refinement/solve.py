"""The least change of a motion that clears an attack: Gauss–Newton on an augmented Lagrangian.

Sought are coefficients x of B-splines, a column of each channel, with least

    f(x) = ½ xᵀ W x + ½ Σ r²

such that every sphere of the body keeps a margin where it is nearest to the attack. W says how
large the curves are, r are how far joints are moved, and by how much soft bounds are passed. Each
step solves the quadratic model of

    f + Σ max(0, λ − ρ g)² / 2ρ

(Nocedal and Wright 2006, eq. 17.55) with g the clearance beyond the margin, and then updates the
multipliers λ. What passes a sphere is nearest to it where it is across its way, so the sphere is
led aside and neither driven ahead of it nor held back. Poses at one moment depend on the channels
of that moment only, so derivatives are taken with respect to these.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.avoidance.refinement.inside import deepest, depths
from mgjax.avoidance.refinement.nearest import is_least, nearest_intervals, swept
from mgjax.avoidance.refinement.rig import Rig
from mgjax.avoidance.refinement.slopes import Base, Changed, changed_with_slopes
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

ITERATIONS = 14
PENALTY = 2e4
"""ρ: a sphere 1 cm too near costs as much as a change of 1 unit of two channels."""
MOST_PUSH = 400.0
"""Largest multiplier: where caps and margin cannot both be kept, caps are."""
INSIDE = 0.9
"""Share of the caps at which soft bounds begin."""
DAMPING = 0.03
"""Of each step, so that 32 bits do."""
LONGEST_STEP = 0.8
"""Units by which a coefficient changes at most in one step."""
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


@register()
@dataclass(frozen=True, kw_only=True)
class Solution:
    """What was found.

    Attributes:
        coefficients: of the splines, a column of each channel, m and rad. [K, C]
        clearance: of the changed motion at the moments of the problem, m.
        before: of the unchanged motion.
    """

    coefficients: Float[Array, "K C"]
    clearance: Float[Array, ""]
    before: Float[Array, ""]


@register()
@dataclass(frozen=True, kw_only=True)
class Step:
    """Where a step begins: coefficients, m and rad, clearance, m, and what both cost."""

    coefficients: Float[Array, "K C"]
    clearance: Float[Array, ""]
    cost: Float[Array, ""]


def solve(rig: Rig, problem: Problem) -> Solution:
    """Least change of one motion; see the module."""
    base = problem.base
    bases, unit = problem.basis, problem.unit
    splines, channels = bases.shape[-1], rig.channels
    weight = jnp.kron(problem.size, jnp.eye(channels, dtype=bases.dtype))
    damping = DAMPING * jnp.eye(splines * channels, dtype=bases.dtype)
    place = rig.place

    def spheres_of(joints: Array) -> Array:
        joints = joints[: len(problem.attack)]
        share = place.reshape(1, -1, *([1] * (joints.ndim - 2)))
        return joints[:, rig.first] * (1 - share) + joints[:, rig.second] * share

    def pose(x: Array) -> Changed:
        return changed_with_slopes(rig, base, bases @ x * unit[None])

    passing = problem.attack, problem.radii, problem.absent
    start = swept(*passing, spheres_of(base.places), rig.radii)[0]
    before = jnp.min(start)
    needed = problem.margin - before
    begins = jnp.minimum(INSIDE * problem.max_m, 1.15 * needed)
    rows = nearest_intervals(start)
    bounds = depths(rig, base.places), begins

    def step(state: tuple[Array, Array], _: None) -> tuple[tuple[Array, Array], Step]:
        x, multipliers = state
        now = pose(x)
        gap, way, share = swept(*passing, spheres_of(now.places), rig.radii)
        at = nearest_intervals(gap)
        own = jnp.arange(gap.shape[1], dtype=jnp.int32)[None]
        local = is_least(gap, at)
        least = jnp.min(gap)
        gap, way, share = gap[at, own], way[at, own], share[at, own, None]
        slopes = spheres_of(now.to_places) * unit[None, None, None]
        low = jnp.einsum("hsx,hsxc->hsc", way, slopes[at, own]) * (1 - share)
        high = jnp.einsum("hsx,hsxc->hsc", way, slopes[at + 1, own]) * share
        lean = low[:, :, None] * bases[at][..., None] + high[:, :, None] * bases[at + 1][..., None]
        lean = lean.reshape(-1, x.size)
        push = multipliers - PENALTY * (gap - problem.margin)
        push = jnp.where(
            local,
            jnp.clip(push, 0.0, MOST_PUSH + PENALTY * jnp.maximum(problem.margin - gap, 0.0)),
            0.0,
        )
        active = (push > 0).astype(gap.dtype).reshape(-1, 1)
        soft, to_soft, share_of_caps = _soft(
            rig, problem, base.places, now, bases @ x * unit[None], bounds
        )
        to_soft = to_soft * unit[None, None]
        squares = jnp.einsum("trc,trd->tcd", to_soft, to_soft)
        curve = jnp.einsum("tk,tl,tcd->kcld", bases, bases, squares).reshape(x.size, x.size)
        slope = jnp.einsum("tk,trc,tr->kc", bases, to_soft, soft).reshape(-1)
        hessian = weight + damping + curve + PENALTY * (lean * active).T @ lean
        gradient = weight @ x.reshape(-1) + slope - push.reshape(-1) @ lean
        change = -jax.scipy.linalg.solve(hessian, gradient, assume_a="pos")
        change = change * jnp.minimum(1.0, LONGEST_STEP / jnp.max(jnp.abs(change) + 1e-9))
        # The multipliers of the linear model after the step.
        push = push - PENALTY * active.reshape(push.shape) * (lean @ change).reshape(push.shape)
        missing = jnp.maximum(0.5 * problem.margin - least, 0.0) / problem.max_m
        beyond = jnp.maximum(share_of_caps - 0.995, 0.0)
        cost = missing + beyond + 1e-3 * (x.reshape(-1) @ weight @ x.reshape(-1))
        cost = jnp.where(jnp.isfinite(cost), cost, jnp.inf)
        worth = Step(coefficients=x * unit[None], clearance=least, cost=cost)
        return (x + change.reshape(x.shape), jnp.clip(push, 0.0, MOST_PUSH)), worth

    zero = jnp.zeros((splines, channels), dtype=bases.dtype)
    none = jnp.zeros(rows.shape, dtype=bases.dtype)
    # One step more than is used: it says what the one before it is worth.
    _, steps = jax.lax.scan(step, (zero, none), None, length=ITERATIONS + 1)
    best = jnp.argmin(steps.cost)
    return Solution(
        coefficients=steps.coefficients[best], clearance=steps.clearance[best], before=before
    )


def _soft(
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


solve_compiled = jax.jit(solve)
