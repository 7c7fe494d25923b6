"""Pages of the reference: the public names of each room, with their docstrings."""

from __future__ import annotations

import importlib
import re

ROOMS = ("mgjax", "clips", "graph", "avoidance", "ballsport", "hybrid", "quality")

_ROLE = re.compile(r":(?:func|mod|class|meth|data|attr):<code>~?((?:[\w.]+\.)?)(\w+)</code>")


def page(room: str) -> str:
    """The page of a room: functions first, then classes, then constants."""
    package = room if room == "mgjax" else f"mgjax.{room}"
    module = importlib.import_module(package)
    names = [n for n in module.__all__ if n not in ROOMS and n not in ("core", "io", "__version__")]
    functions = [n for n in names if n.islower()]
    constants = [n for n in names if n.isupper()]
    classes = [n for n in names if n not in functions + constants]
    lines = [f"# {package}", "", (module.__doc__ or "").strip(), ""]
    for title, group in (("Functions", functions), ("Classes", classes), ("Constants", constants)):
        if group:
            lines += [f"## {title}", ""]
            lines += [f"::: {package}.{name}\n" for name in sorted(group, key=str.lower)]
    return "\n".join(lines)


def plain_roles(html: str) -> str:
    """Docstrings' roles (``:func:`~mgjax.clips.folder.load_clips```) as plain names in code."""
    return _ROLE.sub(r"<code>\2</code>", html)
