"""What avoids an attack does so at any size: of the body, its motion and the attack together.

A ball on a straight line stands for all attacks here: one that falls does so by the gravity of the
world, which is not scaled. ``CLEAR_M`` is not either, which decides where a gap is about 1 mm.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.ball import ball_from
from mgjax.avoidance.attacks.transform import of_size
from mgjax.avoidance.choice.choosing import choose
from mgjax.avoidance.choice.search import search_one
from mgjax.avoidance.choice.selection import select
from mgjax.avoidance.config import HEIGHTS_M, AvoidanceConfig
from mgjax.avoidance.coverage.report import coverage_report
from mgjax.avoidance.coverage.throws import measure_coverage
from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.index import arrays_of
from mgjax.avoidance.many.attacks import select_batch
from mgjax.avoidance.many.settings import sweep_energies
from mgjax.avoidance.prepared import prepare, prepared_for
from mgjax.avoidance.rates import CLEAR_M
from tests.sized import EXACT, graph_of_size

BALLS = 9


@pytest.fixture(scope="module", params=[0.6, 2.0])
def size(request):
    return request.param


@pytest.fixture(scope="module")
def other_graph(made_graph, size):
    return graph_of_size(made_graph, size)


def thrown(graph):
    """Nodes and straight balls from all around at all heights."""
    rng = np.random.default_rng(5)
    nodes = rng.integers(graph.num_nodes, size=BALLS).tolist()
    balls = [
        ball_from(
            rng.uniform(0, 2 * np.pi),
            HEIGHTS_M[k % len(HEIGHTS_M)],
            arrives=1.2 if k % 4 else 0.4,  # some are there too soon
        )
        for k in range(BALLS)
    ]
    return nodes, balls


def is_close(choice, size):
    """Whether a gap is about ``CLEAR_M`` at one of the sizes, where it may not be at the other."""
    if choice.clearance_m is None:
        return False
    gaps = choice.clearance_m * np.array([1, size])
    return bool((gaps > 0.5 * CLEAR_M).any() and (gaps < 2 * CLEAR_M).any())


def assert_same_choice(got, want, size):
    if is_close(want, size) or is_close(got, 1 / size):
        return
    assert got.status == want.status
    assert got.part == want.part
    assert got.candidates == want.candidates
    assert got.walk.edges.tolist() == want.walk.edges.tolist()
    np.testing.assert_allclose(got.walk.scales, want.walk.scales, rtol=1e-5)
    if want.energy is None:
        assert got.energy is None
        return
    for name in ("total", "avoidance", "body", "movement", "timescale"):
        np.testing.assert_allclose(
            getattr(got.energy, name), getattr(want.energy, name), atol=1e-3, err_msg=name
        )
    for name in ("penetration", "d", "d0", "displacement"):
        np.testing.assert_allclose(
            getattr(got.energy, name), size * getattr(want.energy, name), atol=1e-4, err_msg=name
        )
    np.testing.assert_allclose(got.clearance_m, size * want.clearance_m, atol=1e-4)
    np.testing.assert_allclose([got.crop.start, got.crop.end], [want.crop.start, want.crop.end])


@pytest.mark.parametrize("form", ["overlap", "paper"])
def test_the_same_choices(made_graph, other_graph, size, form):
    config = AvoidanceConfig(refine="off")
    config = replace(config, energy=replace(config.energy, form=form, E_avoidance=0.1))
    here, there = prepare(made_graph, config), prepare(other_graph, config)
    nodes, balls = thrown(made_graph)
    wanted = [
        choose(here, node, ball, config=config) for node, ball in zip(nodes, balls, strict=True)
    ]
    programs = search_one._cache_size()
    for node, ball, want in zip(nodes, balls, wanted, strict=True):
        got = choose(there, node, of_size(ball, size), config=config)
        assert_same_choice(got, want, size)
    assert search_one._cache_size() == programs  # sizes are numbers: nothing is compiled anew
    statuses = {str(want.status) for want in wanted}
    assert "avoided" in statuses
    assert len(statuses) > 1


def test_the_same_edges_change_their_speed(made_graph, other_graph):
    want, got = prepare(made_graph).device.edge_rows, prepare(other_graph).device.edge_rows
    np.testing.assert_array_equal(np.asarray(got)[:, 4:], np.asarray(want)[:, 4:])


@pytest.mark.parametrize("culling", ["paper", "binned"])
def test_the_same_slices(made_graph, other_graph, size, culling):
    config = AvoidanceConfig(culling=culling)
    here, there = prepared_for(made_graph, config), prepared_for(other_graph, config)
    differ = (np.asarray(here.slices.binned.size) != np.asarray(there.slices.binned.size)).mean()
    assert differ <= (0 if size in EXACT else 1e-2)
    dropped = 0
    for node, ball in zip(*thrown(made_graph), strict=True):
        want = choose(here, node, ball, config=config)
        got = choose(there, node, of_size(ball, size), config=config)
        assert got.status == want.status
        assert abs(got.dropped.culled - want.dropped.culled) <= (0 if size in EXACT else 1)
        dropped += want.dropped.culled
    assert dropped


def test_the_same_answers_of_the_index(made_graph, other_graph, size):
    config = AvoidanceConfig(refine="off")
    one, other = build_index(made_graph), build_index(other_graph)
    mine, others = arrays_of(one), arrays_of(other)
    for name in ("arrivals.end", "arrivals.time", "jumps.end", "jumps.edges"):
        np.testing.assert_array_equal(others[name], mine[name])
    np.testing.assert_allclose(others["parts.centres"], mine["parts.centres"], atol=1e-5)
    if size in EXACT:
        np.testing.assert_array_equal(others["parts.packed"], mine["parts.packed"])
    here, there = prepare(made_graph, config, index=one), prepare(other_graph, config, index=other)
    for node, ball in zip(*thrown(made_graph), strict=True):
        want = choose(here, node, ball, config=config)
        assert_same_choice(choose(there, node, of_size(ball, size), config=config), want, size)


def test_the_same_of_many(made_graph, other_graph, size):
    nodes, balls = thrown(made_graph)
    del nodes[2], balls[2]  # it passes at 2 mm
    want = select_batch(made_graph, nodes, balls)
    got = select_batch(other_graph, nodes, [of_size(ball, size) for ball in balls])
    np.testing.assert_array_equal(got.part, want.part)
    np.testing.assert_array_equal(got.status, want.status)
    np.testing.assert_allclose(got.energy, want.energy, atol=1e-3)
    energies = [AvoidanceConfig().energy, replace(AvoidanceConfig().energy, D_body=0.1)]
    for node, ball in list(zip(nodes, balls, strict=True))[:3]:
        one = sweep_energies(made_graph, node, ball, energies)
        other = sweep_energies(other_graph, node, of_size(ball, size), energies)
        np.testing.assert_array_equal(other.number, one.number)
        np.testing.assert_allclose(other.body, one.body, atol=1e-3)


def test_the_motion_that_is_written(made_graph, other_graph, size):
    nodes, balls = thrown(made_graph)
    config = AvoidanceConfig(refine="off")
    for node, ball in list(zip(nodes, balls, strict=True))[:3]:
        want = select(made_graph, node, ball, config=config)
        got = select(other_graph, node, of_size(ball, size), config=config)
        assert (got.status, got.warp) == (want.status, want.warp)
        np.testing.assert_allclose(got.trace.centres, size * want.trace.centres, atol=2e-4)


def test_coverage_throws_at_the_whole_body(made_graph, other_graph, size):
    """Balls of the world, but as high as the body: none passes over a child by default."""
    got, want = (measure_coverage(g, nodes=18, directions=2) for g in (other_graph, made_graph))
    np.testing.assert_allclose(got.heights, size * want.heights)
    assert {row["band"] for row in coverage_report(other_graph, got)["regions"]} == {
        row["band"] for row in coverage_report(made_graph, want)["regions"]
    }
