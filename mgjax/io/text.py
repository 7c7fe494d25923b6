"""Reading text files of numbers: one place for encodings and for pointing at the bad line."""

from __future__ import annotations

import math
from pathlib import Path

from mgjax.core.errors import FileFormatError, MgjaxError

MAX_POSES = 100_000_000
"""Frames × joints: two hours at 120 Hz of a body with fingers. More is a broken header."""

MAX_PLACE_M = 1e6
"""No joint is farther from the origin; float32 would be off by centimetres long before."""


def read_text(path: str | Path, kind: str) -> str:
    """The text of a file; :class:`FileFormatError` if it is missing, empty or binary."""
    try:
        data = Path(path).read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a path with a null byte
        raise FileFormatError(path, None, reason(error), f"a readable {kind} file") from None
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
        if not is_plain(token):
            raise ValueError
        value = float(token)
    except ValueError:
        raise FileFormatError(path, line, quoted(token), f"a number for {what}") from None
    if not math.isfinite(value):
        raise FileFormatError(path, line, quoted(token), f"a finite number for {what}")
    return value


def unfit(path: str | Path, error: MgjaxError) -> FileFormatError:
    """The error for a file whose skeleton or motion was refused by a check of these."""
    got, _, expected = str(error).partition(", expected ")
    return FileFormatError(path, None, got, expected or "a skeleton and a motion that fits it")


def is_plain(text: str) -> bool:
    """No digits of other scripts and no ``1_000``, which Python reads as numbers but files lack."""
    return text.isascii() and "_" not in text


def is_count(token: str) -> bool:
    """A plain whole number of at most 12 digits (``"²".isdigit()`` is true, ``int("²")`` fails)."""
    return token.isascii() and token.isdigit() and len(token) <= 12


def split_lines(text: str) -> list[str]:
    """Lines at LF, CRLF or CR only, as editors number them."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def check_size(path: str | Path, frames: int, joints: int) -> None:
    """Refuses a file whose poses could not be held in memory."""
    if frames * joints > MAX_POSES:
        got = f"{frames} frames of {joints} joints"
        raise FileFormatError(path, None, got, f"at most {MAX_POSES:.0e} joint rotations")


def quoted(token: str) -> str:
    """The token in quotes, shortened and without control characters, on one line."""
    short = token if len(token) <= 40 else token[:37] + "..."
    return ascii(short)


def reason(error: Exception) -> str:
    """Why the operating system refused, in lower case."""
    if isinstance(error, ValueError) and "null" in str(error):
        return "embedded null byte"  # each version of Python words it differently
    return (getattr(error, "strerror", None) or str(error)).lower()


def split_braces(line: str) -> list[str]:
    """Words of a line, braces being words of their own."""
    return line.replace("{", " { ").replace("}", " } ").split()
