from __future__ import annotations

import chex
import jax
import numpy as np
import pytest

from mgjax.avoidance import choose, select_batch
from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.candidates.enumerate import enumerate_nodes
from mgjax.avoidance.choice.results import Status
from mgjax.avoidance.choice.search import (
    DEPTH,
    HOPELESS_M,
    STATUS,
    SearchResult,
    search,
    search_input,
)
from mgjax.avoidance.choice.start import ask
from mgjax.avoidance.config import AvoidanceConfig, EnergyConfig
from mgjax.avoidance.energy.promise import UNJUDGED
from mgjax.avoidance.energy.score import ROWS
from mgjax.avoidance.many.attacks import NO_PART, _no_answers, _search
from mgjax.avoidance.many.groups import all_asked, firsts_of, groups
from mgjax.avoidance.many.questions import ask_all
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.timing.time_scale import OK
from mgjax.core.errors import AttackError, ConfigError
from mgjax.graph.types import MotionGraph
from tests.avoidance.made import natural_times, throw


def questions(graph: MotionGraph, count: int) -> tuple[np.ndarray, list[Attack]]:
    """Random balls at a few nodes, several at each, one that never comes near."""
    rng = np.random.default_rng(8)
    places = rng.integers(graph.num_nodes, size=count // 3 + 1)
    nodes = rng.choice(places, size=count)
    balls = [throw(rng, arrives=rng.uniform(0.9, 1.4)) for _ in range(count)]
    far = balls[0]
    balls[0] = Attack(times=far.times, centres=far.centres + 40.0, radii=far.radii)
    return nodes, balls


def test_the_same_answers_as_one_by_one(any_graph: MotionGraph) -> None:
    config = AvoidanceConfig(refine="off")
    nodes, attacks = questions(any_graph, 36)
    got = select_batch(any_graph, nodes, attacks, config=config)
    seen = set()
    for i, (node, attack) in enumerate(zip(nodes, attacks, strict=True)):
        wanted = choose(any_graph, int(node), attack, config=config)
        seen.add(wanted.status)
        assert tuple(Status)[got.status[i]] == wanted.status
        assert got.candidates[i] == wanted.candidates
        if wanted.energy is None or wanted.clearance_m is None:
            assert got.part[i] == NO_PART
            assert np.isnan([got.time_scale[i], got.clearance[i], got.energy[i]]).all()
            continue
        assert got.part[i] == wanted.part
        np.testing.assert_allclose(got.time_scale[i], wanted.time_scale, atol=1e-5)
        np.testing.assert_allclose(got.clearance[i], wanted.clearance_m, atol=1e-4)
        np.testing.assert_allclose(got.energy[i], wanted.energy.total, atol=1e-3)
    assert np.isnan(got.t_attack[0])
    assert seen >= {"avoided", "no_candidate"}


def test_what_is_not_judged_is_not_the_best(any_graph: MotionGraph) -> None:
    config = AvoidanceConfig(refine="off")
    prepared = prepared_for(any_graph, config)
    nodes, attacks = questions(any_graph, 36)
    asked = ask_all(prepared, nodes, attacks, config)
    left_out = clear = 0
    for group in groups(all_asked(asked, _no_answers(len(attacks)))):
        (_, some), (_, every) = (_search(asked, whole, group) for whole in (False, True))
        total, d, count = ROWS.index("total"), every.table[DEPTH], firsts_of(group)[-1]
        np.testing.assert_array_equal(some.table[STATUS], every.table[STATUS])
        unknown = (some.table[total] >= UNJUDGED)[:count] & (every.table[STATUS, :count] == OK)
        left_out += unknown.sum()
        assert (d[:count][unknown & (some.table[DEPTH, :count] < 0)] < -HOPELESS_M).all()
        for begin in firsts_of(group)[:-1]:
            best = every.order[begin]
            assert some.order[begin] == best
            np.testing.assert_allclose(some.table[:, best], every.table[:, best], atol=1e-5)
            clear += d[best] >= 0
    assert left_out > 50
    assert clear > 5


def test_bad_questions(made_graph: MotionGraph) -> None:
    nodes, attacks = questions(made_graph, 6)
    with pytest.raises(ConfigError, match="5 nodes for 6 attacks"):
        select_batch(made_graph, nodes[:5], attacks)
    with pytest.raises(ConfigError, match="expected 0 …"):
        select_batch(made_graph, nodes + made_graph.num_nodes, attacks)
    broken = Attack(times=attacks[1].times, centres=attacks[1].centres * np.nan, radii=np.ones(1))
    with pytest.raises(AttackError, match="not finite"):
        select_batch(made_graph, nodes, [broken, *attacks[1:]])
    empty = select_batch(made_graph, [], [])
    assert empty.status.shape == (0,)


def test_attacks_are_traced_once(made_graph: MotionGraph) -> None:
    # Any node, ball and weights: one compiled call for all of one size.
    config = AvoidanceConfig(refine="off")
    prepared = prepared_for(made_graph, config)
    device = prepared.device

    @jax.jit
    @chex.assert_max_traces(n=1)
    def traced(*inputs: object) -> SearchResult:
        return search(*inputs, frame_rate=30.0, limit_scale=True)

    rng = np.random.default_rng(1)
    answered = 0
    while answered < 6:
        attack = throw(rng, arrives=rng.uniform(1.0, 1.3))
        query = ask(prepared, int(rng.integers(made_graph.num_nodes)), attack, config)
        assert query is not None
        if not 8 < len(query.in_time.length) <= 32:
            continue
        given = search_input(query, query.in_time)
        energy = EnergyConfig(E_avoidance=rng.uniform(0.01, 1.0), w_b=rng.uniform(0, 2))
        traced(device, given.walks, given.attack_batch, energy)
        answered += 1


def test_natural_times(made_graph: MotionGraph) -> None:
    tables = prepared_for(made_graph, AvoidanceConfig()).tables
    nodes, low = np.array([3, 40]), np.array([0.2, 0.4])
    found = enumerate_nodes(made_graph, tables, nodes, low, low + 2.0)
    times = natural_times(tables, found.some(np.arange(len(found.length)), 0))
    np.testing.assert_allclose(found.t_avoid, times)
    for node, begin in enumerate(low):
        own = times[slice(*found.first[node : node + 2])]
        assert len(own)
        assert (np.abs(own - begin - 1.0) < 1.0).all()
