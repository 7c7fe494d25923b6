"""The speed that changes least, by brute force: the walk in small steps, one after another."""

from __future__ import annotations

import math

import numpy as np

STEPS = 4000
"""Steps into which a walk is cut."""


def fastest(
    runs: list[tuple[float, float]], leeway: float, rate: float
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and speeds of a body that changes its speed by at most ``rate`` a second.

    Runs are (length, speed). The body begins at speed 1, is nowhere faster than ``leeway`` times
    the run's speed, ends at most at the speed of the last run, and is as fast as that allows; where
    runs are slow, as slow.
    """
    total = sum(length for length, _ in runs)
    step = total / STEPS
    faster = any(speed > 1 for _, speed in runs)
    squares = []
    for i in range(STEPS + 1):
        place, at = i * step, 0
        while at < len(runs) - 1 and place > sum(length for length, _ in runs[: at + 1]):
            at += 1
        speed = runs[at][1]
        squares.append((speed * leeway if faster else speed / leeway) ** 2)
    squares[0], squares[-1] = 1.0, runs[-1][1] ** 2
    # v dv/dx is the change per second: over a step the square changes by at most 2 rate dx.
    most = 2 * rate * step
    for order in (range(1, STEPS + 1), range(STEPS - 1, -1, -1)):
        for i in order:
            beside = squares[i - 1] if order.step > 0 else squares[i + 1]
            if faster:
                squares[i] = min(squares[i], beside + most)
            else:
                squares[i] = max(squares[i], beside - most)
    return step * np.arange(STEPS + 1), np.sqrt(squares)


def times_of(places: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """When each place is reached, by the trapezoid rule on the slowness."""
    times = [0.0]
    for i in range(1, len(places)):
        slow = 0.5 * (1 / speeds[i - 1] + 1 / speeds[i])
        times.append(times[-1] + (places[i] - places[i - 1]) * slow)
    return np.array(times)


def slowest_change(runs: list[tuple[float, float]], leeway: float, seconds: float) -> float:
    """The least rate with which the runs take ``seconds``."""
    faster = any(speed > 1 for _, speed in runs)
    low, high = 1e-3, 1e4
    for _ in range(28):
        rate = math.sqrt(low * high)
        late = times_of(*fastest(runs, leeway, rate))[-1] > seconds
        if late == faster:
            low = rate
        else:
            high = rate
    return high
