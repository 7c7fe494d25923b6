from __future__ import annotations

import numpy as np
import pytest

from mgjax.core.errors import PathError
from mgjax.stage.apps.sketch.strokes import meets, path_of_stroke


def along(*corners: tuple[float, float]) -> np.ndarray:
    """A stroke straight from corner to corner, a place every 2 cm."""
    parts = []
    for start, end in zip(np.array(corners[:-1]), np.array(corners[1:]), strict=True):
        share = np.arange(0, 1, 0.02 / np.linalg.norm(end - start))
        parts.append(start + share[:, None] * (end - start))
    return np.concatenate([*parts, [corners[-1]]])


def test_a_trembling_line_becomes_straight_with_its_ends_where_they_were() -> None:
    line = along((0, 0), (0, 5))
    drawn = line + np.random.default_rng(0).normal(0, 0.02, line.shape)
    points = path_of_stroke(drawn, smooth=True, closed=False)
    assert np.abs(points[1:-1, 0]).max() < 0.02
    np.testing.assert_allclose(points[[0, -1]], drawn[[0, -1]], atol=0.03)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.min() > 0.35
    assert steps.max() < 0.55


def test_corners_are_kept_where_it_is_not_to_be_smooth() -> None:
    points = path_of_stroke(along((0, 0), (0, 2), (2, 2)), smooth=False, closed=False)
    assert np.linalg.norm(points - [0, 2], axis=1).min() < 0.05
    on_lines = np.minimum(np.abs(points[:, 0]), np.abs(points[:, 1] - 2))
    assert on_lines.max() < 0.05
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() <= 0.9 + 1e-3


def test_a_square_is_closed_and_its_first_point_is_not_repeated() -> None:
    stroke = along((0, 0), (0, 2), (2, 2), (2, 0), (0.1, 0))
    assert meets(stroke)
    points = path_of_stroke(stroke, smooth=False, closed=True)
    for corner in ((0, 0), (0, 2), (2, 2), (2, 0)):
        assert np.linalg.norm(points - np.array(corner), axis=1).min() < 0.06
    assert np.linalg.norm(points[0] - points[-1]) > 0.3


def test_a_smooth_ring_keeps_its_size() -> None:
    angle = np.linspace(0, 2 * np.pi, 300)[:-1]
    ring = 1.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = path_of_stroke(ring, smooth=True, closed=True)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.5, atol=0.02)


def test_a_short_stroke_that_ends_near_its_beginning_is_no_ring() -> None:
    assert not meets(along((0, 0), (0, 0.3)))
    assert not meets(along((0, 0), (0, 5)))


def test_points_are_whole_millimetres() -> None:
    points = path_of_stroke(along((0.1234567, 0), (3, 1)), smooth=True, closed=False)
    np.testing.assert_array_equal(points, np.round(points, 3))


@pytest.mark.parametrize("stroke", [[[0, 0], [0, 0.1]], [[1, 1], [1, 1]], [[1, 1]]])
def test_a_slip_of_the_hand_is_refused(stroke: list[list[float]]) -> None:
    with pytest.raises(PathError, match="expected at least 40 cm"):
        path_of_stroke(np.array(stroke, np.float64), smooth=True, closed=False)
