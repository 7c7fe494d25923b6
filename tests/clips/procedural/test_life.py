"""What bodies do by themselves: arms as pendulums, breaths, and a pelvis that answers steps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from mgjax.clips.procedural.life import answer_steps, breathe, pendulum, swing_arms
from mgjax.clips.procedural.score import Score
from mgjax.clips.synthetic_skeleton import CHANNELS
from tests.reference.pendulum import hanging_arm

RATE = 120.0
T = np.arange(600) / RATE


def smooth(x: np.ndarray, seconds: float) -> np.ndarray:
    return gaussian_filter1d(x, seconds * RATE, axis=0, mode="nearest")


def still() -> dict[str, np.ndarray]:
    return {name: np.zeros_like(T) for name in CHANNELS}


def pushed(sideways: float, ahead: float) -> np.ndarray:
    """A body that is moved once, quickly: its planar places over time."""
    u = np.clip((T - 1.5) / 0.4, 0, 1)
    far = u * u * u * (10 + u * (6 * u - 15))
    return np.stack([0 * T, sideways * far, ahead * far], axis=-1)


def test_an_arm_is_a_damped_pendulum():
    push = np.random.default_rng(0).normal(size=T.size).cumsum() * 0.1
    np.testing.assert_allclose(pendulum(push, RATE), hanging_arm(push, RATE), atol=1e-9)


def test_an_arm_comes_to_rest_where_gravity_and_push_balance():
    # By hand: a / (L ω²) = 3 / (0.6 · 7.5²) = 0.0889 rad, against the push.
    angle = pendulum(np.full(2000, 3.0), RATE)
    assert angle[-1] == pytest.approx(-0.0889, abs=1e-4)
    assert angle.min() < 1.1 * angle[-1]  # it overshoots


def test_arms_lag_behind_a_dash_and_spread_in_a_sidestep():
    ahead, left, right = still(), still(), still()
    swing_arms(ahead, pushed(0, 0.6), T, smooth)
    swing_arms(left, pushed(0.6, 0), T, smooth)
    swing_arms(right, pushed(-0.6, 0), T, smooth)
    starts = (T > 1.5) & (T < 1.75)
    assert ahead["flex_l"][starts].min() < -0.1  # thrown back
    np.testing.assert_allclose(ahead["flex_l"], ahead["flex_r"])
    assert left["open_r"].max() > 0.2
    assert min(left[f"open_{s}"].min() for s in "lr") > -0.02  # no arm goes into the body
    np.testing.assert_allclose(left["open_l"], right["open_r"], atol=1e-12)
    for c in (ahead, left):
        assert max(abs(x[-1]) for x in c.values()) < 1e-6


def test_breaths_are_small_regular_and_fade_at_the_ends():
    c, fade = still(), np.clip(np.minimum(T, T[-1] - T) / 0.6, 0, 1)
    breathe(c, T, fade, np.random.default_rng(1))
    assert 0.5 < np.abs(c["bend"]).max() <= 0.9  # degrees
    assert c["bend"][0] == c["bend"][-1] == 0
    np.testing.assert_allclose(c["open_l"] * 0.9, -c["bend"] * 0.8, atol=1e-12)


def test_the_pelvis_drops_beside_the_carried_foot_and_yields_after_landing():
    score = Score(rng=np.random.default_rng(0))
    score.time = 2.0
    score.step(0, np.array([0.0, 0.0, 0.5]), 0.4)
    c = still()
    answer_steps(c, score.steps, T, smooth)
    carried = (T > 2.1) & (T < 2.3)
    assert np.degrees(c["roll"][carried]).min() > 2  # to the left, where the foot is carried
    np.testing.assert_allclose(c["lean"], -1.1 * c["roll"])
    lowest = T[c["up"].argmin()]
    assert 2.4 < lowest < 2.55
    assert -0.03 < c["up"].min() < -0.01
    untouched = set(CHANNELS) - {"roll", "lean", "up"}
    assert all((c[name] == 0).all() for name in untouched)
