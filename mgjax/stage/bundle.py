"""The modules of the page that one entry needs, made independent of where they lie."""

from __future__ import annotations

import posixpath
import re
from functools import lru_cache
from importlib.resources import files

_IMPORT = re.compile(
    r"""(?P<before>(?:^|\n|;)\s*(?:import|export)\b[^;'"`]*?)'(?P<name>\.[^']+)'"""
)
_COMMENT = re.compile(r"^[ \t]*(?://[^\n]*|/\*(?:[^*]|\*(?!/))*\*/)[ \t]*\n", re.MULTILINE)
_INDENT = re.compile(r"^[ \t]+|[ \t]+$|^\n", re.MULTILINE)


def page_text(name: str) -> str:
    """A file of the page, such as ``boot.js``."""
    place = files("mgjax.stage") / "page"
    for part in name.split("/"):
        place = place / part
    return place.read_text(encoding="utf-8")


@lru_cache(maxsize=4)
def bundle(entry: str) -> dict[str, str]:
    """An entry of the page and all it imports, by names such as ``stage/draw/gl.js``.

    Imports say these names, which an import map then leads to the text itself; comments that have
    lines of their own and indentation are left out.
    """
    found: dict[str, str] = {}
    waiting = [entry]
    while waiting:
        name = waiting.pop()
        if f"stage/{name}" in found:
            continue
        folder = posixpath.dirname(name)

        def named(match: re.Match[str], folder: str = folder) -> str:
            target = posixpath.normpath(posixpath.join(folder, match["name"]))
            waiting.append(target)
            return f"{match['before']}'stage/{target}'"

        found[f"stage/{name}"] = _IMPORT.sub(named, _short(page_text(name)))
    return found


def short_text(name: str) -> str:
    """A file of the page without comments that have lines of their own, and indentation."""
    return _short(page_text(name))


def _short(source: str) -> str:
    return _INDENT.sub("", _COMMENT.sub("", source))
