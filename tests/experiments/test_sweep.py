from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from experiments.avoidance import settings
from experiments.avoidance.calibrate import Config as Calibrate
from experiments.avoidance.calibrate import run as calibrate
from experiments.avoidance.graphs import built
from experiments.avoidance.sweep import AXES, Config, run
from experiments.avoidance.throws import OUTCOMES, answer, standard_throws
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.runs.points import Points
from mgjax.runs.record import flat, plain
from mgjax.runs.settings import resolve

pytestmark = pytest.mark.long


def test_defaults_are_the_same_everywhere_and_those_of_a_search() -> None:
    config = resolve(Config, smoke=True)
    points = Points()
    results = run(config, points)
    metrics = results.metrics
    default = metrics["default"]
    assert default["changed"] == default["gained"] == default["lost"] == 0
    wanted = answer(built(), standard_throws(config.balls, config.seed), AvoidanceConfig())
    for key in (*OUTCOMES, "avoided_by_kind", "candidates_mean"):
        assert default[key] == pytest.approx(wanted[key], nan_ok=True)
    usual = metrics["default_values"] | {"speed": "measured", "forms": "overlap, clamped"}
    for name in (*AXES, "T_window", "crop_radius_m", "speed", "forms"):
        row = next(row for row in metrics[name] if row["value"] == usual[name])
        assert {key: x for key, x in row.items() if key != "value"} == default
    tables = metrics["maps"]["E_avoidance, D_body"]
    at = [tables[name].index(usual[name]) for name in AXES[:2]]
    assert tables["avoided"][at[0]][at[1]] == default["avoided"]
    assert results.arrays["w_a, w_b/changed"].shape == (2, 2)
    assert np.isfinite(results.arrays["w_a, w_b/changed"]).all()
    assert set(default["saturated_candidates"]) == {"avoidance_0", "avoidance_1", "body_1"}
    measured = points.measured
    assert run(config, points).metrics == metrics
    assert (points.measured, points.resumed) == (measured, measured)


def test_settings_together_are_those_alone() -> None:
    """Also across scales of the energies, of which the largest bounds what is judged."""
    config = resolve(settings.Config, smoke=True)
    energy = config.avoidance.energy
    changes: list[dict[str, float]] = [{}, {"E_avoidance": 0.5}, {"E_time": 1.25}, {"E_time": 12.0}]
    configs = [
        replace(config, avoidance=replace(config.avoidance, energy=replace(energy, **change)))
        for change in changes
    ]
    together = [results.metrics for results in settings.run_together(configs)]
    assert together == [settings.run(config).metrics for config in configs]
    assert len({str(metrics) for metrics in together}) > 1
    assert set(settings.TRACED) <= set(flat(plain(asdict(config), "config")))


def test_calibration_is_of_clear_candidates() -> None:
    config = resolve(Calibrate, smoke=True)
    metrics = calibrate(config, Points()).metrics
    overlap, paper = (metrics["E_avoidance"][form] for form in ("overlap", "paper"))
    assert overlap["clear_candidates"] == paper["clear_candidates"] > 0
    # What only counts penetration is less than what counts every distance.
    assert overlap["p5_p50_p90_p95"][2] <= paper["p5_p50_p90_p95"][2]
    assert [row["V_slow"] for row in metrics["V_slow"]] == list(config.V_slow)
