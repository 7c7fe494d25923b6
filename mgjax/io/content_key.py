"""A short name for content: equal content has equal names, other content other ones."""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Any

import numpy as np


def content_key(*parts: Any) -> str:
    """32 hexadecimal digits (BLAKE2b) that name what is given.

    Args:
        parts: arrays, numbers, words, bytes, None, and dataclasses, mappings and sequences of
            these. Types count: 1 and 1.0 differ, as do arrays of another type or shape.

    Raises:
        TypeError: something else.
    """
    digest = hashlib.blake2b(digest_size=16)
    for part in parts:
        _add(digest, part)
    return digest.hexdigest()


def _add(digest: hashlib.blake2b, part: Any) -> None:
    def tagged(tag: str, data: bytes) -> None:
        digest.update(f"{tag}:{len(data)}:".encode())
        digest.update(data)

    if isinstance(part, bytes):
        tagged("bytes", part)
    elif part is None or isinstance(part, (bool, int, float, str)):
        tagged(type(part).__name__, repr(part).encode())
    elif isinstance(part, dict):
        tagged("dict", str(len(part)).encode())
        for key in sorted(part):
            _add(digest, key)
            _add(digest, part[key])
    elif isinstance(part, (tuple, list)):
        tagged("list", str(len(part)).encode())
        for item in part:
            _add(digest, item)
    elif dataclasses.is_dataclass(part):
        tagged("record", type(part).__name__.encode())
        for field in dataclasses.fields(part):
            _add(digest, field.name)
            _add(digest, getattr(part, field.name))
    elif hasattr(part, "__array__"):
        array = np.ascontiguousarray(part)
        tagged("array", f"{array.dtype.str}{np.shape(part)}".encode())
        digest.update(array.reshape(-1).view(np.uint8).data if array.size else b"")
    else:
        raise TypeError(f"got {type(part).__name__}, expected arrays and plain values")
