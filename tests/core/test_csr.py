from __future__ import annotations

import numpy as np

from mgjax.core.csr import expand_rows


def test_by_hand() -> None:
    first = np.array([0, 2, 2, 5])  # two items, none, three
    row, position = expand_rows(first, np.array([2, 1, 0, 2]))
    assert row.tolist() == [0, 0, 0, 2, 2, 3, 3, 3]
    assert position.tolist() == [2, 3, 4, 0, 1, 2, 3, 4]


def test_nothing_to_expand() -> None:
    none = np.zeros(0, np.int64)
    for first, keys in ((np.array([0]), none), (np.array([0, 0]), np.array([0, 0]))):
        row, position = expand_rows(first, keys)
        assert row.shape == position.shape == (0,)
