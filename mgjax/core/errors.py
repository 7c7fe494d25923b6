"""The errors that a user's input can cause, each with one clear line of text.

Everything here is a subclass of :class:`MgjaxError`, itself a ``ValueError``. The command line
prints ``str(error)`` and exits with status 2; nothing else is meant to reach a user.
"""

from __future__ import annotations

from pathlib import Path


class MgjaxError(ValueError):
    """Base of all errors that bad input can cause."""


def printable(path: str | Path) -> str:
    """A path as it is, but on one line: control characters are escaped."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in str(path))


class FileFormatError(MgjaxError):
    """A file that cannot be read as what it claims to be.

    Attributes:
        path: the file.
        line: 1-based line number, or None where the whole file is meant.
        got: what stands there.
        expected: what should.
    """

    def __init__(self, path: str | Path, line: int | None, got: str, expected: str) -> None:
        self.path = Path(path)
        self.line = line
        self.got = got
        self.expected = expected
        place = printable(path) if line is None else f"{printable(path)}:{line}"
        super().__init__(f"{place}: got {got}, expected {expected}")


class SkeletonError(MgjaxError):
    """A skeleton that lacks a joint that is needed, or differs from the one it must equal."""


class MotionError(MgjaxError):
    """Motion data that cannot be used as asked (too short, a bad range, no rigid bones)."""


class LabelError(FileFormatError):
    """A labelled interval that is not valid on its clip."""


class ConfigError(MgjaxError):
    """A setting that is unknown or out of range."""


class GraphError(MgjaxError):
    """Clips and settings from which no usable motion graph results."""


class AttackError(MgjaxError):
    """An attack that cannot be: it never arrives, starts inside the body, is not finite."""


class OutputError(MgjaxError):
    """A folder or file that cannot be written."""
