"""A softmax model of what observers pick, by the energies of eqs 6–10.

An observer picks candidate i of a trial with probability

    P(i) = exp(−e_i) / Σ_j exp(−e_j)
    e = w_a e_avoidance + w_b e_body + w_m e_move + w_t e_timescale

(McFadden 1974). How consistently observers pick is in the size of the weights: twice the weights
are the same preferences with half the noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.score import Measures, score
from mgjax.core.arrays import Array
from mgjax.core.xla.pytree import register

WEIGHTS = ("w_a", "w_b", "w_m", "w_t")
PARAMETERS = (*WEIGHTS, "E_avoidance", "D_body")
"""What is fitted, in the order in which vectors have it."""


@register()
@dataclass(frozen=True, kw_only=True)
class Trials:
    """What is known of the candidates of trials, padded.

    Attributes:
        measures: of an adult's size. [T, K]
        present: whether there is such a candidate; at least one in each trial. [T, K]
    """

    measures: Measures
    present: Bool[Array, "T K"]

    @property
    def sizes(self) -> Float[np.ndarray, " T"]:
        """Candidates of each trial."""
        return np.asarray(self.present).sum(axis=1).astype(np.float64)


def terms(
    trials: Trials,
    config: EnergyConfig,
    E_avoidance: Float[Array, ""] | float,
    D_body: Float[Array, ""] | float,
) -> Float[Array, "T K 4"]:
    """The energies that the weights are applied to, in the order of ``WEIGHTS``."""
    scores = score(trials.measures, replace(config, E_avoidance=E_avoidance, D_body=D_body))
    return jnp.stack([scores.avoidance, scores.body, scores.movement, scores.timescale], axis=-1)


def log_probabilities(
    energies: Float[Array, "T K"], present: Bool[Array, "T K"]
) -> Float[Array, "T K"]:
    """log P of each candidate; 0 where there is none."""
    logits = jnp.where(present, -energies, -jnp.inf)
    return jnp.where(present, -energies - jax.nn.logsumexp(logits, axis=1, keepdims=True), 0.0)


def loss(
    parameters: Float[Array, " 6"],
    trials: Trials,
    counts: Float[Array, "T K"],
    config: EnergyConfig,
) -> Float[Array, ""]:
    """−log likelihood of picks, in nats.

    Args:
        parameters: the weights, and the logarithms of E_avoidance and D_body.
        trials: the trials.
        counts: how many picked each candidate; 0 where there is none.
        config: the other settings of the energies.
    """
    parts = terms(trials, config, jnp.exp(parameters[4]), jnp.exp(parameters[5]))
    return -jnp.sum(counts * log_probabilities(parts @ parameters[:4], trials.present))


loss_and_slope = jax.jit(jax.value_and_grad(loss))
"""The loss, and its slope in the parameters."""


@jax.jit
def energies_of(
    parameters: Float[Array, " 6"], trials: Trials, config: EnergyConfig
) -> Float[Array, "T K"]:
    """e of each candidate; infinite where there is none."""
    parts = terms(trials, config, jnp.exp(parameters[4]), jnp.exp(parameters[5]))
    return jnp.where(trials.present, parts @ parameters[:4], jnp.inf)


def chance_loss(trials: Trials, counts: Float[np.ndarray, "T K"]) -> float:
    """The loss of an observer to whom all candidates are the same."""
    return float(counts.sum(axis=1) @ np.log(trials.sizes))
