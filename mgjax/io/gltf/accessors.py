"""Typed arrays of a GLB file: strided, normalised, sparse (glTF 2.0, sections 3.6.2 and 3.11)."""

from __future__ import annotations

import base64
import binascii
from typing import Any

import numpy as np

from mgjax.io.gltf.document import Document
from mgjax.io.text import MAX_POSES

_TYPES: dict[int, type[np.generic]] = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_DATA = "data:application/"


def read_accessor(document: Document, index: int, width: int) -> np.ndarray:
    """One accessor's values as float64.

    Args:
        document: the file.
        index: of the accessor.
        width: how many numbers an element must have.

    Returns:
        [count, width]; normalised integers are divided so that they lie in −1 … 1.

    Raises:
        FileFormatError: it points outside the file, or is of another type; a value is not finite.
    """
    accessor = document.objects(document.json, "accessors")[index]
    dtype = _component_type(document, accessor)
    kind = document.text(accessor, "type", "none")
    if _WIDTHS.get(kind) != width:
        document.refuse(f"accessor {index} of type {kind!r}", f"one of {width} numbers an element")
    count = document.whole(accessor, "count", MAX_POSES, None)
    values = np.zeros((count, width), dtype)
    if "bufferView" in accessor:
        values = _read_view(document, accessor, count, width, dtype)
    if "sparse" in accessor:
        values = _patched(document, document.object(accessor, "sparse"), values)
    result = values.astype(np.float64)
    if accessor.get("normalized") is True and np.issubdtype(dtype, np.integer):
        result = np.maximum(result / np.iinfo(dtype).max, -1.0)  # pyright: ignore
    if not np.isfinite(result).all():
        document.refuse(f"NaN or infinity in accessor {index}", "finite numbers")
    return result


def _component_type(document: Document, holder: dict[str, Any]) -> np.dtype:
    code = document.whole(holder, "componentType", 1e6, None)
    if code not in _TYPES:
        document.refuse(f"component type {code}", f"one of {', '.join(map(str, _TYPES))}")
    return np.dtype(_TYPES[code]).newbyteorder("<")


def _patched(document: Document, sparse: dict[str, Any], values: np.ndarray) -> np.ndarray:
    """The values with some elements replaced."""
    count = document.whole(sparse, "count", len(values) + 1, None)
    where, what = document.object(sparse, "indices"), document.object(sparse, "values")
    places = _read_view(document, where, count, 1, _component_type(document, where))[:, 0]
    if count and (places.dtype.kind != "u" or int(places.max()) >= len(values)):
        document.refuse("a sparse accessor that points outside itself", f"below {len(values)}")
    values = values.copy()
    values[places] = _read_view(document, what, count, values.shape[1], values.dtype)
    return values


def _read_view(
    document: Document, holder: dict[str, Any], count: int, width: int, dtype: np.dtype
) -> np.ndarray:
    """[count, width] of the buffer view that an accessor, or a part of a sparse one, names."""
    views = document.objects(document.json, "bufferViews")
    view = views[document.whole(holder, "bufferView", len(views), None)]
    if "EXT_meshopt_compression" in document.object(view, "extensions"):
        document.refuse("data compressed by EXT_meshopt_compression", "plain data")
    data = _buffer(document, view)
    start = document.whole(view, "byteOffset", 2**53, 0)
    stop = start + document.whole(view, "byteLength", 2**53, None)
    start += document.whole(holder, "byteOffset", 2**53, 0)
    size = width * dtype.itemsize
    stride = document.whole(view, "byteStride", 253, 0) or size
    last = start + stride * (count - 1) + size if count else start
    if stride < size or last > min(stop, len(data)):
        document.refuse(
            f"an accessor up to byte {last} with a stride of {stride}",
            f"one in the {min(stop, len(data))} bytes of its buffer view",
        )
    if not count:
        return np.zeros((0, width), dtype)
    rows = np.lib.stride_tricks.as_strided(
        np.frombuffer(data, np.uint8, offset=start), (count, size), (stride, 1), writeable=False
    )
    return np.ascontiguousarray(rows).view(dtype)


def _buffer(document: Document, view: dict[str, Any]) -> bytes:
    buffers = document.objects(document.json, "buffers")
    buffer = buffers[document.whole(view, "buffer", len(buffers), None)]
    if "uri" not in buffer:
        return document.binary
    uri = document.text(buffer, "uri", "")
    header, _, text = uri.partition(";base64,")
    if not header.startswith(_DATA):
        document.refuse("a buffer in another file", "a GLB file that holds all its data")
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        document.refuse("a buffer that is no base64", "base64 after ';base64,'")
