from __future__ import annotations

from dataclasses import fields, replace

import chex
import jax
import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.energy.evaluate import (
    Judged,
    judge,
)
from mgjax.avoidance.energy.score import Energy, Measures, Scores
from mgjax.avoidance.many.lazy_checks import score_attack
from mgjax.avoidance.many.reweight import Certainty, Picked, pick, pick_each, reweight
from mgjax.avoidance.many.settings import sweep_energies
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.timing.time_scale import NOT_ADJUSTABLE, OK, OUT_OF_RANGE, Timing
from mgjax.core.errors import AttackError, ConfigError
from mgjax.graph.types import MotionGraph
from tests.avoidance.made import throw

CLEAR, TOUCHED, _ = Certainty

GRID = [
    EnergyConfig(),
    EnergyConfig(E_avoidance=1e-3),
    EnergyConfig(E_avoidance=0.5, D_body=0.05),
    EnergyConfig(D_body=2.0, E_time=1.3),
    EnergyConfig(w_a=0.0, w_t=3.0),
    EnergyConfig(w_b=0.0, w_t=0.0, E_time=8.0),
    EnergyConfig(w_m=0.0, w_speed_up=1.0, E_fast=1.3),
    EnergyConfig(D_move=0.1, w_speed_up=20.0),
]


def made_judged() -> Judged:
    """Four candidates: both scaled and not, one that is touched by its samples, one not timed."""

    def row(*values: float) -> np.ndarray:
        return np.array(values, np.float32)

    timing = Timing(
        s_time=row(2.0, 1.0, 0.5, 1.0),
        scales=np.ones((4, 1), np.float32),
        status=np.array([OK, OK, OK, NOT_ADJUSTABLE], np.int32),
    )
    zero = np.zeros(4, np.float32)
    measures = Measures(
        penetration=row(0.02, 0.0, 0.005, 1.0),
        d=row(0.25, 0.6, -0.1, 0.3),
        d0=row(-0.1, 0.1, -0.2, 0.0),
        displacement=row(0.3, 0.0, 0.6, 0.15),
        s_time=timing.s_time,
    )
    scores = Scores(total=zero, avoidance=zero, body=zero, movement=zero, timescale=zero)
    return Judged(timing=timing, measures=measures, scores=scores)


def test_by_hand() -> None:
    config = EnergyConfig(
        E_avoidance=0.01, D_body=0.5, D_move=0.3, E_time=4.0,
        w_a=1.0, w_b=2.0, w_m=2.0, w_t=3.0, w_speed_up=2.0,
    )  # fmt: skip
    got = reweight(made_judged(), config, limit_scale=True)
    np.testing.assert_allclose(got.scores.avoidance, [0, 1, 0.5, 0], atol=1e-6)
    np.testing.assert_allclose(got.scores.body, [0.5, 1, 1, 0.6], atol=1e-6)
    np.testing.assert_allclose(got.scores.movement, [1, 0, 2, 0.5], atol=1e-6)
    np.testing.assert_allclose(got.scores.timescale, [0.5, 0.25, 0.75, 0.25], atol=1e-6)
    np.testing.assert_allclose(got.scores.total, [4.5, 3.75, 8.75, 2.95], atol=1e-6)
    alike = reweight(made_judged(), replace(config, w_speed_up=1.0), limit_scale=True)
    np.testing.assert_allclose(alike.scores.timescale, [0.5, 0.25, 0.5, 0.25], atol=1e-6)
    literal = reweight(made_judged(), replace(config, d0="paper"), limit_scale=True)
    np.testing.assert_allclose(literal.scores.body, [0.7, 1, 0.2, 0.6], atol=1e-6)
    narrow = replace(config, E_time=1.5)
    status = [OUT_OF_RANGE, OK, OUT_OF_RANGE, NOT_ADJUSTABLE]
    assert reweight(made_judged(), narrow, limit_scale=True).timing.status.tolist() == status
    status = [OK, OK, OUT_OF_RANGE, NOT_ADJUSTABLE]
    slow = replace(config, E_fast=1.5)
    assert reweight(made_judged(), slow, limit_scale=True).timing.status.tolist() == status
    status = [OK, OK, OK, NOT_ADJUSTABLE]
    assert reweight(made_judged(), slow, limit_scale=False).timing.status.tolist() == status
    assert reweight(made_judged(), narrow, limit_scale=False).timing.status.tolist() == status


