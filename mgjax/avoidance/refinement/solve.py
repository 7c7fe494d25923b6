"""The least change of a motion that clears an attack: Gauss–Newton on an augmented Lagrangian.

Sought are coefficients x of B-splines, a column of each channel, with least

    f(x) = ½ xᵀ W x + ½ Σ r²

such that every sphere of the body keeps a margin where it is nearest to the attack. W says how
large the curves are, r are how far joints are moved, and by how much soft bounds are passed. Each
step solves the quadratic model of

    f + Σ max(0, λ − ρ g)² / 2ρ

(Nocedal and Wright 2006, eq. 17.55) with g the clearance beyond the margin, and then updates the
multipliers λ. Steps end where they gain nothing, and one that makes it much worse is shortened.
What passes a sphere is nearest to it where it is across its way, so the sphere is
led aside and neither driven ahead of it nor held back. Poses at one moment depend on the channels
of that moment only, so derivatives are taken with respect to these.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Float, Int

from mgjax.avoidance.refinement.costs import INSIDE, Problem, soft_costs
from mgjax.avoidance.refinement.inside import depths
from mgjax.avoidance.refinement.nearest import is_least, nearest_intervals, swept
from mgjax.avoidance.refinement.rig import Rig
from mgjax.avoidance.refinement.slopes import Changed, changed_with_slopes
from mgjax.core.arrays import Array
from mgjax.core.xla.exported import exported
from mgjax.core.xla.pytree import register

ITERATIONS = 24
"""Steps at most."""
PENALTY = 2e4
"""ρ: a sphere 1 cm too near costs as much as a change of 1 unit of two channels."""
MOST_PUSH = 400.0
"""Largest multiplier: where caps and margin cannot both be kept, caps are."""
DAMPING = 0.1
"""Of each step, so that 32 bits do."""
LONGEST_STEP = 0.8
"""Units by which a coefficient changes at most in one step."""
SIZE, USED = 1e-3, 0.02
"""Cost of the size of a change, and of the share of the caps that it uses, beside what of the
clearance is missing, in largest moves, and what of the caps is passed."""
GAIN = 0.02
"""Share of its cost by which the best one has to become better, …"""
IDLE, LOST = 3, 8
"""… or so many steps that gain nothing are enough: where the best is clear within the caps, and
where it is not."""
SETBACK, BACK = 0.05, 0.4
"""What costs so much more than the best is not gone on from, but this share of the way to it."""


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
    """Where a step begins.

    Attributes:
        x: coefficients, in units. [K, C]
        multipliers: of each sphere where it is nearest. [H, S]
        clearance: m.
        lacking: what is missing of the clearance, in largest moves, and passed of the caps.
        cost: of all.
    """

    x: Float[Array, "K C"]
    multipliers: Float[Array, "H S"]
    clearance: Float[Array, ""]
    lacking: Float[Array, ""]
    cost: Float[Array, ""]


@register()
@dataclass(frozen=True, kw_only=True)
class State:
    """Where the next step begins, the best one so far, how many there were, and how many of the
    last ones gained nothing."""

    x: Float[Array, "K C"]
    multipliers: Float[Array, "H S"]
    best: Step
    count: Int[Array, ""]
    idle: Int[Array, ""]


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

    def step(state: State) -> State:
        x, multipliers, best = state.x, state.multipliers, state.best
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
        soft, to_soft, used = soft_costs(
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
        size = x.reshape(-1) @ weight @ x.reshape(-1)
        missing = jnp.maximum(0.5 * problem.margin - least, 0.0) / problem.max_m
        lacking = missing + jnp.maximum(used - 0.995, 0.0)
        cost = lacking + SIZE * size + USED * used
        cost = jnp.where(jnp.isfinite(cost), cost, jnp.inf)
        here = Step(x=x, multipliers=multipliers, clearance=least, lacking=lacking, cost=cost)
        gained = cost < (1 - GAIN) * best.cost
        best = jax.tree.map(partial(jnp.where, cost < best.cost), here, best)
        back = ~(cost <= best.cost + SETBACK) | ~jnp.all(jnp.isfinite(change))
        after = jnp.where(back, best.x + BACK * (x - best.x), x + change.reshape(x.shape))
        return State(
            x=jnp.where(jnp.isfinite(after), after, best.x),
            multipliers=jnp.where(back, best.multipliers, jnp.clip(push, 0.0, MOST_PUSH)),
            best=best,
            count=state.count + 1,
            idle=jnp.where(gained, 0, state.idle + 1),
        )

    def goes_on(state: State) -> Array:
        enough = jnp.where(state.best.lacking <= 0, IDLE, LOST)
        return (state.count < ITERATIONS) & (state.idle < enough)

    zero = jnp.zeros((splines, channels), dtype=bases.dtype)
    none = jnp.zeros(rows.shape, dtype=bases.dtype)
    worst = jnp.asarray(jnp.inf, dtype=bases.dtype)
    best = Step(x=zero, multipliers=none, clearance=before, lacking=worst, cost=worst)
    count = jnp.zeros((), dtype=jnp.int32)
    begin = State(x=zero, multipliers=none, best=best, count=count, idle=count)
    best = jax.lax.while_loop(goes_on, step, begin).best
    return Solution(coefficients=best.x * unit[None], clearance=best.clearance, before=before)


solve_compiled = jax.jit(exported()(solve))
