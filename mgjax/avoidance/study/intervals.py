"""How sure fitted parameters are: profile likelihood, calibrated by simulated observers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mgjax.avoidance.study.fit import Fit, Problem, descend, fit_picks
from mgjax.avoidance.study.model import PARAMETERS, WEIGHTS, energies_of

SIMULATED = 40
"""Observers; each tells of all parameters."""
_CHI_SQUARE = 3.841459
"""95 % quantile of χ² with one degree of freedom."""
_REFINEMENTS = 3


def intervals(
    problem: Problem, counts: Float[np.ndarray, "T K"], best: Fit, *, seed: int = 0
) -> dict[str, tuple[float, float]]:
    """95 % intervals of the parameters by profile likelihood.

    A value belongs to the interval if the others can be fitted so that the deviance, twice the loss
    above the least, is at most :func:`largest_deviance`. Where that holds up to a bound the trials
    do not limit the parameter on that side: the end is 0 or infinite. The picks count as
    independent.
    """
    limit = float(np.sqrt(largest_deviance(problem, counts, best, seed=seed)))
    found: dict[str, tuple[float, float]] = {}
    for place, name in enumerate(PARAMETERS):
        low, high = (_end(problem, counts, best, place, side, limit) for side in (-1, 1))
        found[name] = (low, high) if name in WEIGHTS else (float(np.exp(low)), float(np.exp(high)))
    return found


def largest_deviance(
    problem: Problem, counts: Float[np.ndarray, "T K"], best: Fit, *, seed: int = 0
) -> float:
    """The deviance that the true value of a parameter exceeds in 5 % of the studies.

    With many picks that is 3.84, the quantile of χ² with one degree of freedom; where six
    parameters are fitted to 40, it is more. So it is that quantile over simulated observers who
    pick by the fit, all parameters together, and at least 3.84.
    """
    rng = np.random.default_rng(seed)
    energy = np.asarray(
        energies_of(best.vector.astype(np.float32), problem.trials, problem.config), np.float64
    )
    share = np.exp(energy.min(axis=1, keepdims=True) - energy)
    share /= share.sum(axis=1, keepdims=True)
    picks = counts.sum(axis=1).astype(np.int64)
    found: list[float] = []
    for _ in range(SIMULATED):
        drawn = rng.multinomial(picks, share).astype(np.float64)
        known = descend(problem, drawn, best.vector)
        fit = min(fit_picks(problem, drawn), known, key=lambda fit: fit.loss)
        for place in np.flatnonzero(problem.free):
            value = float(best.vector[place])
            held = _profile(
                problem, drawn, int(place), value, (best.vector, fit.vector), again=False
            )
            found.append(_root_deviance(held, fit) ** 2)
    return max(_CHI_SQUARE, float(np.quantile(found, 0.95))) if found else _CHI_SQUARE


def _end(
    problem: Problem,
    counts: Float[np.ndarray, "T K"],
    best: Fit,
    place: int,
    side: int,
    limit: float,
) -> float:
    """The end of an interval; in the parameter's own form, infinite where it is open."""
    bound = float((problem.low if side < 0 else problem.high)[place])
    is_weight = place < len(WEIGHTS)
    # At the lower bound of a weight the energy is left out, which is a value like any other.
    beyond = 0.0 if is_weight and side < 0 else side * np.inf
    inside, last = float(best.vector[place]), best.vector
    if not problem.free[place]:
        return beyond
    step = max(0.25 * inside, 0.25) if is_weight else 0.25
    nearer, farther = 0.0, 0.0
    while True:
        outside = inside + side * step
        at_bound = (outside - bound) * side >= 0
        outside = bound if at_bound else outside
        fit = _profile(problem, counts, place, outside, (last, best.vector))
        farther = _root_deviance(fit, best)
        if farther > limit:
            break
        if at_bound:
            return beyond
        inside, last, nearer, step = outside, fit.vector, farther, 1.5 * step
    # The root of the deviance is nearly straight in the parameter.
    for _ in range(_REFINEMENTS):
        share = (limit - nearer) / max(farther - nearer, 1e-9)
        middle = inside + float(np.clip(share, 0.05, 0.95)) * (outside - inside)
        fit = _profile(problem, counts, place, middle, (last,), again=False)
        value = _root_deviance(fit, best)
        if value > limit:
            outside, farther = middle, value
        else:
            inside, last, nearer = middle, fit.vector, value
    share = (limit - nearer) / max(farther - nearer, 1e-9)
    return inside + share * (outside - inside)


def _root_deviance(fit: Fit, best: Fit) -> float:
    return float(np.sqrt(max(2 * (fit.loss - best.loss), 0.0)))


def _profile(
    problem: Problem,
    counts: Float[np.ndarray, "T K"],
    place: int,
    value: float,
    known: tuple[Float[np.ndarray, " 6"], ...],
    *,
    again: bool = True,
) -> Fit:
    """The best fit with one parameter held, from those known and, again, from all beginnings."""
    low, high = problem.low.copy(), problem.high.copy()
    low[place] = high[place] = value
    held = replace(problem, low=low, high=high)
    pairs = problem.starts if again else []
    starts = [*known, *(np.array([*known[-1][:4], *pair]) for pair in pairs)]
    return min((descend(held, counts, start) for start in starts), key=lambda fit: fit.loss)
