from __future__ import annotations

import numpy as np
import pytest

from mgjax.core.errors import ConfigError
from mgjax.io.units import UNITS, find_unit

CHAIN = (-1, 0, 1)


def rest(height: float, axis: int = 1) -> np.ndarray:
    offsets = np.zeros((3, 3))
    offsets[1:, axis] = height / 2
    return offsets


@pytest.mark.parametrize(
    ("height", "name"),
    [
        (1.6, "metre"),
        (1.1, "metre"),
        (2.4, "metre"),
        (160, "centimetre"),
        (90, "centimetre"),
        (28, "CMU unit (0.0254/0.45 m)"),
        (35, "CMU unit (0.0254/0.45 m)"),
        (16, "CMU unit (0.0254/0.45 m)"),
    ],
)
def test_the_unit_nearest_to_a_body(height, name):
    assert find_unit(rest(height), CHAIN).name == name
    assert find_unit(rest(height, axis=2), CHAIN).name == name  # lying, or Z up


def test_named_units():
    for name, unit in UNITS.items():
        assert find_unit(rest(160), CHAIN, name) is unit
    with pytest.raises(ConfigError, match="'in', expected one of m, cm, cmu"):
        find_unit(rest(160), CHAIN, "in")


def test_nothing_to_measure():
    assert find_unit(np.zeros((3, 3)), CHAIN).name == "metre"
    # The root's own offset is a place, not a bone.
    offsets = rest(1.6)
    offsets[0] = 500
    assert find_unit(offsets, CHAIN).name == "metre"
