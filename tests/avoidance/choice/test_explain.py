from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.candidates.enumerate import Candidates, enumerate_candidates
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.explain import explain
from mgjax.avoidance.choice.results import Choice
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared, prepared_for
from mgjax.core.errors import ConfigError

CONFIG = AvoidanceConfig(capacity=4096, refine="off")
NARROW = replace(CONFIG, T_wide=0.0)


def asked(graph, count: int = 12):
    """Nodes and balls at them, drawn."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        node = int(rng.integers(graph.num_nodes))
        yield node, ball_from(float(rng.uniform(0, 2 * np.pi)), float(rng.uniform(0.6, 1.5)))


def in_time(prepared: Prepared, node: int, choice: Choice) -> Candidates:
    """What may answer the attack of a choice within the narrow window."""
    assert choice.crop is not None
    return enumerate_candidates(
        prepared.graph,
        prepared.tables,
        node,
        choice.crop.middle,
        window=CONFIG.T_window,
        capacity=CONFIG.capacity,
    )


def test_every_candidate_is_there_once_in_the_order_of_energy(made_graph):
    prepared = prepared_for(made_graph, CONFIG)
    for node, attack in asked(made_graph):
        rows = explain(prepared, node, attack, config=NARROW)
        candidates = in_time(prepared, node, choose(prepared, node, attack, config=NARROW))
        assert sorted(row.number for row in rows) == list(range(len(candidates.length)))
        energies = [row.energy for row in rows if row.energy is not None]
        keys = [(e.d < 0, -e.d if e.d < 0 else e.total) for e in energies]
        assert keys == sorted(keys)
        timed = [row.rank for row in rows if row.rank is not None]
        assert timed == list(range(len(timed)))
        for row in rows:
            length = candidates.length[row.number]
            assert row.path_length == length
            np.testing.assert_array_equal(
                row.walk.edges[:length], candidates.edges[row.number, :length]
            )


def test_the_first_clear_one_is_what_is_chosen(made_graph):
    clear = 0
    for node, attack in asked(made_graph, 20):
        choice = choose(made_graph, node, attack, config=CONFIG)
        rows = explain(made_graph, node, attack, config=CONFIG, checked=64)
        first = next((row for row in rows if row.outcome == "clear"), None)
        assert (first is not None) == (choice.status == "avoided")
        if first is None:
            continue
        clear += 1
        assert first.part == choice.part
        assert first.energy.total == pytest.approx(choice.energy.total, abs=1e-6)
        assert first.time_scale == pytest.approx(choice.time_scale, rel=1e-6)
        assert first.clearance_m == pytest.approx(choice.clearance_m, abs=1e-4)
        before = rows[: rows.index(first)]
        assert {row.outcome for row in before} <= {"hit"}
    assert clear > 3, "some are avoided"


def test_the_counts_are_those_of_the_choice(made_graph):
    for node, attack in asked(made_graph):
        choice = choose(made_graph, node, attack, config=NARROW)
        rows = explain(made_graph, node, attack, config=NARROW)
        outcomes = [row.outcome for row in rows]
        left_out = in_time(prepared_for(made_graph, CONFIG), node, choice).overflow
        assert len(rows) == choice.candidates - left_out
        assert outcomes.count("not adjustable") == choice.dropped.not_adjustable
        assert outcomes.count("time scale") == choice.dropped.time_scale


def test_what_is_beyond_the_checks_is_said(made_graph):
    for node, attack in asked(made_graph):
        rows = explain(made_graph, node, attack, config=CONFIG, checked=2)
        for row in rows:
            if row.rank is not None and row.rank >= 2:
                assert row.outcome == "unchecked"
                assert row.clearance_m is None


def test_plain_records_and_motions(made_graph):
    seen = 0
    for node, attack in asked(made_graph):
        rows = explain(made_graph, node, attack, config=CONFIG, checked=2)
        records = rows.rows()
        assert json.loads(json.dumps(records)) == records  # nothing but plain values
        assert len({tuple(record) for record in records}) <= 1  # the same columns in all
        for row, record in zip(rows, records, strict=True):
            assert record["outcome"] == row.outcome
            assert len(record["edges"]) == row.path_length
            total = None if row.energy is None else row.energy.total
            assert record["energy_total"] == total
        if rows and not seen:
            motion = rows.motion(0)
            assert motion.num_frames >= 120.0 * (attack.end + CONFIG.settle_s)
        seen += len(rows)
    assert seen


def test_an_attack_that_never_comes_near_has_no_candidates(made_graph):
    far = ball_from(0.0, 1.0, at=(50.0, 0.0))
    assert explain(made_graph, 0, far) == []


def test_no_such_node(made_graph):
    with pytest.raises(ConfigError, match="node 99999999"):
        explain(made_graph, 99_999_999, ball_from(0.0, 1.2))
