"""Picks by known weights give these back; picks at random give nothing."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.avoidance.study.chance import held_out, p_value
from mgjax.avoidance.study.fit import fit_picks, problem_of
from mgjax.avoidance.study.intervals import intervals
from mgjax.avoidance.study.model import PARAMETERS, chance_loss
from mgjax.avoidance.study.report import arrays, report
from tests.avoidance.study.made import TRUTH, drawn_measures, picks_of, study_of

SETS = 2
"""Of known weights; all of one size, so that compiled code is shared."""
TRIALS = 120


def made(seed: int, *, random: bool = False):
    measured = drawn_measures(TRIALS, seed)
    return study_of(measured, {"a": picks_of(measured, seed + 100, random=random)})


def test_known_weights_come_back_within_their_intervals():
    """Of twelve 95 % intervals at most one may miss by chance (P of more: 12 %)."""
    within: list[bool] = []
    for seed in range(SETS):
        study = made(seed)
        trials, counts = arrays(study)
        problem = problem_of(trials, study.settings)
        best = fit_picks(problem, counts)
        assert best.loss < chance_loss(trials, counts)
        for name, (low, high) in intervals(problem, counts, best).items():
            assert low <= best.values[name] <= high
            within.append(low <= TRUTH[name] <= high)
            assert high / max(low, 1e-9) < 100, (name, low, high)
    assert sum(within) >= len(within) - 1, within


def test_a_preference_is_found_and_foretells_picks_held_out():
    result, config = report(made(5))
    fit = result["fit"]
    assert fit["status"] == "fitted"
    assert fit["p"] <= 0.01
    assert fit["held_out_agreement"] > result["agreement"]["chance"] + 0.2
    assert config is not None
    settings = [getattr(config, name) for name in PARAMETERS]
    assert fit["settings"] == dict(zip(PARAMETERS, settings, strict=True))
    assert sum(settings[:4]) == pytest.approx(6.0), "as heavy as the defaults"


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_random_picks_leave_nothing_to_fit(seed):
    result, config = report(made(seed, random=True))
    assert result["fit"]["status"] == "nothing to fit"
    assert "picks at random" in result["fit"]["why"]
    assert config is None


def test_few_trials_leave_nothing_to_fit():
    measured = drawn_measures(9, seed=0)
    result, config = report(study_of(measured, {"a": [0] * 9}))
    assert result["fit"]["status"] == "nothing to fit"
    assert "9 trials" in result["fit"]["why"]
    assert config is None


def test_what_the_trials_do_not_tell_is_not_fitted():
    """No displacement measured, the same speed everywhere, and nothing moved out of the way."""
    measured = [
        [[0.0, c[1], c[2], 0.0, 1.0] for c in candidates]
        for candidates in drawn_measures(TRIALS, seed=3)
    ]
    study = study_of(measured, {"a": picks_of(measured, seed=4)})
    trials, counts = arrays(study)
    problem = problem_of(trials, study.settings)
    assert problem.free.tolist() == [False, True, False, False, False, True]
    best = fit_picks(problem, counts)
    assert best.values["w_a"] == best.values["w_m"] == best.values["w_t"] == 0.0
    assert best.values["E_avoidance"] == pytest.approx(float(study.settings.E_avoidance))
    ends = intervals(problem, counts, best)
    assert ends["E_avoidance"] == (0.0, np.inf)
    assert ends["w_b"][0] > 0


def test_an_observer_without_a_doubt_has_open_intervals():
    """Who always picks the least movement: how much it weighs has no upper end."""
    measured = drawn_measures(TRIALS, seed=6)
    picks = [int(np.argmin([c[3] for c in candidates])) for candidates in measured]
    study = study_of(measured, {"a": picks})
    trials, counts = arrays(study)
    problem = problem_of(trials, study.settings)
    best = fit_picks(problem, counts)
    low, high = intervals(problem, counts, best)["w_m"]
    assert low > 5
    assert high == np.inf
    assert held_out(problem, counts) > 0.9
    assert p_value(problem, counts) == pytest.approx(1 / 200)
