"""What a study says: agreement, and the settings under which the search agrees most."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.energy.score import Measures
from mgjax.avoidance.study.agreement import between_observers, by_observer, with_search
from mgjax.avoidance.study.chance import ALPHA, foretold, held_out, p_value
from mgjax.avoidance.study.fit import Fit, Problem, fit_picks, problem_of
from mgjax.avoidance.study.intervals import intervals
from mgjax.avoidance.study.model import PARAMETERS, WEIGHTS, Trials, chance_loss
from mgjax.avoidance.study.reading import MEASURES, Study

LEAST_TRIALS = 10
"""With fewer, nothing is fitted."""


def report(study: Study) -> tuple[dict[str, Any], EnergyConfig | None]:
    """All figures as JSON values, and the fitted settings where there is something to fit."""
    trials, counts = arrays(study)
    result: dict[str, Any] = {
        "agreement": with_search(study, study.picks),
        "observers": by_observer(study),
        "between_observers": between_observers(study),
    }
    if len(counts) < LEAST_TRIALS:
        why = f"{len(counts)} trials, at least {LEAST_TRIALS} are needed"
        return result | {"fit": {"status": "nothing to fit", "why": why}}, None
    problem = problem_of(trials, study.settings)
    p = p_value(problem, counts)
    if p >= ALPHA:
        why = f"picks at random are fitted as well (p = {p:.3f})"
        return result | {"fit": {"status": "nothing to fit", "why": why, "p": p}}, None
    best = fit_picks(problem, counts)
    config = fitted_settings(problem, best)
    fit = _fit_json(problem, counts, best) | {"p": p}
    fit["settings"] = {name: float(getattr(config, name)) for name in PARAMETERS}
    return result | {"fit": fit}, config


def arrays(study: Study) -> tuple[Trials, Float[np.ndarray, "T K"]]:
    """The trials that somebody picked in, and how many picked each candidate."""
    picked = {pick.trial for pick in study.picks}
    names = [name for name in study.trials if name in picked]
    known = [study.trials[name] for name in names]
    most = max(len(trial.measures) for trial in known)
    values = np.zeros((len(MEASURES), len(known), most), np.float32)
    values[-1] = 1.0
    present = np.zeros((len(known), most), bool)
    for row, trial in enumerate(known):
        values[:, row, : len(trial.measures)] = np.array(trial.measures).T
        present[row, : len(trial.measures)] = True
    counts = np.zeros(present.shape)
    for pick in study.picks:
        counts[names.index(pick.trial), pick.place] += 1
    measures = Measures(**dict(zip(MEASURES, map(jnp.asarray, values), strict=True)))
    return Trials(measures=measures, present=jnp.asarray(present)), counts


def fitted_settings(problem: Problem, fit: Fit) -> EnergyConfig:
    """The settings with what was fitted; weights add up to what they did.

    Only the ratios of weights decide which candidate is chosen.
    """
    total = sum(float(getattr(problem.config, name)) for name in WEIGHTS)
    values = fit.values
    scale = (total or 1.0) / max(sum(values[name] for name in WEIGHTS), 1e-9)
    for name in WEIGHTS:
        values[name] *= scale
    return replace(problem.config, **values)


def _fit_json(problem: Problem, counts: Float[np.ndarray, "T K"], best: Fit) -> dict[str, Any]:
    ends = intervals(problem, counts, best)
    everything = np.ones(len(counts), bool)
    rows: dict[str, Any] = {}
    for place, name in enumerate(PARAMETERS):
        low, high = ends[name]
        free = bool(problem.free[place])
        rows[name] = {
            "value": best.values[name],
            "low": low if free and low > 0 else None,
            "high": high if free and math.isfinite(high) else None,
            "fitted": free,
        }
    return {
        "status": "fitted",
        "parameters": rows,
        "gain_nats": round(chance_loss(problem.trials, counts) - best.loss, 4),
        "agreement": round(foretold(problem, best.vector, counts, everything) / counts.sum(), 4),
        "held_out_agreement": round(held_out(problem, counts), 4),
    }
