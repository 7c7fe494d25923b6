"""What a run depends on, as short hashes: its settings, its files, the text of its programs."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

import mgjax
from mgjax.io.content_key import content_key

INPUTS = ("clips", "graph")
"""Settings that name files or folders which are read."""
MADE = {"build.json"}
"""Reports beside a graph, which have times in them."""


def settings_of(config: Any) -> dict[str, Any]:
    """The settings as plain values; of paths only the last part, which says nothing of a machine.

    Args:
        config: dataclass; its settings named in ``INPUTS`` are paths or tuples of them.
    """
    return asdict(config) | {name: _last(value) for name, value in _named(config).items()}


def inputs_of(config: Any) -> dict[str, str]:
    """By setting, the hash of all files that it names; of those that name any."""
    return {
        name: content_key([_files_key(Path(path)) for path in _paths(value)])
        for name, value in _named(config).items()
        if _paths(value)
    }


def sources_of(run: Callable[..., Any]) -> str:
    """The hash of the programs: all of mgjax, and a script with what it imports around it.

    Args:
        run: a function of the script; around it lie the folder that holds the script's folder, and
            all below.
    """
    script = Path(inspect.getfile(run)).resolve()
    around = script.parent.parent
    texts: dict[str, bytes] = {}
    waiting = [script]
    while waiting:
        file = waiting.pop()
        name = str(file.relative_to(around))
        if name not in texts:
            texts[name] = file.read_bytes()
            waiting += [f for f in _imported(texts[name], around.parent) if _within(f, around)]
    return content_key(_package_key(Path(mgjax.__file__).parent), texts)


def _imported(text: bytes, root: Path) -> set[Path]:
    """Files below a folder that are imported by their whole names."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {each.name for each in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names |= {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
    places = [root / name.replace(".", "/") for name in names]
    files = [f for p in places for f in (p.with_suffix(".py"), p / "__init__.py")]
    return {file.resolve() for file in files if file.is_file()}


def _within(file: Path, around: Path) -> bool:
    """Around a script, and not of mgjax, which is hashed whole."""
    return file.is_relative_to(around) and not file.is_relative_to(Path(mgjax.__file__).parent)


def fingerprint(label: str, settings: Any, known: Any) -> str:
    """The hash of all that a run's figures depend on, but for the machine."""
    return content_key(label, settings, known)


@lru_cache(maxsize=1)
def _package_key(package: Path) -> str:
    files = sorted(package.rglob("*.py"))
    return content_key({str(file.relative_to(package)): file.read_bytes() for file in files})


def _named(config: Any) -> dict[str, Any]:
    values = {name: getattr(config, name, None) for name in INPUTS}
    return {name: value for name, value in values.items() if isinstance(value, str | tuple)}


def _paths(value: str | tuple[str, ...]) -> list[str]:
    return [path for path in ((value,) if isinstance(value, str) else value) if path]


def _last(value: str | tuple[str, ...]) -> Any:
    if isinstance(value, str):
        return Path(value).name
    return [Path(path).name for path in value]


def _files_key(path: Path) -> str | None:
    """None where nothing is: whoever reads it says so."""
    if path.is_file():
        return content_key(path.read_bytes())
    if not path.is_dir():
        return None
    files = sorted(file for file in path.rglob("*") if file.is_file() and file.name not in MADE)
    return content_key(
        [(str(file.relative_to(path)), content_key(file.read_bytes())) for file in files]
    )
