"""Work counted instead of seconds, so that tests of it pass on machines of any speed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import mgjax

PACKAGE = str(Path(mgjax.__file__).parent)
SCANNING = {
    *("count", "find", "index", "partition", "split", "splitlines", "startswith", "endswith"),
    *("strip", "lstrip", "rstrip", "replace", "translate", "lower", "upper", "join"),
    *("encode", "decode", "isascii", "isdigit"),
}
"""Methods of a text that may go through all of it."""


@dataclass(kw_only=True)
class Work:
    """What was done.

    Attributes:
        lines: of the library that ran; each round of a comprehension counts as well.
        characters: of the texts that its string methods were called on.
    """

    lines: int = 0
    characters: int = 0


@contextmanager
def counted() -> Iterator[Work]:
    """Counts the work of what runs inside."""
    work = Work()

    def line(frame: FrameType, event: str, argument: Any) -> Any:
        work.lines += event == "line"
        return line

    def called(frame: FrameType, event: str, argument: Any) -> Any:
        return line if frame.f_code.co_filename.startswith(PACKAGE) else None

    def method(frame: FrameType, event: str, argument: Any) -> None:
        if event == "c_call" and argument.__name__ in SCANNING:
            text = argument.__self__
            if isinstance(text, str | bytes) and frame.f_code.co_filename.startswith(PACKAGE):
                work.characters += len(text)

    before = sys.gettrace(), sys.getprofile()
    sys.settrace(called)
    sys.setprofile(method)
    try:
        yield work
    finally:
        sys.settrace(before[0])
        sys.setprofile(before[1])
