"""The choice model against its definition, by hand, and its slopes."""

from __future__ import annotations

import math
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.avoidance.config import EnergyConfig
from mgjax.avoidance.study.model import chance_loss, log_probabilities, loss, loss_and_slope
from mgjax.avoidance.study.report import arrays
from tests.avoidance.study.made import drawn_measures, picks_of, study_of
from tests.reference import study as reference

VECTOR = np.array([3.0, 2.0, 1.5, 4.0, math.log(0.007), math.log(0.22)])


@pytest.fixture(scope="module")
def drawn():
    measured = drawn_measures(30, seed=1)
    picks = picks_of(measured, seed=2)
    return measured, *arrays(study_of(measured, {"a": picks, "b": picks_of(measured, seed=3)}))


def test_the_loss_is_that_of_the_definition(drawn):
    measured, trials, counts = drawn
    expected = reference.loss(measured, counts.tolist(), VECTOR.tolist())
    found = loss(jnp.asarray(VECTOR, jnp.float32), trials, jnp.asarray(counts), EnergyConfig())
    assert float(found) == pytest.approx(expected, rel=1e-5)


def test_two_candidates_by_hand():
    energies = jnp.asarray([[math.log(3.0), 0.0, 7.0]])
    found = np.exp(log_probabilities(energies, jnp.asarray([[True, True, False]])))
    np.testing.assert_allclose(found, [[0.25, 0.75, 1.0]], rtol=1e-6)


def test_slopes_are_those_of_differences(drawn):
    measured, trials, counts = drawn
    vector = jnp.asarray(VECTOR, jnp.float32)
    value, slope = loss_and_slope(vector, trials, jnp.asarray(counts), EnergyConfig())
    eager = loss(vector, trials, jnp.asarray(counts), EnergyConfig())
    assert float(value) == pytest.approx(float(eager), rel=1e-6)
    for place in range(6):
        step = np.eye(6)[place] * 1e-5
        ends = [
            reference.loss(measured, counts.tolist(), (VECTOR + s * step).tolist()) for s in (1, -1)
        ]
        assert float(slope[place]) == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-3, abs=2e-3)


def test_candidates_that_are_the_same_tell_nothing():
    same = [[[0.004, 0.2, 0.05, 0.3, 1.1]] * 3] * 4
    trials, counts = arrays(study_of(same, {"a": [0, 1, 2, 0]}))
    value, slope = loss_and_slope(
        jnp.asarray(VECTOR, jnp.float32), trials, jnp.asarray(counts), EnergyConfig()
    )
    assert float(value) == pytest.approx(4 * math.log(3), rel=1e-6)
    assert chance_loss(trials, counts) == pytest.approx(4 * math.log(3))
    np.testing.assert_allclose(np.asarray(slope), 0.0, atol=1e-5)


def test_padding_changes_nothing(drawn):
    _, trials, counts = drawn
    wide = replace(
        trials,
        measures=replace(
            trials.measures,
            **{
                name: jnp.pad(getattr(trials.measures, name), ((0, 0), (0, 2)))
                for name in ("penetration", "d", "d0", "displacement", "s_time")
            },
        ),
        present=jnp.pad(trials.present, ((0, 0), (0, 2))),
    )
    vector = jnp.asarray(VECTOR, jnp.float32)
    more = jnp.asarray(np.pad(counts, ((0, 0), (0, 2))))
    one = loss_and_slope(vector, trials, jnp.asarray(counts), EnergyConfig())
    other = loss_and_slope(vector, wide, more, EnergyConfig())
    np.testing.assert_allclose(one[0], other[0], rtol=1e-6)
    np.testing.assert_allclose(one[1], other[1], rtol=1e-4, atol=1e-4)
    assert np.isfinite(np.asarray(other[1])).all()
