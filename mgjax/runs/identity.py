"""What a run depends on, as short hashes: its settings, its files, the text of its programs."""

from __future__ import annotations

import inspect
import sys
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
    """The hash of the programs: all of mgjax, and what is loaded of the folder around a script.

    Args:
        run: a function of the script, which lies two folders below that of its package.
    """
    package = Path(mgjax.__file__).parent
    around = Path(inspect.getfile(run)).resolve().parent.parent
    loaded = {
        Path(file).resolve()
        for file in (getattr(module, "__file__", None) for module in list(sys.modules.values()))
        if file
    }
    loaded.add(Path(inspect.getfile(run)).resolve())
    beside = {file for file in loaded if file.is_relative_to(around) and file.suffix == ".py"}
    beside = {file for file in beside if not file.is_relative_to(package)}
    texts = {str(file.relative_to(around)): file.read_bytes() for file in beside}
    return content_key(_package_key(package), texts)


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
