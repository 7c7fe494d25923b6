from __future__ import annotations

import numpy as np
import pytest

from mgjax.clips.retarget.plants import held_still


def ease(t: float) -> float:
    return 3 * t**2 - 2 * t**3


def line(count: int, step: float) -> np.ndarray:
    """Along x with a height that tells the frame."""
    x = step * np.arange(count, dtype=np.float64)
    return np.stack([x, 0.01 * np.arange(count), 2 * x], axis=1)


def on(text: str) -> np.ndarray:
    return np.array([c == "1" for c in text])


def plainly(path: np.ndarray, planted: np.ndarray, frame_rate: float) -> np.ndarray:
    """The definition, run by run and frame by frame."""
    runs: list[list[int]] = []
    for frame in np.flatnonzero(planted):
        if runs and frame - runs[-1][-1] - 1 <= 0.1 * frame_rate:
            runs[-1] = list(range(runs[-1][0], frame + 1))
        else:
            runs.append([int(frame)])
    shifts: dict[int, np.ndarray] = {}
    for run in runs:
        middle = path[run].mean(axis=0)
        away = max(np.hypot(*(path[f] - middle)[[0, 2]]) for f in run)
        for f in run:
            shifts[f] = (middle - path[f]) * [1, 0, 1] * (away <= 0.03)
    result = path.copy()
    known = sorted(shifts)
    for f in range(len(path)) if known else ():
        before = max((k for k in known if k <= f), default=known[0])
        after = min((k for k in known if k >= f), default=known[-1])
        share = ease((f - before) / (after - before)) if after > before else 0.0
        share = share if before <= f <= after else 0.0
        result[f] += shifts[before] * (1 - share) + shifts[after] * share
    return result


def test_nothing_planted_nothing_moves():
    path = line(8, 0.01)
    np.testing.assert_array_equal(held_still(path, on("00000000"), 30.0), path)


def test_two_plants_by_hand():
    path = line(12, 0.001)
    got = held_still(path, on("111000000111"), 30.0)
    # Middles at 0.001 and 0.010; the shift −0.001 of frame 2 fades to +0.001 of frame 9.
    want = path[:, 0].copy()
    want[:3], want[9:] = 0.001, 0.010
    for f in range(3, 9):
        share = ease((f - 2) / 7)
        want[f] += -0.001 * (1 - share) + 0.001 * share
    np.testing.assert_allclose(got[:, 0], want, atol=1e-12)
    np.testing.assert_allclose(got[:, 2], 2 * want, atol=1e-12)
    np.testing.assert_array_equal(got[:, 1], path[:, 1])


def test_short_gaps_do_not_lift_a_foot():
    path = line(12, 0.001)
    got = held_still(path, on("111100011111"), 30.0)
    np.testing.assert_allclose(got[:, 0], path[:, 0].mean())


def test_a_foot_that_slides_on_purpose_slides():
    path = line(20, 0.01)
    np.testing.assert_array_equal(held_still(path, on("1" * 20), 30.0), path)


@pytest.mark.parametrize("seed", range(12))
def test_as_the_definition(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 120))
    path = np.cumsum(rng.normal(size=(count, 3)) * 0.004, axis=0)
    planted = np.repeat(rng.random(count) < 0.5, int(rng.integers(1, 6)))[:count]
    for rate in (30.0, 7.0):
        np.testing.assert_allclose(
            held_still(path, planted, rate), plainly(path, planted, rate), atol=1e-12
        )
