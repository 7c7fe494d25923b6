from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.crop import Crop, crop_attack
from mgjax.avoidance.index.cells import COVERED, LOWEST, SPAN, touched_cells
from mgjax.avoidance.index.swept_cells import swept_cells
from tests.avoidance.index.made import ball, cell_set, passing
from tests.avoidance.made import throw
from tests.reference import grid_index as reference


@pytest.mark.parametrize("gravity", [False, True])
def test_touched_cells(gravity: bool) -> None:
    rng = np.random.default_rng(int(gravity))
    for _ in range(6):
        attack = throw(rng, gravity=gravity)
        if gravity:  # the pieces themselves, without the margin for their curvature
            attack = replace(attack, acceleration=0.0)
        crop = crop_attack(attack, radius=1.0, height=2.3)
        assert crop is not None
        got = touched_cells(attack, crop)
        assert got is not None
        sure, perhaps = reference.touched(attack, crop.start, crop.end)
        assert sure <= cell_set(got) <= sure | perhaps
        assert len(sure) > 100


def test_touched_cells_by_hand() -> None:
    still = touched_cells(*ball((0.05, 1.05, 0.05), (0.05, 1.05, 0.05), radius=0.04))
    assert still is not None
    assert still.tolist() == [[0, 10, 0]]
    over = touched_cells(*ball((0.05, 1.05, 0.05), (0.05, 1.05, 0.05), radius=0.06))
    assert over is not None
    assert len(over) == 7  # the cell and its six neighbours; edges are 7.1 cm away
    along = touched_cells(*ball((-0.25, 1.05, 0.05), (0.25, 1.05, 0.05), radius=0.04))
    assert along is not None
    assert along.tolist() == [[i, 10, 0] for i in range(-3, 3)]
    there_and_back = touched_cells(
        *ball((0.05, 1.05, 0.05), (0.35, 1.05, 0.05), (0.05, 1.05, 0.05), radius=0.04)
    )
    assert there_and_back is not None
    assert there_and_back.tolist() == [[i, 10, 0] for i in range(4)]
    two = Attack(
        times=np.array([0.0, 1.0]),
        centres=np.array([[[0.05, 1.05, 0.05], [-1.05, 1.05, 0.05]]] * 2),
        radii=np.array([0.04, 0.01]),
    )
    both = touched_cells(two, Crop(start=0.0, end=1.0))
    assert both is not None
    assert both.tolist() == [[-11, 10, 0], [0, 10, 0]]


@pytest.mark.parametrize("radius", [1e-6, 0.3, 1.0, 50.0, 1000.0])
def test_touched_cells_of_strange_balls(radius: float) -> None:
    for places in (((0.0, 1.1, 0.0),) * 2, ((0.0, 1.2, 0.0), (0.0, 1.4, 0.0), (1.0, 1.2, 1.0))):
        attack, crop = ball(*places, radius=radius)
        got = touched_cells(attack, crop)
        assert (got is None) == (radius > 1.1)
        if got is not None:
            sure, perhaps = reference.touched(attack, crop.start, crop.end)
            assert sure <= cell_set(got) <= sure | perhaps
        instant = touched_cells(attack, Crop(start=1.0, end=1.0))
        assert (instant is None) == (radius > 1.1)


@pytest.mark.parametrize("kind", ["straight", "ballistic", "wandering", "along cells"])
def test_swept_cells_are_the_touched_cells(kind: str) -> None:
    rng = np.random.default_rng(len(kind))
    seen = 0
    for _ in range(60):
        attack, crop = passing(rng, kind)
        cells, swept = touched_cells(attack, crop), swept_cells(attack, crop)
        if cells is None or (cells < COVERED[0]).any() or (cells >= COVERED[1]).any():
            assert swept is None
            continue
        assert swept is not None
        column = (cells[:, 0] + SPAN // 2) * SPAN + cells[:, 2] + SPAN // 2 - swept.first
        bit = np.uint32(1) << (cells[:, 1] - LOWEST).astype(np.uint32)
        assert (swept.perhaps()[column] & bit).all()
        image = np.zeros_like(swept.sure)
        np.bitwise_or.at(image, column, bit)
        assert not (swept.sure & ~image).any()
        around = np.unique(cells[rng.integers(len(cells), size=80)], axis=0)
        around = np.unique(around + rng.integers(-1, 2, (len(around), 3)), axis=0)
        around = around[((around >= COVERED[0]) & (around < COVERED[1])).all(axis=1)]
        known = cell_set(cells)
        assert swept.touches(around).tolist() == [tuple(c) in known for c in around.tolist()]
        seen += 1
    assert seen > 20


def test_swept_cells_outside_the_covered_space() -> None:
    # As with the cells: a centimetre of a sphere under the lowest cells or beyond the last ones.
    for place, inside in (((0, 0.01, 0), True), ((0, -0.09, 0), False), ((12.75, 1, 0), False)):
        attack, crop = ball(place, place, radius=0.12)
        assert (swept_cells(attack, crop) is not None) == inside
