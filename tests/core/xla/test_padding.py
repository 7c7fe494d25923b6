from __future__ import annotations

import numpy as np
import pytest

from mgjax.core.xla.padding import bucket_size, pad_axis


@pytest.mark.parametrize(
    ("count", "want"), [(0, 16), (1, 16), (16, 16), (17, 32), (33, 64), (64, 64), (1000, 1024)]
)
def test_buckets(count, want):
    assert bucket_size(count) == want


def test_minimum():
    assert bucket_size(5, minimum=3) == 6


def test_pad_with_a_value_or_by_repeating():
    array = np.array([[1, 2], [3, 4]])
    np.testing.assert_array_equal(pad_axis(array, 3, value=-1), [[1, 2], [3, 4], [-1, -1]])
    np.testing.assert_array_equal(pad_axis(array, 3), [[1, 2], [3, 4], [3, 4]])
    np.testing.assert_array_equal(pad_axis(array, 4, axis=1), [[1, 2, 2, 2], [3, 4, 4, 4]])
    np.testing.assert_array_equal(pad_axis(array, 2), array)
    assert pad_axis(array, 3).dtype == array.dtype


def test_nothing_to_repeat():
    np.testing.assert_array_equal(pad_axis(np.zeros((0, 2)), 2), np.zeros((2, 2)))


def test_too_many():
    with pytest.raises(ValueError, match="cannot pad 3 items into 2"):
        pad_axis(np.zeros(3), 2)
