"""How server and worker talk over a pipe: frames of a length, a tab, a kind and a payload."""

from __future__ import annotations

import struct
from enum import IntEnum
from io import BufferedIOBase

HEAD = struct.Struct("<IIB")
ALL = 0
"""In the place of a tab: all of them. Tabs are counted from 1."""


class Kind(IntEnum):
    """What a frame is.

    To the worker: ``OPEN`` and ``CLOSE`` a tab, ``TEXT`` of a message of its page. From the worker:
    ``TEXT`` or ``BYTES`` for a tab; ``STATE``, what whoever comes later has to be told as well;
    ``FAILED``, the sentence with which it ends.
    """

    OPEN = 0
    CLOSE = 1
    TEXT = 2
    BYTES = 3
    STATE = 4
    FAILED = 5


def frame(tab: int, kind: Kind, payload: bytes = b"") -> bytes:
    """A frame as bytes."""
    return HEAD.pack(len(payload), tab, kind) + payload


def read_frame(stream: BufferedIOBase) -> tuple[int, Kind, bytes] | None:
    """The next frame of a stream that blocks, or None at its end."""
    head = _exactly(stream, HEAD.size)
    if head is None:
        return None
    length, tab, kind = HEAD.unpack(head)
    payload = _exactly(stream, length)
    return None if payload is None else (tab, Kind(kind), payload)


def _exactly(stream: BufferedIOBase, count: int) -> bytes | None:
    data = stream.read(count)
    return data if data is not None and len(data) == count else None
