"""Docstrings as griffe wants them: an entry for two parameters becomes one for each."""

from __future__ import annotations

import re
from typing import Any

from griffe import Extension

_GROUP = re.compile(r"^(?P<indent> +)(?P<names>\*{0,2}\w+(?:, \*{0,2}\w+)+): (?P<text>.*)$")


def one_by_one(docstring: str) -> str:
    """``a, b: what`` of a section becomes ``a: what`` and ``b: what``, with all lines of it."""
    lines = docstring.split("\n")
    made: list[str] = []
    while lines:
        line = lines.pop(0)
        match = _GROUP.match(line)
        if match is None:
            made.append(line)
            continue
        deeper = match["indent"] + " "
        rest: list[str] = []
        while lines and lines[0].startswith(deeper):
            rest.append(lines.pop(0))
        for name in match["names"].split(", "):
            made += [f"{match['indent']}{name}: {match['text']}", *rest]
    return "\n".join(made)


class OneByOne(Extension):
    """Applies :func:`one_by_one` to every docstring."""

    def on_instance(self, *, obj: Any, **_: Any) -> None:
        """Called for every object that was read."""
        if obj.docstring is not None:
            obj.docstring.value = one_by_one(obj.docstring.value)