@pytest.mark.parametrize(
    ("certainties", "checks", "number"),
    [
        ([CLEAR, CLEAR, CLEAR, CLEAR], 9, 0),
        ([TOUCHED, CLEAR, CLEAR, CLEAR], 9, 1),
        (
            [TOUCHED, TOUCHED, CLEAR, CLEAR],
            2,
            1,
        ),  # the nearer to clear of those looked at
        (
            [TOUCHED, TOUCHED, CLEAR, CLEAR],
            9,
            1,
        ),  # the third is touched too deep by its samples
    ],
)
def test_what_is_picked(certainties: list[int], checks: int, number: int) -> None:
    certainty = np.array(certainties, np.int32)
    clearance = np.array([-0.3, -0.2, -0.1, 0.9], np.float32)
    config = EnergyConfig(E_avoidance=0.01, D_body=0.5, w_m=0.0)
    got = pick(made_judged(), certainty, clearance, config, limit_scale=True, checks=checks)
    assert int(got.number) == number
    assert (int(got.usable), int(got.apart)) == (3, 2)
    assert got.saturated.tolist() == [1, 1, 1]
    nothing = replace(config, E_time=1.0)
    twice = np.full(4, 2.0, np.float32)
    judged = made_judged()
    judged = replace(
        judged,
        timing=replace(judged.timing, s_time=twice),
        measures=replace(judged.measures, s_time=twice),
    )
    none = pick(judged, certainty, clearance, nothing, limit_scale=True, checks=checks)
    assert (int(none.number), int(none.usable)) == (-1, 0)


def test_energies_are_those_of_a_search_with_the_setting(any_graph: MotionGraph) -> None:
    rng = np.random.default_rng(3)
    config = AvoidanceConfig(limit_scale=False)
    prepared = prepared_for(any_graph, config)
    device = prepared.device
    rate = any_graph.frame_rate
    seen = 0
    while seen < 2:
        attack, node = throw(rng), int(rng.integers(any_graph.num_nodes))
        query = ask(prepared, node, attack, config)
        assert query is not None
        found, crop = query.in_time, query.crop
        if not 8 < len(found.length) <= 128:
            continue
        seen += 1
        judged = score_attack(query, "overlap", 8.0).judged
        for energy in [*GRID, replace(GRID[2], d0="paper")]:
            limited = replace(config, energy=energy, limit_scale=True)
            wanted = judge(
                device, found, attack, crop, limited, frame_rate=rate, unmoved=query.unmoved
            )
            got = reweight(judged, energy, limit_scale=True)
            count = len(found.length)
            assert np.array_equal(got.timing.status[:count], wanted["status"])
            usable = wanted["status"] == OK
            for name, values in {
                "avoidance": got.scores.avoidance,
                "body": got.scores.body,
                "timescale": got.scores.timescale,
                "total": got.scores.total,
            }.items():
                close = np.asarray(values)[:count][usable]
                np.testing.assert_allclose(close, wanted[name][usable], rtol=1e-5, atol=1e-5)


