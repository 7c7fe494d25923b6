from __future__ import annotations

import csv

import numpy as np

from mgjax.core.kinematics import global_positions
from mgjax.io.csv.write import save_csv
from tests.io.skeletons import CASES


def test_header_and_places(tmp_path):
    skeleton, motion = CASES["moving bones"]()
    save_csv(tmp_path / "x.csv", skeleton, motion)
    with (tmp_path / "x.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:5] == ["frame", "time", "root_x", "root_y", "root_z"]
    assert header[-1] == "rhumerus_end_z"
    values = np.array(rows, float)
    np.testing.assert_array_equal(values[:, 0], np.arange(9))
    np.testing.assert_allclose(values[:, 1], np.arange(9) / 120, atol=1e-6)
    want = global_positions(skeleton, motion).reshape(9, -1)
    np.testing.assert_allclose(values[:, 2:], want, atol=1e-6)


def test_names_with_commas_are_quoted(tmp_path):
    skeleton, motion = CASES["single"]()
    skeleton = type(skeleton)(names=('a,"b"',), parents=(-1,), offsets=skeleton.offsets)
    save_csv(tmp_path / "x.csv", skeleton, motion)
    with (tmp_path / "x.csv").open(newline="") as file:
        assert next(csv.reader(file))[2] == 'a,"b"_x'
