"""Differential updates (eqs 7–8): small changes of the launch that close the miss."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Bool, Float, Int

from mgjax.ballsport.aiming.problem import AimProblem, Launch, arrive
from mgjax.core.arrays import Array

MOST_UPDATES = 16
"""Trials, rejected ones included."""

CLOSE = 1e-5
"""Miss at which the updates stop, m: about five times what float32 resolves over 20 m."""

_SMALLEST_STEP = 1 / 100
"""ε below which the updates give up."""

_CG_STEPS = 4
"""Three equations: three in exact arithmetic, one more for rounding."""

SECOND = 5.0
"""A second of flight time in the norm of a step, m/s²."""


class Updated(NamedTuple):
    """Attributes: the launch, its miss vector, whether it has the wanted bounces, trials made."""

    launch: Launch
    miss: Float[Array, "3"]
    kept: Bool[Array, ""]
    trials: Int[Array, ""]


class _State(NamedTuple):
    x: Float[Array, "4"]
    miss: Float[Array, "3"]
    jacobian: Float[Array, "3 4"]
    kept: Bool[Array, ""]
    epsilon: Float[Array, ""]
    trials: Int[Array, ""]


def differential_updates(
    problem: AimProblem, launch: Launch, bounces: int, most: int | Int[Array, ""] = MOST_UPDATES
) -> Updated:
    """Changes a launch until the ball meets the target (Choi et al. 2019, eqs 7–8).

    Each step is the smallest change of (v, ``SECOND`` · T) that closes the linearised miss:
    J W⁻¹ Jᵀ λ = −miss is solved by conjugate gradients, δ = W⁻¹ Jᵀ λ, with ∂S/∂u by automatic
    differentiation through the bounces. ε = 1 is halved until the miss shrinks and the bounces are
    kept; after a step it is 1 again.

    Args:
        problem: what is asked.
        launch: where to begin.
        bounces: wanted.
        most: trials.
    """
    inverse = jnp.array([1.0, 1.0, 1.0, SECOND**-2], jnp.float32)

    def missed(x: Array) -> tuple[Array, tuple[Array, Array]]:
        return arrive(problem, Launch(x[:3], x[3]), bounces)

    linearised = jax.jacfwd(missed, has_aux=True)

    def wanting(s: _State) -> Array:
        far = jnp.sum(s.miss**2) > CLOSE**2
        return (far | ~s.kept) & (s.epsilon > _SMALLEST_STEP) & (s.trials < most)

    def trial(s: _State) -> _State:
        dual = _conjugate_gradients(s.jacobian, inverse, -s.miss)
        step = inverse * jnp.sum(s.jacobian * dual[:, None], axis=0)
        x = s.x + s.epsilon * step
        jacobian, (miss, kept) = linearised(x)
        better = (jnp.sum(miss**2) < jnp.sum(s.miss**2)) & (kept | ~s.kept)
        epsilon = jnp.where(better, 1.0, s.epsilon / 2)
        new = _State(x, miss, jacobian, kept, epsilon, s.trials + 1)
        old = s._replace(epsilon=epsilon, trials=s.trials + 1)
        return jax.tree.map(lambda a, b: jnp.where(better, a, b), new, old)

    x = jnp.concatenate([launch.velocity, launch.time[None]])
    jacobian, (miss, kept) = linearised(x)
    one, none = jnp.ones((), jnp.float32), jnp.zeros((), jnp.int32)
    s = lax.while_loop(wanting, trial, _State(x, miss, jacobian, kept, one, none))
    return Updated(Launch(s.x[:3], s.x[3]), s.miss, s.kept, s.trials)


def _conjugate_gradients(
    jacobian: Float[Array, "3 4"], inverse: Float[Array, "4"], right: Float[Array, "3"]
) -> Float[Array, "3"]:
    """λ with J W⁻¹ Jᵀ λ = right."""
    matrix = jnp.sum(jacobian[:, None] * (inverse[None] * jacobian)[None], axis=-1)
    x, r = jnp.zeros_like(right), right
    p, rr = r, jnp.sum(r * r)
    for _ in range(_CG_STEPS):
        q = jnp.sum(matrix * p[None], axis=-1)
        curvature = jnp.sum(p * q)
        alpha = rr / jnp.where(curvature > 0, curvature, jnp.inf)
        x, r = x + alpha * p, r - alpha * q
        new = jnp.sum(r * r)
        p = r + new / jnp.where(rr > 0, rr, jnp.inf) * p
        rr = new
    return x
