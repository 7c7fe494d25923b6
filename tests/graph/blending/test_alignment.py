from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgjax.graph.blending.alignment import (
    SUPPORT,
    align,
    align_by_support,
    same_support,
    support_weights,
)
from mgjax.graph.build import build_graph
from mgjax.graph.config import GraphConfig
from mgjax.graph.distances.distance import distance_matrix, normalised_weights
from mgjax.graph.feet.legs import foot_chains
from mgjax.graph.types import NO_CLIP
from tests.graph.made import BODY, march, places
from tests.reference import graph as reference
from tests.reference import kinematics

WEIGHTS = normalised_weights(None, BODY.num_joints)
CHAINS = foot_chains(BODY)


@given(st.integers(0, 10**6), st.sampled_from([1, 4, 10]))
def test_align_against_the_reference(seed, window):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, window, 6, 3)) + rng.normal(scale=3, size=(2, 1, 1, 3))
    weights = rng.uniform(size=6) * (np.arange(6) != seed % 6)
    weights /= weights.sum()
    got = align(*(jnp.asarray(x.astype(np.float32)) for x in (a, b, weights)))
    w = reference.cloud_weights(weights, 6, window)
    want = reference.align(a.reshape(-1, 3), b.reshape(-1, 3), w)
    error = np.asarray(got, np.float64) - want
    error[0] -= 2 * np.pi * np.round(error[0] / (2 * np.pi))
    assert np.abs(error).max() < 2e-4
    # It is the one with which the misfit is the distance.
    left = reference.misfit(got, a.reshape(-1, 3), b.reshape(-1, 3), w)
    distance = distance_matrix(
        a.astype(np.float32), b.astype(np.float32), window=window, weights=weights
    )
    assert np.sqrt(left) == pytest.approx(float(distance[0, 0]), abs=2e-4)


def test_align_undoes_a_transform():
    a = places(march(10, seed=1))
    transform = (2.0, 30.0, -7.0)
    b = np.array([[kinematics.planar_apply(transform, p) for p in frame] for frame in a])
    got = align(jnp.asarray(a), jnp.asarray(b.astype(np.float32)), jnp.asarray(WEIGHTS))
    back = np.array([[kinematics.planar_apply(got, p) for p in frame] for frame in b])
    np.testing.assert_allclose(back, a, atol=1e-4)


def test_align_of_points_without_a_direction_is_finite():
    still = jnp.ones((4, 3, 3))
    got = align(still, still + 2.0, jnp.full(3, 1 / 3))
    np.testing.assert_allclose(got, [0, -2, -2], atol=1e-6)


@given(st.integers(0, 10**6))
def test_weights_of_each_frame_against_the_reference(seed):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, 5, 6, 3))
    weights = rng.uniform(size=(5, 6))
    got = align(*(jnp.asarray(x.astype(np.float32)) for x in (a, b, weights)))
    want = reference.align(a.reshape(-1, 3), b.reshape(-1, 3), weights.ravel() / weights.sum())
    error = np.asarray(got, np.float64) - want
    error[0] -= 2 * np.pi * np.round(error[0] / (2 * np.pi))
    assert np.abs(error).max() < 2e-4


def test_support_weights_worked_by_hand():
    # Two frames; the left foot stands in the second only: u = 3/4, so 6u(1 − u) = 9/8, shared by
    # the ball and the ankle.
    standing = jnp.array([[False, False], [True, False]])
    extra = np.asarray(support_weights(jnp.asarray(WEIGHTS), CHAINS, standing)) - WEIGHTS
    want = np.zeros((2, BODY.num_joints))
    want[1, [CHAINS.balls[0], CHAINS.ankles[0]]] = SUPPORT * 9 / 16
    np.testing.assert_allclose(extra, want, atol=1e-5)


def test_a_foot_that_stands_in_both_comes_to_lie_on_itself():
    a, b = (places(march(10, seed=s, swing=w)) for s, w in ((1, 0.3), (2, 0.5)))
    ball = CHAINS.balls[0]
    standing = jnp.tile(jnp.array([True, False]), (10, 1))
    windows = jnp.asarray(a), jnp.asarray(b), jnp.asarray(WEIGHTS)
    plain, led = align(*windows), align_by_support(*windows, CHAINS, standing)
    assert led[0] == plain[0]
    apart = []
    for turn in (plain, led):
        back = np.array([kinematics.planar_apply(turn, p) for p in b[:, ball]])
        apart.append(np.linalg.norm((back - a[:, ball]).mean(axis=0)[[0, 2]]))
    assert apart[1] < 0.2 * apart[0]
    assert apart[0] > 0.005


def test_same_support_worked_by_hand():
    plants = np.array([[1, 0], [1, 1], [0, 1], [1, 0], [1, 0], [0, 0]], dtype=bool)
    # Windows 0–1–2 and 3–4–5: equal in the first frame only.
    np.testing.assert_allclose(same_support(plants, np.array([0]), np.array([3]), 3), [1 / 3])
    np.testing.assert_allclose(
        same_support(plants, np.array([0, 3]), np.array([0, 4]), 2), [1, 0.5]
    )


def test_contacts_as_a_condition(made):
    config = GraphConfig(threshold_m=0.2)
    free = build_graph(made[0], labels=made[1], config=config)
    bound = build_graph(made[0], labels=made[1], config=replace(config, contacts=0.8))
    shares = []
    for graph in (free, bound):
        edges = graph.edge_clip == NO_CLIP
        leave = graph.node_frame[graph.edge_source[edges]]
        arrive = graph.node_frame[graph.edge_target[edges]] - graph.window
        shares.append(same_support(graph.plants, leave, arrive, graph.window))
    assert shares[0].min() < 0.8
    assert shares[1].min() >= 0.8
    assert 0 < len(shares[1]) < len(shares[0])


def test_align_has_finite_gradients():
    a, b = (jnp.asarray(places(march(4, seed=s))) for s in (1, 2))
    standing = jnp.ones((4, 2), dtype=bool)
    rest = jnp.asarray(WEIGHTS), CHAINS, standing
    for other in (a, b):
        gradients = jax.grad(lambda p, o=other: align_by_support(p, o, *rest).sum())(a)
        assert jnp.isfinite(gradients).all()
