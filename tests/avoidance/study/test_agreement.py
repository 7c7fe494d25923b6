"""Agreement worked by hand."""

import pytest

from mgjax.avoidance.study.agreement import between_observers, by_observer, with_search
from tests.avoidance.study.made import study_of

ONE = [0.004, 0.2, 0.05, 0.3, 1.1]


def test_with_the_search():
    """36 of 40 is the paper's share; Wilson's interval of it is 77 … 96 %."""
    study = study_of([[ONE] * 4] * 40, {"a": [0] * 36 + [1] * 4})
    found = with_search(study, study.picks)
    assert (found["agree"], found["picks"], found["trials"]) == (36, 40, 40)
    assert (found["share"], found["chance"]) == (0.9, 0.25)
    assert found["interval"] == [pytest.approx(0.7695, abs=1e-4), pytest.approx(0.9604, abs=1e-4)]


def test_several_observers_of_a_trial_are_no_more_trials():
    study = study_of([[ONE] * 2] * 10, {"a": [0] * 10, "b": [0] * 5 + [1] * 5})
    both = with_search(study, study.picks)
    assert (both["picks"], both["trials"], both["share"]) == (20, 10, 0.75)
    assert both["interval"][0] < 0.45
    alone = by_observer(study)
    assert {name: row["share"] for name, row in alone.items()} == {"a": 1.0, "b": 0.5}


def test_between_two_and_three_observers():
    two = study_of([[ONE] * 2] * 4, {"a": [0, 0, 1, 1], "b": [0, 0, 1, 0]})
    found = between_observers(two)
    assert found is not None
    assert (found["share"], found["kappa"]) == (0.75, 0.5)  # (0.75 − 0.5)/(1 − 0.5)
    three = study_of([[ONE] * 4] * 2, {"a": [0, 1], "b": [0, 2], "c": [0, 2]})
    found = between_observers(three)
    assert found is not None
    assert found["share"] == pytest.approx((1 + 1 / 3) / 2, abs=1e-4)
    assert found["kappa"] == pytest.approx((2 / 3 - 0.25) / 0.75, abs=1e-4)
    shares = {tuple(row["observers"]): row["share"] for row in found["pairs"]}
    assert shares == {("a", "b"): 0.5, ("a", "c"): 0.5, ("b", "c"): 1.0}


def test_one_observer_has_nobody_to_agree_with():
    assert between_observers(study_of([[ONE] * 2] * 3, {"a": [0, 1, 0]})) is None
