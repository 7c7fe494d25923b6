from __future__ import annotations

import numpy as np
import pytest

from mgjax.graph.parts.margins import allowed_windows, label_margins


def track(steps: list[float]) -> np.ndarray:
    """Two joints, of which one stands still and one moves so far from frame to frame."""
    places = np.zeros((len(steps) + 1, 2, 3))
    places[1:, 1, 0] = np.cumsum(steps)
    return places


def test_worked_by_hand():
    # Peak 10: below 2 are the first two steps and the last one.
    moved = track([1, 1.9, 2, 10, 5, 2, 1])
    whole = np.array([[0, 8]])
    np.testing.assert_array_equal(label_margins(moved, whole, quiet=0.2, overlap=0.0), [[2, 1]])
    np.testing.assert_array_equal(label_margins(moved, whole, quiet=0.0, overlap=0.0), [[0, 0]])
    np.testing.assert_array_equal(label_margins(moved, whole, quiet=0.2, overlap=0.25), [[2, 2]])
    # Never half of it: a middle is left, also of a label of one frame or one that stands still.
    np.testing.assert_array_equal(label_margins(moved, whole, quiet=1.0, overlap=0.0), [[3, 3]])
    np.testing.assert_array_equal(
        label_margins(
            track([0.0] * 7), np.array([[2, 3], [2, 4], [2, 7]]), quiet=0.2, overlap=0.49
        ),
        [[0, 0], [0, 0], [2, 2]],
    )


@pytest.mark.parametrize("window", [1, 3, 4])
def test_windows_against_loops(window):
    rng = np.random.default_rng(window)
    starts, stops = np.array([0, 12, 15]), np.array([12, 15, 40])
    cores = np.array([[4, 6], [18, 19], [19, 23], [39, 40]])
    leave, arrive = allowed_windows(starts, stops, cores[:, 0], cores[:, 1], window)
    for frame in rng.permutation(40):
        clip = int(np.searchsorted(starts, frame, side="right")) - 1
        frames = range(frame, frame + window)
        free = frames[-1] < stops[clip] and not any(a <= f < b for f in frames for a, b in cores)
        assert leave[frame] == (free and frame > starts[clip])
        assert arrive[frame] == (free and frame + window < stops[clip])
    assert leave.any()
