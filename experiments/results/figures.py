"""Figures of records in the text of templates: found by path, formatted, and none without a record.

A template is Markdown. ``{record[metrics][key][0]:.1f}`` stands for a number of a record, which is
named by its script; formats are Python's, and ``1e3|.1f`` multiplies first. A line ``@each PATH``
repeats the next line for each entry of a list or table, as ``{row}``, with ``{key}`` beside it.
What stands between ``@if NAME`` and ``@end`` is left out where there is no such record.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping
from typing import Any

from mgjax.core.errors import ConfigError

EACH, IF, END = "@each ", "@if ", "@end"
PRINTED = re.compile(
    r"\{[^{}]*\}"  # of a record
    r"|`[^`]*`|\]\([^)]*\)|https?://\S+"  # code, links
    r"|\(paper:[^)]*\)|\(published:[^)]*\)"  # what others print
    r"|§+ ?[\d.]+|\beqs?\.? \d+(?:[–-]\d+)?|\bTables? \d+|\bFigs?\.? \d+|\b[A-Z]+\d+|\b\d-D\b"
)
"""Where digits of a template are no figures of ours."""
OTHERS = {"paper", "published"}
NUMBER = re.compile(r"\d+(?:[.,]\d+)*")


class Number(float):
    """A number whose format may begin with a factor: ``1e3|.1f``."""

    def __format__(self, spec: str) -> str:
        factor, bar, rest = spec.rpartition("|")
        value = float(self) * float(factor) if bar else float(self)
        if not rest:
            return f"{value:.10g}"
        return f"{round(value):d}" if rest == "d" else format(value, rest)


class Part:
    """A part of a record; what is not in it is an error that names the nearest key."""

    def __init__(self, value: Any, path: str) -> None:
        self.value = value
        self.path = path

    def __getitem__(self, key: int | str) -> Any:
        value: Any = self.value
        if isinstance(value, Mapping):
            key = str(key)
            known: list[str] = [str(name) for name in value]
            there = key in value
        elif isinstance(value, list):
            known = [str(number) for number in range(len(value))]
            there = isinstance(key, int) and key < len(value)
        else:
            known, there = [], False
        if not there:
            near = (difflib.get_close_matches(str(key), known, n=1, cutoff=0.0) or ["nothing"])[0]
            raise ConfigError(
                got=f"a figure {self.path}[{key}], which no record backs",
                expected=f"one that is recorded, such as {near} (known: {', '.join(known[:12])})",
            )
        item = value[key] if isinstance(value, Mapping) else value[int(key)]
        return shown(item, f"{self.path}[{key}]")

    def entries(self) -> Iterator[tuple[str, Any]]:
        """Keys, or numbers from 0, and what they lead to."""
        names = self.value if isinstance(self.value, Mapping) else range(len(self.value))
        for name in names:
            yield str(name), self[name]

    def __format__(self, spec: str) -> str:
        if not isinstance(self.value, list) or any(isinstance(x, list | dict) for x in self.value):
            raise ConfigError(got=f"{self.path}, a table", expected="a number, word or plain list")
        return ", ".join(format(shown(x, self.path), spec) for x in self.value)


def shown(value: Any, path: str) -> Any:
    """A value of a record as templates use it."""
    if isinstance(value, Mapping | list):
        return Part(value, path)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return Number(value)
    if value is None:
        raise ConfigError(got=f"{path}, of which nothing was measured", expected="a figure")
    return value


def filled(template: str, records: Mapping[str, Any], words: Mapping[str, str]) -> str:
    """The text of a template.

    Args:
        template: Markdown with figures in braces.
        records: by name.
        words: further texts by name.

    Raises:
        ConfigError: a figure that no record has, or a format that does not fit it.
    """
    known = {name: Part(record, name) for name, record in records.items()}
    lines = iter(_recorded(template.split("\n"), records))
    out = []
    for line in lines:
        if not line.startswith(EACH):
            out.append(_line(line, known | dict(words)))
            continue
        entries = _line_part(line.removeprefix(EACH).strip(), known)
        row = next(lines)
        out += [_line(row, known | {"key": key, "row": item}) for key, item in entries.entries()]
    return "\n".join(out)


def _recorded(lines: list[str], records: Mapping[str, Any]) -> list[str]:
    """Without what is of records that are not there."""
    kept, wanted = [], True
    for line in lines:
        if line.startswith(IF):
            wanted = line.removeprefix(IF).strip() in records
        elif line.strip() == END:
            wanted = True
        elif wanted:
            kept.append(line)
    return kept


def _line_part(path: str, known: Mapping[str, Any]) -> Part:
    name, *keys = path.replace("]", "").split("[")
    part = Part(known, "records")[name] if name not in known else known[name]
    for key in keys:
        part = part[int(key) if key.isdigit() else key]
    if not isinstance(part, Part):
        raise ConfigError(got=f"@each {path}", expected="the path of a list or table")
    return part


class _Known(dict[str, Any]):
    def __missing__(self, key: str) -> Any:
        near = difflib.get_close_matches(key, list(self), n=1, cutoff=0.0)
        raise ConfigError(
            got=f"a figure of {key}, of which there is no record",
            expected=f"one of a record, such as {(near or ['none'])[0]}",
        )


def _line(line: str, known: Mapping[str, Any]) -> str:
    try:
        return line.format_map(_Known(known))
    except (ValueError, AttributeError, IndexError) as error:
        raise ConfigError(got=f"{line.strip()!r} ({error})", expected="figures in braces") from None


def unbacked(template: str) -> list[str]:
    """Numbers in the text of a template itself, beside those that papers and others print.

    A column of a table whose head says ``paper`` or ``published`` has what others print.
    """
    found: list[str] = []
    others: set[int] = set()
    for line in template.split("\n"):
        if line.startswith((EACH, IF, END)):
            continue
        text = PRINTED.sub("", line)  # before cells are told apart: formats may have a bar
        cells = text.split("|") if line.startswith("|") else None
        if cells is None:
            others = set()
            found += NUMBER.findall(text)
            continue
        if not others and set(line) & set("abcdefghijklmnopqrstuvwxyz"):
            others = {i for i, cell in enumerate(cells) if OTHERS & {*re.findall(r"\w+", cell)}}
            others |= {-1}
        for number, cell in enumerate(cells):
            if number not in others:
                found += NUMBER.findall(cell)
    return found