# The graph of capture takes the same way through other shapes, half a minute of compiling.
@pytest.mark.parametrize(
    "any_graph", ["made", pytest.param("real", marks=pytest.mark.long)], indirect=True
)
def test_each_answer_is_that_of_a_search(any_graph: MotionGraph) -> None:
    rng = np.random.default_rng(5)
    seen = set()
    for number in range(10):
        attack, node = throw(rng), int(rng.integers(any_graph.num_nodes))
        kind = "clamped" if number % 2 else "paper"
        grid = [replace(energy, d0=kind) for energy in GRID]
        config = AvoidanceConfig(
            limit_scale=number % 5 > 0, checks=8 if number % 3 else 64, T_wide=0.0, refine="off"
        )
        got = sweep_energies(any_graph, node, attack, grid, config=config)
        for g, energy in enumerate(grid):
            wanted = choose(any_graph, node, attack, config=replace(config, energy=energy))
            seen.add(wanted.status)
            assert tuple(Status)[got.status[g]] == wanted.status
            assert got.part(g) == wanted.part
            assert got.path(g) == tuple(wanted.walk.edges[: wanted.path_length].tolist())
            assert got.candidates is not None
            untimed = wanted.dropped.not_adjustable + wanted.dropped.time_scale
            assert got.usable[g] == len(got.candidates.length) - untimed
            if wanted.energy is None:
                assert np.isnan(got.total[g])
                continue
            np.testing.assert_allclose(got.clearance[g], wanted.clearance_m, atol=1e-5)
            np.testing.assert_allclose(got.time_scale[g], wanted.time_scale, atol=1e-6)
            names = {field.name for field in fields(Energy)}
            if not GRID[g].w_m:  # a search does not measure what nothing asks for
                names -= {"displacement", "movement"}
            for name in names:
                value = getattr(wanted.energy, name)
                np.testing.assert_allclose(getattr(got, name)[g], value, atol=2e-4)
    assert seen >= {"avoided", "hit"}


def test_one_compiled_call_for_a_grid() -> None:
    judged = made_judged()
    certainty, clearance = np.zeros(4, np.int32), np.ones(4, np.float32)
    names = tuple(f.name for f in fields(EnergyConfig) if f.name not in ("form", "d0"))

    def grid(seed: int) -> EnergyConfig:
        rng = np.random.default_rng(seed)
        columns = {name: rng.uniform(0.1, 2, 7).astype(np.float32) for name in names}
        return replace(EnergyConfig(), **columns)

    @jax.jit
    @chex.assert_max_traces(n=1)
    def traced(energies: EnergyConfig) -> Picked:
        return pick_each(judged, certainty, clearance, energies, limit_scale=True, checks=9)

    for seed in range(3):
        energies = grid(seed)
        got = traced(energies)
        for g in range(7):
            one = replace(energies, **{name: getattr(energies, name)[g] for name in names})
            wanted = pick(judged, certainty, clearance, one, limit_scale=True, checks=9)
            chex.assert_trees_all_close(jax.tree.map(lambda x, g=g: x[g], got), wanted, atol=1e-6)


def test_nothing_to_choose_from(made_graph: MotionGraph) -> None:
    rng = np.random.default_rng(1)
    ball = throw(rng)
    far = Attack(times=ball.times, centres=ball.centres + 40.0, radii=ball.radii)
    got = sweep_energies(made_graph, 0, far, GRID)
    assert got.status.tolist() == [Status.NO_CANDIDATE.code] * len(GRID)
    assert (got.crop, got.candidates) == (None, None)
    assert np.isnan(got.total).all()
    narrow = AvoidanceConfig(T_window=1e-3, T_wide=0.0, refine="off")
    prepared = prepared_for(made_graph, narrow)
    queries = ((node, ask(prepared, node, ball, narrow)) for node in range(made_graph.num_nodes))
    node = next(node for node, query in queries if query and not len(query.in_time.length))
    got = sweep_energies(made_graph, node, ball, GRID[:1], config=narrow)
    assert got.path(0) == ()
    assert got.part(0) is None


def test_bad_settings(made_graph: MotionGraph) -> None:
    ball = throw(np.random.default_rng(1))
    for grid, words in (
        ([], "no settings"),
        ([EnergyConfig(), EnergyConfig(d0="paper")], "2 forms"),
        ([EnergyConfig(D_body=0.0)], "energy.D_body"),
    ):
        with pytest.raises(ConfigError, match=words):
            sweep_energies(made_graph, 0, ball, grid)
    sliced = AvoidanceConfig(culling="paper")
    with pytest.raises(ConfigError, match="culling = 'paper'"):
        sweep_energies(made_graph, 0, ball, GRID, config=sliced)
    broken = Attack(times=ball.times, centres=ball.centres * np.nan, radii=ball.radii)
    with pytest.raises(AttackError, match="not finite"):
        sweep_energies(made_graph, 0, broken, GRID)
