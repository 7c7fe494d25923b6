"""What stands, lies, and goes on all fours."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.io.reading.read_as import AXES
from mgjax.io.reading.upright import axis_vector, floor_level, on_floor, on_four_legs, turn_to_y

ROLES = {
    name: number
    for number, name in enumerate(
        f"{side}_{part}"
        for side in ("left", "right")
        for part in ("hip", "knee", "ankle", "shoulder", "wrist")
    )
} | {"chest": 10, "head": 11}


def pose(**joints: tuple[float, float]) -> np.ndarray:
    """[1,J,3] places from (height, ahead) of the joints of both sides."""
    places = np.zeros((1, 12, 3))
    for role, at in ROLES.items():
        part = role.rpartition("_")[2]
        side = {"left": 0.1, "right": -0.1}.get(role.partition("_")[0], 0.0)
        if part in joints:
            places[0, at] = (side, *joints[part])
    return places


STANDS = pose(hip=(0.9, 0), knee=(0.5, 0), ankle=(0.08, 0), chest=(1.3, 0), wrist=(0.8, 0.1))
CRAWLS = pose(
    hip=(0.45, 0), knee=(0.05, 0.1), ankle=(0.08, -0.3), chest=(0.5, 0.4), wrist=(0.05, 0.5)
)
HORSE = pose(hip=(0.85, 0), knee=(0.45, 0.1), ankle=(0.05, 0), chest=(0.9, 0.8), wrist=(0.05, 0.8))


@pytest.mark.parametrize(("places", "animal"), [(STANDS, False), (CRAWLS, False), (HORSE, True)])
def test_four_legs(places: np.ndarray, animal: bool) -> None:
    assert on_four_legs(places, ROLES) == animal
    assert not on_four_legs(places, {"root": 0})
    # In most frames, and not in a few.
    mixed = np.concatenate([places] + [STANDS] * 4)
    assert not on_four_legs(mixed, ROLES)


@pytest.mark.parametrize("axis", AXES)
def test_each_axis_is_turned_up(axis: str) -> None:
    turn = turn_to_y(axis)
    np.testing.assert_allclose(turn @ axis_vector(axis), [0, 1, 0])
    np.testing.assert_allclose(turn @ turn.T, np.eye(3))
    assert np.linalg.det(turn) == pytest.approx(1)


def test_the_floor_is_low_but_no_outlier() -> None:
    heights = np.concatenate([[-0.5], np.full(40, 0.02), np.linspace(0.02, 0.4, 30)])
    assert floor_level(heights) == pytest.approx(0.02)
    assert on_floor(heights, 1.7)
    assert not on_floor(heights - 0.3, 1.7)
