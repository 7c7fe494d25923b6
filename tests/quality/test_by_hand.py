"""Measures worked by hand, and their slopes where nothing moves."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core.body.capsules import CapsulePairs
from mgjax.quality import feet
from mgjax.quality.in_body import self_penetration
from mgjax.quality.smoothness import normalised_jerk, velocity_jumps

ONE = jnp.float32(1.0)


def sliding(height: float, speed: float, frames: int = 20, rate: float = 20.0) -> jax.Array:
    """One foot slides, the other hangs in the air."""
    toes = np.zeros((frames, 2, 3), np.float32)
    toes[:, 0, 0] = speed * np.arange(frames) / rate
    toes[:, 0, 1] = height
    toes[:, 1, 1] = 0.5
    return jnp.asarray(toes)


@pytest.mark.parametrize(
    ("height", "speed", "share"),
    [
        (0.04, 1.0, 1.0),  # at the ends the mean is 3/5 of 1 m/s
        (0.04, 0.7, 17 / 19),  # and 3/5 of 0.7 m/s is too little
        (0.04, 0.45, 0.0),
        (0.06, 1.0, 0.0),
    ],
)
def test_a_foot_that_skates(height: float, speed: float, share: float) -> None:
    toes = sliding(height, speed)
    skates = feet.skating(toes, jnp.int32(20), rate=20.0, scale=ONE)
    assert float(jnp.mean(skates.astype(jnp.float32))) == pytest.approx(share)
    padded = jnp.concatenate([toes, jnp.zeros((12, 2, 3), jnp.float32)])
    again = feet.skating(padded, jnp.int32(20), rate=20.0, scale=ONE)
    np.testing.assert_array_equal(again[:19], skates)
    assert not again[19:].any()


def test_contacts_and_slides() -> None:
    toes = sliding(0.04, 0.6, rate=30.0)
    speed, touches = feet.contact_speeds(toes, rate=30.0, scale=ONE)
    np.testing.assert_allclose(speed[:, 0], 0.6, rtol=1e-3)
    assert touches[:, 0].all()
    assert not touches[:, 1].any()
    # Where it rests it slides by its 2 cm a frame; 1.25 cm higher by (2 − √2) of them.
    both = jnp.concatenate([toes, toes], axis=1)
    rests = jnp.array([0.04, 0.5, 0.04 - 0.0125, 0.5], jnp.float32)
    slide = feet.slides(both, rests, rate=30.0, scale=ONE)
    np.testing.assert_allclose(slide[:, 0], 0.02, rtol=1e-3)
    np.testing.assert_allclose(slide[:, 2], 0.02 * (2 - np.sqrt(2)), rtol=1e-3)
    assert float(feet.slides(both, rests - 0.03, rate=30.0, scale=ONE).max()) == 0.0
    down = both - jnp.array([[[0, 0.05, 0]]], jnp.float32)
    np.testing.assert_allclose(feet.sunk(down)[:, 0], 0.01, rtol=1e-4)
    assert float(feet.sunk(down)[:, 1].max()) == 0.0


def test_a_foot_that_floats() -> None:
    toes = sliding(0.04, 0.1, rate=30.0)
    over, stands = feet.floating(toes, jnp.array([0.01, 0.01]), rate=30.0, scale=ONE)
    np.testing.assert_allclose(over, 0.03, rtol=1e-4)
    assert stands.all()
    _, stands = feet.floating(
        sliding(0.04, 0.3, rate=30.0), jnp.array([0.01, 0.01]), rate=30.0, scale=ONE
    )
    assert not stands.any()


def test_jerk_and_jumps() -> None:
    """x = t³ has jerk 6 m/s³: T⁵ · 36 T / (t₁³ − t₀³)²."""
    rate = 30.0
    times = np.arange(20) / rate
    places = np.zeros((20, 1, 3))
    places[:, 0, 0] = times**3
    got = normalised_jerk(jnp.asarray(places, jnp.float32), rate=rate, scale=ONE)
    assert got.shape == (8, 1)
    for i in range(8):
        path = times[i + 12] ** 3 - times[i] ** 3
        assert float(got[i, 0]) == pytest.approx(0.4**6 * 36 / path**2, rel=0.02)
    places[:, 0, 0] = np.maximum(times - times[7], 0.0)  # its velocity jumps by 1 m/s, once
    jumps = velocity_jumps(jnp.asarray(places, jnp.float32), rate=rate)
    assert int(jnp.argmax(jumps)) == 6
    assert float(jumps.max()) == pytest.approx(1.0, rel=1e-4)
    assert float(jnp.sort(jumps[:, 0])[-2]) < 1e-4


def test_limbs_in_the_body() -> None:
    """Two bones that cross 3 cm apart, with radii of 4 and 5 cm, are 6 cm in each other."""
    pairs = CapsulePairs(joints=np.array([[0, 1, 2, 3]]), reach=np.array([0.09], np.float32))
    places = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0.03], [0, 1, 0.03]], np.float32)
    away = np.array([[0], [0], [1], [1]])
    frames = jnp.asarray(np.stack([places, places + away]), jnp.float32)
    apart = jnp.full(1, 1.0, jnp.float32)
    np.testing.assert_allclose(self_penetration(pairs, frames, apart), [0.06, 0.0], atol=1e-6)
    captured = jnp.full(1, -0.02, jnp.float32)
    np.testing.assert_allclose(self_penetration(pairs, frames, captured), [0.04, 0.0], atol=1e-6)
    none = CapsulePairs(joints=np.zeros((0, 4), int), reach=np.zeros(0, np.float32))
    assert self_penetration(none, frames, jnp.zeros(0)).tolist() == [0, 0]

    def depth(places: jax.Array) -> jax.Array:
        return self_penetration(pairs, places, apart).sum()

    # The two meet in one point, lie in one another, or one of them has no length.
    for flat in (frames[0] * jnp.array([[1.0, 1, 0]]), frames[0, jnp.array([0, 1, 0, 1])]):
        assert bool(jnp.isfinite(jax.grad(depth)(flat.astype(jnp.float32))).all())
    slope = jax.grad(depth)(frames[0])
    np.testing.assert_allclose(slope[:, 2], [0.5, 0.5, -0.5, -0.5], atol=1e-5)


def test_slopes_at_rest() -> None:
    def total(places: jax.Array) -> jax.Array:
        jerk = normalised_jerk(places, rate=30.0, scale=ONE)
        speed, _ = feet.contact_speeds(places, rate=30.0, scale=ONE)
        four = jnp.concatenate([places, places], axis=1)
        slide = feet.slides(four, jnp.zeros(4, jnp.float32), rate=30.0, scale=ONE)
        jumps = velocity_jumps(places, rate=30.0)
        return jerk.sum() + speed.sum() + slide.sum() + jumps.sum()

    assert bool(jnp.isfinite(jax.grad(total)(jnp.zeros((16, 2, 3), jnp.float32))).all())
