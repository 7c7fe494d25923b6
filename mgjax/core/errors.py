"""The errors that a user's input can cause, each with one clear line of text.

Everything here is a subclass of :class:`MgjaxError`, itself a ``ValueError``. The command line
prints ``str(error)`` and exits with status 2; nothing else is meant to reach a user.
"""

from __future__ import annotations

from pathlib import Path


class MgjaxError(ValueError):
    """Base of all errors that bad input can cause.

    Give it ``got`` and ``expected``, so that whoever knows the place better can say it again with
    that place; or a whole message, where it has another form.

    Attributes:
        got: what stands there; "" where the message is whole.
        expected: what should.
        place: where, such as a file and line, or "".
    """

    def __init__(
        self, message: str = "", *, got: str = "", expected: str = "", place: str = ""
    ) -> None:
        self.got, self.expected, self.place = got, expected, place
        prefix = f"{place}: " if place else ""
        super().__init__(prefix + (message or f"got {got}, expected {expected}"))


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
        place = printable(path) if line is None else f"{printable(path)}:{line}"
        super().__init__(got=got, expected=expected, place=place)


class ArgumentError(MgjaxError, TypeError):
    """An argument of a call that is of another kind or shape than the function takes."""


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


class PathError(MgjaxError):
    """A sketched path that cannot be followed as it is: points, speeds, obstacles, its start."""


class ReachError(MgjaxError):
    """A target that cannot be one."""


class OutputError(MgjaxError):
    """A folder or file that cannot be written."""


class FetchError(MgjaxError):
    """Something that does not come from the network, or not whole."""


class WorkerError(MgjaxError):
    """A worker process or machine that ended before its work was done."""
