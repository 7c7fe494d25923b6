"""Records of runs as files: written, found, read, and compared with one another."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mgjax.core.errors import FileFormatError, MgjaxError, printable
from mgjax.io.output import replace_file
from mgjax.io.text import read_text
from mgjax.runs.record import flat

METRICS = "metrics.json"
LEFT_OUT = ("files", "points")
"""What a folder of results has beside the record."""
MOST = 40
"""Longer lists of figures are left to the folder of results."""
DIGITS = 9
"""Significant ones of figures, as many as tell apart all of single precision."""
PLAIN_LIST = re.compile(r"\[\n\s*([^\[\]{}]*?)\n\s*\]")
"""A list of no lists and tables, an entry a line; texts of JSON have no line breaks themselves."""
SETTLED = ("experiment", "config", "inputs", "sources", "versions", "git_revision", "machine")
"""What says how a run was made, beside ``metrics`` and ``timings``, which say what it found."""


def keep_record(path: str | Path, record: Mapping[str, Any]) -> None:
    """Writes a record as a file of its own, without what only its folder has, and long lists.

    Plain lists stand on one line, so that a change of one figure is a change of one line.
    """
    kept = {key: value for key, value in record.items() if key not in LEFT_OUT}
    for part in ("metrics", "timings"):
        kept[part] = _short(kept[part])
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(kept, indent=1, allow_nan=False)
    replace_file(path, PLAIN_LIST.sub(_on_a_line, text) + "\n")


def _on_a_line(found: re.Match[str]) -> str:
    return "[" + ", ".join(line.strip() for line in found[1].split(",\n")) + "]"


def _short(value: Any) -> Any:
    if isinstance(value, Mapping):
        long = [key for key, item in value.items() if isinstance(item, list) and len(item) > MOST]
        return {key: _short(item) for key, item in value.items() if key not in long}
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    return [_short(item) for item in value] if isinstance(value, list) else value


def kept_record(path: str | Path) -> dict[str, Any] | None:
    """The record in a file; None where there is no file, or one that is no record."""
    try:
        return load_record(path)
    except MgjaxError:
        return None


def load_record(path: str | Path) -> dict[str, Any]:
    """The record in a file, or in a folder of results.

    Raises:
        FileFormatError: no such file, or none of a run.
    """
    path = Path(path)
    file = path / METRICS if path.is_dir() else path
    text = read_text(file, "record")
    try:
        record = json.loads(text)
    except ValueError as error:
        raise FileFormatError(file, None, f"no JSON ({error})", "the record of a run") from None
    if not isinstance(record, dict) or not {"experiment", "metrics", "fingerprint"} <= set(record):
        raise FileFormatError(file, None, "other JSON", "the record of a run")
    return record


def find_records(folders: Sequence[str | Path]) -> Iterator[tuple[Path, dict[str, Any]]]:
    """All records below folders: files of their own and folders of results, in order of names."""
    for folder in folders:
        for file in sorted(Path(folder).rglob("*.json")):
            record = kept_record(file)
            if record is not None:
                yield (file.parent if file.name == METRICS else file), record


def differences(a: Mapping[str, Any], b: Mapping[str, Any]) -> dict[str, dict[str, tuple]]:
    """What two records say differently, by part of the record and dotted key; None: one lacks it.

    Args:
        a, b: records; lists count as tables with numbers for keys.
    """
    found: dict[str, dict[str, tuple]] = {}
    for part in (*SETTLED, "metrics", "timings"):
        one, other = (leaves(record, part) for record in (a, b))
        keys = [*one, *(key for key in other if key not in one)]
        differing = {
            key: (one.get(key), other.get(key)) for key in keys if one.get(key) != other.get(key)
        }
        if differing:
            found[part] = differing
    return found


def ratio(pair: tuple) -> float | None:
    """The second of two numbers over the first; None where that says nothing."""
    one, other = pair
    if any(isinstance(x, bool) or not isinstance(x, int | float) for x in pair) or not one:
        return None
    quotient = other / one
    return quotient if math.isfinite(quotient) and quotient > 0 else None


def leaves(record: Mapping[str, Any], part: str) -> dict[str, Any]:
    """All values of a part of a record by dotted key; lists count as tables."""
    value = record.get(part)
    return {} if value is None else flat(_tables({part: value}))


def _tables(value: Any) -> Any:
    """Lists as tables."""
    if isinstance(value, Mapping):
        return {key: _tables(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return {str(number): _tables(item) for number, item in enumerate(value)}
    return value


def named(name: str, folders: Sequence[str | Path]) -> dict[str, Any]:
    """The record at a path, or the only one below the folders whose experiment is so called.

    Raises:
        FileFormatError: there is none, or more than one.
    """
    if Path(name).exists():
        return load_record(name)
    found = [
        (path, record)
        for path, record in find_records(folders)
        if name in (record["experiment"], record["experiment"].partition("/")[2], path.stem)
    ]
    if len(found) == 1:
        return found[0][1]
    places = ", ".join(printable(path) for path, _ in found) or "none"
    looked = ", ".join(printable(folder) for folder in folders)
    raise FileFormatError(
        name, None, f"{len(found)} records of that name below {looked} ({places})",
        "the path of a record, or a name that one of them has",
    )  # fmt: skip
