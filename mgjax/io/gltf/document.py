"""A GLB file taken apart: its JSON, with types checked where it is read, and its binary chunk.

GLB container: glTF 2.0 specification, section 4.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from mgjax.core.errors import FileFormatError
from mgjax.io.json_text import parse_json, shown
from mgjax.io.text import quoted, reason

_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_DOCUMENT = "a glTF 2.0 document"


@dataclass(frozen=True, kw_only=True)
class Document:
    """A GLB file.

    Attributes:
        path: of the file, for messages.
        json: the whole document; all its numbers are floats.
        binary: the chunk that buffer 0 stands for, or nothing.
    """

    path: Path
    json: dict[str, Any]
    binary: bytes

    def refuse(self, got: str, expected: str) -> NoReturn:
        raise FileFormatError(self.path, None, got, expected)

    def objects(self, holder: dict[str, Any], key: str) -> list[dict[str, Any]]:
        """A list of objects that may be missing."""
        values = holder.get(key, [])
        if not isinstance(values, list) or not all(isinstance(v, dict) for v in values):
            self.refuse(f"{shown(values)} as {key!r}", "a list of objects")
        return values

    def object(self, holder: dict[str, Any], key: str) -> dict[str, Any]:
        """An object that may be missing."""
        value = holder.get(key, {})
        if not isinstance(value, dict):
            self.refuse(f"{shown(value)} as {key!r}", "an object")
        return value

    def whole(self, holder: dict[str, Any], key: str, stop: float, default: int | None) -> int:
        """A whole number from 0 to below ``stop``; without a default it must be there."""
        value = holder.get(key, default)
        return self._whole(value, key, stop)

    def indices(self, holder: dict[str, Any], key: str, stop: int) -> list[int]:
        """A list of whole numbers below ``stop`` that may be missing."""
        values = holder.get(key, [])
        if not isinstance(values, list):
            self.refuse(f"{shown(values)} as {key!r}", "a list of indices")
        return [self._whole(value, key, stop) for value in values]

    def numbers(self, holder: dict[str, Any], key: str, count: int) -> list[float] | None:
        """So many finite numbers, or None where they are missing."""
        values = holder.get(key)
        if values is None:
            return None
        if (
            not isinstance(values, list)
            or len(values) != count
            or not all(isinstance(v, float) and abs(v) < 1e30 for v in values)
        ):
            self.refuse(f"{shown(values)} as {key!r}", f"{count} finite numbers")
        return values

    def text(self, holder: dict[str, Any], key: str, default: str) -> str:
        value = holder.get(key, default)
        if not isinstance(value, str):
            self.refuse(f"{shown(value)} as {key!r}", "a text")
        return value

    def _whole(self, value: Any, key: str, stop: float) -> int:
        if not isinstance(value, float | int) or value != value // 1 or not 0 <= value < stop:
            got = "no" if value is None else shown(value)
            self.refuse(f"{got} {key!r}", f"a whole number, 0 … {stop - 1:g}")
        return int(value)


def read_document(path: str | Path) -> Document:
    """Reads a GLB file; :class:`FileFormatError` if it is missing or no glTF 2.0."""
    try:
        data = Path(path).read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a path with a null byte
        raise FileFormatError(path, None, reason(error), "a readable GLB file") from None
    if len(data) < 12 or data[:4] != b"glTF":
        got = "an empty file" if not data else f"a file that begins with {quoted(repr(data[:4]))}"
        raise FileFormatError(path, None, got, "a GLB file, which begins with 'glTF'")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise FileFormatError(path, None, f"glTF version {version}", "version 2")
    if length > len(data):
        got = f"{len(data)} bytes of {length}"
        raise FileFormatError(path, None, got, "the whole GLB file")
    chunks = _chunks(path, data[:length])
    if not chunks or chunks[0][0] != _JSON:
        raise FileFormatError(path, None, "no JSON in the first chunk", _DOCUMENT)
    try:
        text = chunks[0][1].decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileFormatError(path, None, "JSON that is not UTF-8", _DOCUMENT) from None
    json = parse_json(path, text, expected=_DOCUMENT, nested=_DOCUMENT)
    if not isinstance(json, dict):
        raise FileFormatError(path, None, shown(json), _DOCUMENT)
    binary = next((chunk for kind, chunk in chunks[1:2] if kind == _BINARY), b"")
    return Document(path=Path(path), json=json, binary=binary)


def _chunks(path: str | Path, data: bytes) -> list[tuple[int, bytes]]:
    chunks: list[tuple[int, bytes]] = []
    at = 12
    while at + 8 <= len(data):
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > len(data):
            got = f"a chunk of {size} bytes where {len(data) - at - 8} are left"
            raise FileFormatError(path, None, got, "the whole GLB file")
        chunks.append((kind, data[at + 8 : at + 8 + size]))
        at += 8 + size
    return chunks
