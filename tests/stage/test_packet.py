import json
import struct

import numpy as np
import pytest

from mgjax.core.errors import MgjaxError
from mgjax.stage.packet import TYPES, pack, unpack


def test_values_and_arrays_come_back():
    value = {
        "title": "Ä ball",
        "numbers": [1, 2.5, None, True],
        "nested": [{"array": np.arange(6, dtype=np.int16).reshape(2, 3)}],
        "empty": np.zeros((0, 3), np.float32),
    }
    back = unpack(pack(value))
    np.testing.assert_array_equal(back["nested"][0].pop("array"), value["nested"][0].pop("array"))
    assert back.pop("empty").shape == (0, 3)
    value.pop("empty")
    assert back == value


@pytest.mark.parametrize("name", TYPES)
def test_every_type_keeps_type_and_shape(name):
    array = np.array([[0, 1, 100]], name)
    back = unpack(pack(array))
    assert back.dtype == array.dtype
    assert back.shape == array.shape
    np.testing.assert_array_equal(back, array)


def test_bytes_by_hand():
    data = pack({"a": np.array([1, 2, 3], np.uint8)})
    (length,) = struct.unpack("<I", data[4:8])
    assert data[:4] == b"MGS1"
    assert length % 4 == 0
    assert len(data) == 8 + length + 4
    header = json.loads(data[8 : 8 + length])
    assert header == {
        "value": {"a": {"$array": 0}},
        "arrays": [{"type": "uint8", "shape": [3], "at": 0}],
    }
    assert data[8 + length :] == b"\x01\x02\x03\x00"


@pytest.mark.parametrize(
    "spoil",
    [
        lambda d: b"",
        lambda d: b"XXXX" + d[4:],
        lambda d: d[:-4],
        lambda d: d[:4] + struct.pack("<I", 2**31) + d[8:],
        lambda d: d.replace(b'"at": 0', b'"at":-9'),
    ],
)
def test_other_bytes_are_refused(spoil):
    data = pack({"a": np.arange(4, dtype=np.float32)})
    with pytest.raises(MgjaxError, match="no packet"):
        unpack(spoil(data))


def test_what_the_page_cannot_read_is_not_packed():
    with pytest.raises(TypeError, match="float64"):
        pack(np.zeros(2))
    with pytest.raises(ValueError, match="JSON"):
        pack({"a": float("nan")})
