from __future__ import annotations

from dataclasses import replace

import hypothesis
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.ballsport.clipset.build import ClipSet
from mgjax.ballsport.clipset.match import Matcher, distances, match_weights, nearest, store
from mgjax.ballsport.config import MatchConfig
from mgjax.ballsport.hits.motion_vectors import MotionVectors, scaled
from mgjax.core.errors import ConfigError, MotionError
from tests.reference import match as reference

WEIGHTS = jnp.asarray(np.array([0.2, 1.0, 0.7], np.float32))


def made(seed: int, count: int) -> MotionVectors:
    rng = np.random.default_rng(seed)
    return MotionVectors(
        displacements=rng.normal(size=(count, 4, 3)).astype(np.float32),
        seconds=rng.uniform(0, 0.5, size=(count, 4)).astype(np.float32),
        v_max=rng.uniform(1, 12, size=count).astype(np.float32),
    )


def one(vectors: MotionVectors, number: int) -> MotionVectors:
    return jax.tree.map(lambda x: jnp.asarray(x[number]), vectors)


@hypothesis.given(st.integers(0, 10_000), st.integers(1, 60))
def test_agrees_with_the_definition(seed: int, count: int) -> None:
    vectors, live = made(seed, count), one(made(seed + 1, 1), 0)
    stored = store(vectors)
    parts = (live.displacements, live.seconds, live.v_max)
    expected = [
        reference.hit_distance(
            parts,
            (vectors.displacements[i], vectors.seconds[i], vectors.v_max[i]),
            [0.2, 1.0, 0.7],
        )
        for i in range(count)
    ]
    got = np.asarray(distances(live, stored, WEIGHTS))
    np.testing.assert_allclose(got[:count], expected, rtol=1e-5)
    assert np.isinf(got[count:]).all()
    place, least = nearest(live, stored, WEIGHTS)
    assert int(place) == int(np.argmin(expected))
    np.testing.assert_allclose(least, min(expected), rtol=1e-5)


def test_by_hand() -> None:
    still = MotionVectors(
        displacements=np.zeros((1, 4, 3), np.float32),
        seconds=np.full((1, 4), 0.1, np.float32),
        v_max=np.array([5.0], np.float32),
    )
    live = MotionVectors(
        displacements=jnp.zeros((4, 3)).at[0].set(jnp.array([3.0, 4.0, 0.0])),
        seconds=jnp.array([0.1, 0.3, 0.1, 0.1]),
        v_max=jnp.array(3.0),
    )
    # 0.2 · 2 + 1 · 5 + 0.7 · 0.2
    _, least = nearest(live, store(still), WEIGHTS)
    np.testing.assert_allclose(least, 0.4 + 5 + 0.14, rtol=1e-6)


def test_batch_is_a_loop_and_gradients_are_finite() -> None:
    vectors, lives = made(0, 40), made(1, 5)
    stored = store(vectors)
    places, least = nearest(jax.tree.map(jnp.asarray, lives), stored, WEIGHTS)
    for i in range(5):
        place, value = nearest(one(lives, i), stored, WEIGHTS)
        assert int(place) == int(places[i])
        np.testing.assert_allclose(value, least[i], rtol=1e-6)
    with jax.disable_jit():
        place, value = nearest(one(lives, 0), stored, WEIGHTS)
    np.testing.assert_allclose(value, least[0], rtol=1e-6)
    # A live motion that is exactly a stored one.
    gradient = jax.grad(lambda v: distances(v, stored, WEIGHTS)[3])(one(vectors, 3))
    assert all(bool(jnp.isfinite(x).all()) for x in jax.tree.leaves(gradient))


def test_what_is_not_allowed_is_not_found() -> None:
    vectors = made(0, 70)
    for own in (0, 69):
        allowed = np.ones(70, bool)
        allowed[own] = False
        place, least = nearest(one(vectors, own), store(vectors, allowed), WEIGHTS)
        assert int(place) != own
        assert float(least) > 0.0
    with pytest.raises(MotionError, match="no stored hit"):
        store(vectors, np.zeros(70, bool))


def test_matcher(made_set: ClipSet) -> None:
    matcher = Matcher(made_set)
    assert set(matcher.bones) == {"left_foot", "right_foot"}
    for hit, bone in enumerate(made_set.hit_bone):
        # A body twice as large makes the same kick twice as large.
        big = scaled(one(made_set.vectors, hit), 2.0)
        found = matcher.match(big, bone, 2 * made_set.leg_length)
        assert found.hit == hit
        assert found.distance < 1e-4
        other = {"left_foot": "right_foot", "right_foot": "left_foot"}[bone]
        crossed = matcher.match(big, other, 2 * made_set.leg_length)
        assert made_set.hit_bone[crossed.hit] == other
    with pytest.raises(MotionError, match=r"'head', expected one of left_foot, right_foot"):
        matcher.match(one(made_set.vectors, 0), "head", 0.8)
    with pytest.raises(MotionError, match="not finite"):
        matcher.match(scaled(one(made_set.vectors, 0), float("nan")), "left_foot", 0.8)
    with pytest.raises(MotionError, match="leg"):
        matcher.match(one(made_set.vectors, 0), "left_foot", 0.0)


@pytest.mark.parametrize("value", [-1.0, float("nan")])
def test_weights_that_cannot_be(value: float) -> None:
    with pytest.raises(ConfigError, match=rf"^got w_m = {value}, expected 0 … 1e\+09$"):
        match_weights(replace(MatchConfig(), w_m=value))
    with pytest.raises(ConfigError, match="one above 0"):
        match_weights(MatchConfig(w_v=0, w_m=0, w_t=0))
