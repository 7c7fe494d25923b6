"""Whether picks can be told from picks at random, and how well a fit foretells others."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.study.fit import Problem, fit_picks
from mgjax.avoidance.study.model import energies_of, log_probabilities, terms
from mgjax.core.arrays import Array

SIMULATED = 199
"""Sets of random picks that the real ones are compared with."""
ALPHA = 0.05
FOLDS = 5
_STEPS = 150


def p_value(problem: Problem, counts: Float[np.ndarray, "T K"], *, seed: int = 0) -> float:
    """How often random picks are fitted as well as these; below ``ALPHA`` there is a preference.

    A likelihood-ratio test against an observer who picks each candidate of a trial equally often.
    Weights are at least 0, and without them E_avoidance and D_body mean nothing, so the statistic
    has no χ² distribution: it is compared with its own on simulated random picks (Monte Carlo
    test, Barnard 1963). For all of them weights are fitted on a grid of E_avoidance and D_body.
    """
    trials = problem.trials
    rng = np.random.default_rng(seed)
    share = np.asarray(trials.present, np.float64) / trials.sizes[:, None]
    picks = counts.sum(axis=1).astype(np.int64)
    drawn = rng.multinomial(picks, share, size=(SIMULATED, len(picks)))
    every = jnp.asarray(np.concatenate([counts[None], drawn]), jnp.float32)
    parts = jnp.stack(
        [terms(trials, problem.config, np.exp(e), np.exp(d)) for e, d in problem.starts]
    )
    losses = np.asarray(_least_losses(parts, trials.present, every))
    return float((1 + (losses[1:] <= losses[0] + 1e-3).sum()) / (1 + SIMULATED))


@jax.jit
def _least_losses(
    parts: Float[Array, "G T K 4"], present: Bool[Array, "T K"], counts: Float[Array, "S T K"]
) -> Float[Array, " S"]:
    """The least loss of each set of picks over the grid; accelerated projected gradients."""

    def fit(parts: Array, counts: Array) -> Array:
        mean = jnp.sum(jnp.where(present[..., None], parts, 0.0), axis=1, keepdims=True)
        mean = mean / jnp.sum(present.astype(jnp.float32), axis=1)[:, None, None]
        centred = jnp.where(present[..., None], parts - mean, 0.0)
        size = jnp.sqrt(jnp.sum(centred**2, axis=(0, 1)) + 1e-9)
        scaled = centred / size[None, None, :]
        # Böhning's bound on the curvature: half the spread of the energies, once for each pick.
        picks = jnp.sum(counts, axis=1)
        rate = 1.0 / (0.5 * jnp.sum(picks[:, None, None] * scaled**2) + 1e-6)

        def loss(weights: Array) -> Array:
            return -jnp.sum(counts * log_probabilities(scaled @ weights, present))

        def step(_: Array, state: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
            weights, ahead, t = state
            new = jnp.maximum(ahead - rate * jax.grad(loss)(ahead), 0.0)
            later = 0.5 * (1 + jnp.sqrt(1 + 4 * t * t))
            return new, new + (t - 1) / later * (new - weights), later

        zero = jnp.zeros(4, jnp.float32)
        weights = jax.lax.fori_loop(0, _STEPS, step, (zero, zero, jnp.float32(1.0)))[0]
        return loss(weights)

    def least(counts: Array) -> Array:
        return jnp.min(jax.vmap(lambda part: fit(part, counts))(parts))

    return jax.lax.map(least, counts)


def held_out(problem: Problem, counts: Float[np.ndarray, "T K"], *, seed: int = 0) -> float:
    """Share of the picks that fits to the picks of other trials foretell, by cross-validation.

    Trials are dealt into five parts, all picks of a trial into one. Of candidates that a fit finds
    equally good each counts for its share.
    """
    rng = np.random.default_rng(seed)
    fold = rng.permutation(np.arange(len(counts)) % min(FOLDS, len(counts)))
    agreeing = 0.0
    for part in np.unique(fold):
        others = counts * (fold != part)[:, None]
        agreeing += foretold(problem, fit_picks(problem, others).vector, counts, fold == part)
    return agreeing / float(counts.sum())


def foretold(
    problem: Problem,
    vector: Float[np.ndarray, " 6"],
    counts: Float[np.ndarray, "T K"],
    which: np.ndarray,
) -> float:
    """How many picks of some trials are the candidate of the least energy."""
    found = energies_of(jnp.asarray(vector, jnp.float32), problem.trials, problem.config)
    energy = np.asarray(found)
    best = energy <= energy.min(axis=1, keepdims=True) + 1e-5
    return float((counts * best / best.sum(axis=1, keepdims=True))[which].sum())
