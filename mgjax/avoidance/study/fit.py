"""Weights, E_avoidance and D_body that make observers' picks most likely, and how sure they are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import minimize

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.study.model import PARAMETERS, Trials, loss_and_slope

LARGEST_WEIGHT = 300.0
"""An observer with such a weight is never in doubt."""
QUANTILES = (0.15, 0.5, 0.9)
"""Of the values in the trials: where fits begin, as the loss has several minima in them."""
BEYOND = 4.0
"""D_body may be so many times the largest value that was seen."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """What is fitted.

    Attributes:
        trials, config: see :func:`mgjax.avoidance.study.model.loss`.
        low, high: bounds of the parameters; equal where the trials say nothing of one. [6]
        starts: values of E_avoidance and D_body at which fits begin.
    """

    trials: Trials
    config: EnergyConfig
    low: Float[np.ndarray, " 6"]
    high: Float[np.ndarray, " 6"]
    starts: list[tuple[float, float]]

    @cached_property
    def traced(self) -> EnergyConfig:
        """The settings as arrays, made once."""
        return jax.tree.map(jnp.float32, self.config)

    @property
    def free(self) -> Bool[np.ndarray, " 6"]:
        """Which parameters are fitted."""
        return self.high > self.low


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """The parameters that make the picks most likely.

    Attributes:
        vector: weights and logarithms; see :func:`mgjax.avoidance.study.model.loss`. [6]
        loss: there, nats.
    """

    vector: Float[np.ndarray, " 6"]
    loss: float

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name, E_avoidance in m·s and D_body in m, of an adult."""
        plain = [*self.vector[:4], *np.exp(self.vector[4:])]
        return dict(zip(PARAMETERS, map(float, plain), strict=True))


def problem_of(trials: Trials, config: EnergyConfig) -> Problem:
    """What can be fitted to trials.

    A weight whose energy never differs within a trial is 0, E_avoidance and D_body where nothing
    is measured for them are as the settings say. Below the smallest value of e' that is not 0 and
    above the largest, other E_avoidance change nothing that another w_a would not, so it stays
    between them; D_body likewise, up to four times the largest excess, from which on it hardly
    matters.
    """
    present = np.asarray(trials.present)
    moved = np.asarray(trials.measures.penetration, np.float64)
    clear = np.asarray(trials.measures.d, np.float64)
    frozen = np.asarray(trials.measures.d0, np.float64)
    excess = clear - (np.maximum(frozen, 0.0) if config.d0 == "clamped" else frozen)
    differs = [
        _differs(values, present)
        for values in (
            moved,
            np.maximum(excess, 0.0),
            np.asarray(trials.measures.displacement, np.float64),
            np.asarray(trials.measures.s_time, np.float64),
        )
    ]
    low, high = np.zeros(6), np.where([*differs, True, True], LARGEST_WEIGHT, 0.0)
    starts: list[list[float]] = []
    for place, values, known, beyond, used in (
        (4, moved, config.E_avoidance, 1.0, differs[0]),
        (5, excess, config.D_body, BEYOND, differs[1]),
    ):
        seen = values[present & (values > 1e-6)]
        if used and len(seen):
            low[place], high[place] = np.log(seen.min()), np.log(beyond * seen.max())
            starts.append(np.log(np.quantile(seen, QUANTILES)).tolist())
        else:
            low[place] = high[place] = np.log(float(known))
            starts.append([float(low[place])])
    pairs = [(e, d) for e, d in product(*starts)]
    return Problem(trials=trials, config=config, low=low, high=high, starts=pairs)


def _differs(values: Float[np.ndarray, "T K"], present: Bool[np.ndarray, "T K"]) -> bool:
    top = np.where(present, values, -np.inf).max(axis=1)
    return bool((top - np.where(present, values, np.inf).min(axis=1) > 1e-6).any())


def fit_picks(problem: Problem, counts: Float[np.ndarray, "T K"]) -> Fit:
    """The most likely parameters, from several beginnings."""
    fits = [
        descend(problem, counts, np.array([1.0, 1.0, 1.0, 1.0, *pair])) for pair in problem.starts
    ]
    return min(fits, key=lambda fit: fit.loss)


def descend(
    problem: Problem, counts: Float[np.ndarray, "T K"], start: Float[np.ndarray, " 6"]
) -> Fit:
    """A minimum of the loss within the bounds, by SLSQP.

    L-BFGS-B finds the same, and where other work is going on takes ten times as long.
    """
    picked = jnp.asarray(counts, jnp.float32)

    def value(vector: np.ndarray) -> tuple[float, np.ndarray]:
        found, slope = loss_and_slope(
            vector.astype(np.float32), problem.trials, picked, problem.traced
        )
        return float(found), np.asarray(slope, np.float64)

    start = np.clip(start, problem.low, problem.high)
    bounds = list(zip(problem.low, problem.high, strict=True))
    options = {"maxiter": 200, "ftol": 1e-6}
    found = minimize(value, start, jac=True, method="SLSQP", bounds=bounds, options=options)
    return Fit(vector=np.asarray(found.x, np.float64), loss=float(found.fun))
