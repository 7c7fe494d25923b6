"""What a body does without being told: it breathes, its arms lag and spread, its pelvis yields."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import lfilter

from mgjax.clips.procedural.gestures import ease
from mgjax.clips.procedural.score import Step
from mgjax.clips.synthetic_skeleton import Foot
from mgjax.core.arrays import Array

Smooth = Callable[[Array, float], np.ndarray]
"""A low pass over frames with a width in s."""
_BREATH_HZ = (0.22, 0.3)
_BREATH = {"bend": -0.9, "open_l": 0.8, "open_r": 0.8, "nod": 0.4, "up": 0.0015}
"""Amplitudes of a breath by channel, degrees and m."""
_CHEST_M = 0.35
"""Of the chest over the lumbar spine."""
_ARM_RAD_S, _ARM_DAMPING, _ARM_M = 7.5, 0.5, 0.6
"""An arm that hangs loosely: its frequency, damping ratio and length as a pendulum."""
_SPREAD = 0.55
"""By so much of how far an arm is thrown to a side both are lifted, for balance."""
_FLOAT = 0.014
"""How far arms float up as the body drops, rad s²/m."""
_LIST = np.radians(3.0)
"""How far the pelvis drops on the side of a foot that is carried."""
_YIELD_M = 0.012
"""How far the pelvis sinks as a foot lands at 1 m/s."""


def breathe(c: dict[str, np.ndarray], t: np.ndarray, fade: Array, rng: np.random.Generator) -> None:
    """Adds breaths to the channels, m and degrees."""
    hertz, phase = rng.uniform(*_BREATH_HZ), rng.uniform(0, 2 * np.pi)
    breath = fade * np.sin(2 * np.pi * hertz * t + phase)
    for name, size in _BREATH.items():
        c[name] += size * breath


def swing_arms(c: dict[str, np.ndarray], base: np.ndarray, t: np.ndarray, smooth: Smooth) -> None:
    """Arms are thrown about by the chest as damped pendulums, and spread for balance.

    Each arm follows θ″ + 2ζω θ′ + ω² θ = −a / L, a the acceleration of the chest forward or to the
    left, m/s². An arm that is thrown towards the body is stopped by it.
    """
    sin, cos = np.sin(base[:, 0]), np.cos(base[:, 0])
    ahead = c["fore"] + _CHEST_M * np.sin(c["pitch"] + c["bend"])
    aside = c["side"] + _CHEST_M * np.sin(c["roll"] + c["lean"])
    rate = 1 / (t[1] - t[0])

    def push(x: np.ndarray) -> np.ndarray:
        return smooth(np.gradient(np.gradient(x, 1 / rate), 1 / rate), 0.04)

    over = [push(base[:, 1]), push(base[:, 2])]
    forward = push(ahead) + over[0] * sin + over[1] * cos
    left = push(aside) + over[0] * cos - over[1] * sin
    fade = ease(t / 0.4) * ease((t[-1] - t) / 0.8)
    thrown = fade * pendulum(forward, rate)
    out = fade * pendulum(left, rate)
    apart = np.sqrt(out**2 + 0.0009) - 0.03
    afloat = fade * smooth(np.clip(-push(c["up"]), -2.0, 8.0), 0.06) * _FLOAT
    for side, sign in (("l", 1), ("r", -1)):
        c[f"flex_{side}"] += thrown
        c[f"elbow_{side}"] += 0.5 * np.sqrt(thrown**2 + 0.0025) - 0.025 + 0.4 * apart
        c[f"open_{side}"] += 0.5 * (sign * out + apart) + _SPREAD * apart + afloat


def pendulum(push: np.ndarray, rate: float) -> np.ndarray:
    """The angle of a loosely hanging arm, from rest, whose shoulder is pushed.

    Args:
        push: acceleration of the shoulder, m/s². [F]
        rate: steps per second, well above the arm's 1.2 Hz.

    Returns:
        The angle against the push, rad: the arm lags. [F]
    """
    step = 1 / rate
    w, z = _ARM_RAD_S, _ARM_DAMPING
    # v' = v + h (−a / L − 2 z w v − w² x);  x' = x + h v', as one recursion in x.
    back = [1.0, -(2 - 2 * z * w * step - (w * step) ** 2), 1 - 2 * z * w * step]
    return np.asarray(lfilter([-(step**2) / _ARM_M], back, push))


def answer_steps(
    c: dict[str, np.ndarray], steps: Sequence[Step], t: np.ndarray, smooth: Smooth
) -> None:
    """The pelvis drops a little where no leg holds it, and yields as a foot lands."""
    aside, down = np.zeros_like(t), np.zeros_like(t)
    for s in steps:
        sign = 1 if s.foot == 0 else -1
        aside += sign * ((t > s.lift_s) & (t < s.land_s)) * min(1.0, 2.5 * s.shift)
        # A jump's landing is among its knots.
        speed = np.hypot(s.travel[0], s.travel[2]) / (s.land_s - s.lift_s) if s.height else 0.0
        after = (t - s.land_s) / 0.1
        down += _YIELD_M * speed * np.exp(-0.5 * (after - 0.6) ** 2)
    listing = _LIST * smooth(aside, 0.07)
    c["roll"] += listing
    c["lean"] -= 1.1 * listing
    c["up"] -= np.minimum(smooth(down, 0.02), 0.05)


def couple_gait(
    c: dict[str, np.ndarray],
    base: np.ndarray,
    feet: tuple[Foot, Foot],
    t: np.ndarray,
    smooth: Smooth,
) -> None:
    """Pelvis, chest and arms answer the legs: arms swing against them, the torso counter-twists."""
    sin, cos = np.sin(base[:, 0]), np.cos(base[:, 0])
    gap = feet[0].ball - feet[1].ball
    ahead = smooth(gap[:, 0] * sin + gap[:, 2] * cos, 0.06)
    c["yaw"] -= 0.16 * ahead
    c["twist"] += 0.3 * ahead
    for side, sign in (("l", -1), ("r", 1)):
        c[f"flex_{side}"] += sign * 0.6 * ahead
        c[f"elbow_{side}"] += 0.25 * (np.sqrt(ahead**2 + 0.01) - 0.1) + sign * 0.2 * ahead
    # The torso leans into its own acceleration.
    step = t[1] - t[0]
    push = smooth(np.gradient(np.gradient(base[:, 1:], step, axis=0), step, axis=0), 0.08)
    c["bend"] += 0.025 * (push[:, 0] * sin + push[:, 1] * cos)
    c["lean"] += 0.025 * (push[:, 0] * cos - push[:, 1] * sin)
