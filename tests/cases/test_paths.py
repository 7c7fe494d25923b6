"""Path files of other tools."""

from __future__ import annotations

import numpy as np
import pytest

from mgjax.hybrid.paths.sketch import load_sketch
from tests.cases.inputs import case_file, cases

NAMES = ("header", "bom_crlf", "comment", "tabs", "point_twice")


@pytest.mark.parametrize("name", NAMES)
def test_read_as_with_a_header(name: str) -> None:
    wanted = load_sketch(case_file("paths/header.csv"))
    assert wanted.points.tolist() == [[0, 0], [0, 1], [0.5, 2], [1.2, 3]]
    found = load_sketch(case_file(f"paths/{name}.csv"))
    np.testing.assert_array_equal(found.points, wanted.points)
    assert np.isnan(found.speed).all()


def test_all_cases_are_tested() -> None:
    case_file("expected.json")
    assert {entry["input"] for entry in cases("paths")} == {f"paths/{n}.csv" for n in NAMES}
