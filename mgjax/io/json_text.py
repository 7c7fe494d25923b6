"""Reading JSON that people write: one place for what is refused, and for pointing at the line."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

from mgjax.core.errors import FileFormatError

Place: TypeAlias = tuple[str | int, ...]
"""Where a value stands in a document: keys and indices, from the outermost."""


def parse_json(
    path: str | Path,
    text: str,
    *,
    expected: str,
    nested: str = "a JSON object",
    error: type[FileFormatError] = FileFormatError,
    twice: Callable[[str], FileFormatError] | None = None,
    finite: bool = True,
) -> Any:
    """The value that a JSON text holds; every number is a float.

    As floats, numbers of any length can be read; one with too many digits is infinite.

    Args:
        path: of the file, for messages.
        text: what stands in it.
        expected: what an error says that the file should hold.
        nested: likewise, where it is nested too deep to be read.
        error: what is raised.
        twice: gives the error for a key that stands twice in an object; default: the last counts.
        finite: refuses ``NaN`` and ``Infinity``.

    Raises:
        FileFormatError: or the given kind of it: no JSON, nested too deep, a key that stands twice,
            a number that is not finite.
    """

    def refuse(word: str) -> NoReturn:
        raise error(path, None, word, "finite numbers")

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        for key, count in Counter(key for key, _ in pairs).items():
            if twice is not None and count > 1:
                raise twice(key)
        return dict(pairs)

    try:
        return json.loads(
            text,
            parse_int=float,
            parse_constant=refuse if finite else None,
            object_pairs_hook=unique,
        )
    except json.JSONDecodeError as reason:
        raise error(path, reason.lineno, f"no JSON ({reason.msg})", expected) from None
    except RecursionError:
        raise error(path, None, "JSON nested too deep", nested) from None


def shown(value: Any) -> str:
    """A value for a message: short, on one line."""
    if isinstance(value, list):
        return f"a list of {len(value)}" if value else "an empty list"
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, str):
        return ascii(value if len(value) <= 40 else value[:37] + "...")
    return f"{value:g}" if type(value) is float else json.dumps(value)


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[\[\]{},:]|[^\s\[\]{},:"]+|\n')


def lines_of_values(text: str) -> dict[Place, int]:
    """Line at which each value, or its key, begins in a text that is known to be JSON."""
    lines: dict[Place, int] = {}
    line = 1
    place: list[str | int] = []  # of the value that comes next
    in_object: list[bool] = []
    key_next = False
    for match in _TOKEN.finditer(text):
        token = match.group()
        if token == "\n":
            line += 1
        elif token in "]}":
            place.pop()
            in_object.pop()
            key_next = False
        elif token == ",":
            if in_object[-1]:
                key_next = True
            else:
                place[-1] = int(place[-1]) + 1
        elif token == ":":
            key_next = False
        elif key_next:
            place[-1] = json.loads(token)
            lines[tuple(place)] = line
        else:
            lines.setdefault(tuple(place), line)
            if token in "[{":
                place.append(0)
                in_object.append(token == "{")
                key_next = token == "{"
    return lines


def line_of(text: str, where: Place) -> int | None:
    """Line of a value, or of what holds it, in a text that is known to be JSON."""
    lines = lines_of_values(text)
    return next((lines[where[:n]] for n in range(len(where), -1, -1) if where[:n] in lines), None)
