"""Points of a sketch from a CSV file, as spreadsheets and other tools write them.

Values are separated by commas, semicolons, tabs or blanks, and may stand in quotes; ``#`` begins a
comment. Between semicolons numbers may have decimal commas, as spreadsheets write them in many
countries. What could be read in two ways is refused.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mgjax.core.errors import FileFormatError
from mgjax.io.text import parse_number, quoted, split_lines

_COLUMNS = (["x", "z"], ["x", "z", "speed"])
_QUOTES = "\"'"


def read_csv(path: str | Path, text: str) -> dict[str, Any]:
    """``points`` and ``speed`` of :func:`mgjax.hybrid.paths.sketch.make_sketch`.

    Args:
        path: of the file, for messages.
        text: what is in it.

    Raises:
        FileFormatError: with the line.
    """
    points: list[list[float]] = []
    speeds: list[float] = []
    marks: set[str] = set()
    columns = 0
    for number, line in enumerate(split_lines(text), 1):
        words = _values(path, number, line.split("#")[0].strip(), marks)
        if not words:
            continue
        if not points and not columns and [w.lower() for w in words[:2]] == ["x", "z"]:
            if [w.lower() for w in words] not in _COLUMNS:
                raise FileFormatError(path, number, quoted(line), "the columns x,z or x,z,speed")
            columns = len(words)
            continue
        columns = columns or len(words)
        if len(words) != columns or columns not in (2, 3):
            expected = f"{columns} numbers" if columns in (2, 3) else "x,z or x,z,speed"
            raise FileFormatError(path, number, f"{len(words)} values", expected)
        values = [parse_number(path, number, w, "x, z or speed") for w in words]
        points.append(values[:2])
        speeds += values[2:]
    if not points:
        raise FileFormatError(path, None, "no points", "lines of x,z in metres")
    return {"points": points, "speed": speeds or None}


def _values(path: str | Path, number: int, line: str, marks: set[str]) -> list[str]:
    """The values of a line, numbers with a decimal point.

    Args:
        path: of the file, for messages.
        number: of the line.
        line: without its comment.
        marks: decimal marks that the file has used, which may be of one kind only.
    """
    if not line:
        return []
    if ";" in line:
        words = [_unquoted(word) for word in line.split(";")]
        return [_with_point(path, number, word, marks) for word in words]
    if "," not in line:
        return [_unquoted(word) for word in line.split()]
    words = _between_commas(line)
    if any(re.search(r"\s|,", word) for word in words):
        raise FileFormatError(
            path, number, quoted(line), "x,z (commas between numbers), or x;z with decimal commas"
        )
    return words


def _between_commas(line: str) -> list[str]:
    """Values between the commas that are not in quotes."""
    parts = re.findall(r"""(?:"[^"]*"|'[^']*'|[^,])+|(?<=,)(?=,|$)|^(?=,)""", line)
    return [_unquoted(part) for part in parts]


def _unquoted(word: str) -> str:
    """A value without blanks and quotes around it."""
    word = word.strip()
    if len(word) > 1 and word[0] in _QUOTES and word[-1] == word[0]:
        word = word[1:-1].strip()
    return word


def _with_point(path: str | Path, number: int, word: str, marks: set[str]) -> str:
    """A value between semicolons, which may have a decimal comma, with a point."""
    here = {mark for mark in ".," if mark in word}
    marks |= here
    if len(here) > 1 or word.count(",") > 1:
        raise FileFormatError(path, number, quoted(word), "a number with one decimal mark")
    if len(marks) > 1:
        raise FileFormatError(
            path, number, quoted(word), "the decimal mark of the lines before, point or comma"
        )
    return word.replace(",", ".")
