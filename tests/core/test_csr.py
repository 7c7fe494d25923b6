from __future__ import annotations

import numpy as np

from mgjax.core import csr


def test_by_hand() -> None:
    counts = np.array([2, 0, 3])
    assert csr.row_starts(counts).tolist() == [0, 2, 2, 5]
    row, rank = csr.expand(counts)
    assert row.tolist() == [0, 0, 2, 2, 2]
    assert rank.tolist() == [0, 1, 0, 1, 2]
    slot, place = csr.expand_rows(np.array([0, 2, 2, 5]), np.array([2, 1, 0, 2]))
    assert slot.tolist() == [0, 0, 0, 2, 2, 3, 3, 3]
    assert place.tolist() == [2, 3, 4, 0, 1, 2, 3, 4]


def test_nothing() -> None:
    nothing = np.zeros(0, np.int64)
    assert csr.row_starts(nothing).tolist() == [0]
    for pair in (
        csr.expand(nothing),
        csr.expand(np.zeros(4, np.int64)),
        csr.expand_rows(np.array([0, 3]), nothing),
    ):
        assert [part.tolist() for part in pair] == [[], []]


def test_by_loops() -> None:
    rng = np.random.default_rng(0)
    counts = rng.integers(0, 6, 50)
    starts = csr.row_starts(counts)
    keys = rng.integers(0, 50, 30)
    wanted = [(i, k) for i, n in enumerate(counts) for k in range(n)]
    assert np.stack(csr.expand(counts), axis=-1).tolist() == [list(pair) for pair in wanted]
    wanted = [(i, k) for i, key in enumerate(keys) for k in range(starts[key], starts[key + 1])]
    assert np.stack(csr.expand_rows(starts, keys), axis=-1).tolist() == [list(p) for p in wanted]


def test_by_hand_of_keys() -> None:
    first = np.array([0, 2, 2, 5])  # two items, none, three
    row, position = csr.expand_rows(first, np.array([2, 1, 0, 2]))
    assert row.tolist() == [0, 0, 0, 2, 2, 3, 3, 3]
    assert position.tolist() == [2, 3, 4, 0, 1, 2, 3, 4]


def test_nothing_to_expand() -> None:
    none = np.zeros(0, np.int64)
    for first, keys in ((np.array([0]), none), (np.array([0, 0]), np.array([0, 0]))):
        row, position = csr.expand_rows(first, keys)
        assert row.shape == position.shape == (0,)
