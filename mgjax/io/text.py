"""Reading text files of numbers: one place for encodings and for pointing at the bad line."""

from __future__ import annotations

import math
from pathlib import Path

from mgjax.core.errors import FileFormatError


def read_text(path: str | Path, kind: str) -> str:
    """The text of a file; :class:`FileFormatError` if it is missing, empty or binary."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FileFormatError(path, None, _reason(error), f"a readable {kind} file") from None
    if not data.strip():
        raise FileFormatError(path, None, "an empty file", f"a {kind} file")
    if b"\0" in data:
        raise FileFormatError(path, None, "binary data", f"a {kind} file, which is text")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def parse_number(path: str | Path, line: int, token: str, what: str) -> float:
    """A finite number; otherwise an error that names file, line and what it should have been."""
    try:
        value = float(token)
    except ValueError:
        raise FileFormatError(path, line, quoted(token), f"a number for {what}") from None
    if not math.isfinite(value):
        raise FileFormatError(path, line, quoted(token), f"a finite number for {what}")
    return value


def quoted(token: str) -> str:
    """The token in quotes, shortened and without control characters, on one line."""
    short = token if len(token) <= 40 else token[:37] + "..."
    return ascii(short)


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()
