"""Gestures: out at once, back at leisure, no corner anywhere."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.clips.procedural.gestures import LAG_S, Gesture, ease

T = np.linspace(0, 3, 3001)
GESTURE = Gesture(start_s=0.5, rise_s=0.4, hold_s=0.2, fall_s=0.6, moves={})


def test_minimum_jerk_by_hand():
    # 10 x³ − 15 x⁴ + 6 x⁵ at 1/4: 0.15625 − 0.05859375 + 0.005859375
    np.testing.assert_allclose(
        ease(np.array([-1, 0, 0.25, 0.5, 1, 2])), [0, 0, 0.103515625, 0.5, 1, 1]
    )


def test_an_envelope_goes_out_holds_and_comes_back():
    x = GESTURE.envelope(T)
    assert (x[T <= 0.5] == 0).all()
    np.testing.assert_allclose(x[(T >= 0.9) & (T <= 1.1)], 1, atol=1e-9)
    np.testing.assert_allclose(x[T >= 1.7], 0, atol=1e-9)
    assert ((x >= 0) & (x <= 1)).all()


def test_an_envelope_is_quick_on_its_way_out_and_settles_slowly():
    half_out, half_back = GESTURE.envelope(np.array([0.7, 1.4]))
    assert half_out > 0.55  # a minimum jerk is at 0.5 there
    assert half_back < 0.45


def test_an_envelope_has_no_corner():
    speed = np.gradient(GESTURE.envelope(T), T)
    assert np.abs(np.diff(speed)).max() < 0.06  # 60 /s² at amplitude 1
    for moment in (0.5, 0.9, 1.1, 1.7):
        assert np.interp(moment, T, speed) == pytest.approx(0, abs=0.03)


def test_the_pelvis_leads():
    pelvis = ("side", "up", "fore", "yaw", "pitch", "roll")
    assert not set(pelvis) & set(LAG_S)
    assert 0 < LAG_S["twist"] < LAG_S["look"] < LAG_S["elbow"] < 0.1
