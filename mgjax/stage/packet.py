"""Records with arrays as bytes, and back: what goes to the page and what is kept in its files.

A packet is ``MGS1``, the length of a header as a 32-bit little-endian number, the header (JSON in
UTF-8, padded with spaces to a multiple of four bytes) and the arrays, each at a multiple of four.
The header is ``{"value": …, "arrays": [{"type", "shape", "at"}]}``: in ``value`` an array is
``{"$array": number}``, and ``at`` counts bytes from the end of the header.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from mgjax.core.errors import MgjaxError

MAGIC = b"MGS1"
TYPES = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32")


def pack(value: Any) -> bytes:
    """A packet of a value of dicts, lists, strings, finite numbers, None and arrays.

    Arrays of other types than :data:`TYPES` have to be converted before; what is not finite stays
    so inside arrays, but is no number of JSON.
    """
    arrays: list[np.ndarray] = []
    plain = _without_arrays(value, arrays)
    entries, at = [], 0
    for array in arrays:
        entries.append({"type": array.dtype.name, "shape": list(array.shape), "at": at})
        at += array.nbytes + -array.nbytes % 4
    header = json.dumps({"value": plain, "arrays": entries}, allow_nan=False).encode()
    header += b" " * (-len(header) % 4)
    parts = [MAGIC, struct.pack("<I", len(header)), header]
    for array in arrays:
        data = array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes()
        parts += [data, bytes(-len(data) % 4)]
    return b"".join(parts)


def _without_arrays(value: Any, arrays: list[np.ndarray]) -> Any:
    """The value with a reference in the place of each array, which is added to ``arrays``."""
    if isinstance(value, np.ndarray):
        if value.dtype.name not in TYPES:
            raise TypeError(f"got an array of {value.dtype.name}, expected one of {TYPES}")
        arrays.append(np.ascontiguousarray(value))
        return {"$array": len(arrays) - 1}
    if isinstance(value, dict):
        return {str(key): _without_arrays(item, arrays) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_arrays(item, arrays) for item in value]
    if isinstance(value, np.generic):
        return value.item()
    return value


def unpack(data: bytes) -> Any:
    """The value of a packet; :class:`MgjaxError` where the bytes are none."""
    try:
        if data[:4] != MAGIC:
            raise ValueError(f"begins with {data[:4]!r}")
        (length,) = struct.unpack("<I", data[4:8])
        header = json.loads(data[8 : 8 + length])
        arrays = [_array(data, 8 + length, entry) for entry in header["arrays"]]
        return _with_arrays(header["value"], arrays)
    except (ValueError, KeyError, TypeError, IndexError, struct.error, RecursionError) as error:
        raise MgjaxError(got=f"bytes that are no packet ({error})", expected="MGS1") from None


def _array(data: bytes, base: int, entry: dict[str, Any]) -> np.ndarray:
    if entry["type"] not in TYPES:
        raise ValueError(f"an array of {entry['type']!r}")
    shape = tuple(int(n) for n in entry["shape"])
    dtype = np.dtype(entry["type"]).newbyteorder("<")
    at = base + int(entry["at"])
    count = int(np.prod(shape, dtype=np.int64))
    if min(shape, default=0) < 0 or at < base:
        raise ValueError("a negative size")
    return np.frombuffer(data, dtype, count, at).reshape(shape).astype(dtype.newbyteorder("="))


def _with_arrays(value: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(value, dict):
        if value.keys() == {"$array"}:
            return arrays[value["$array"]]
        return {key: _with_arrays(item, arrays) for key, item in value.items()}
    if isinstance(value, list):
        return [_with_arrays(item, arrays) for item in value]
    return value
