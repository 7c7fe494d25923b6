"""``clips.toml``: how the files beside it are to be read, for all of them, a folder or a glob.

::

    units = "in"                # every file here and below
    ["dance/*"]                 # what a glob finds, by its path below this folder
    up = "z"
    roles = { left_knee = "Shin_L" }

Keys are those of :class:`mgjax.io.reading.read_as.ReadAs`. A later table counts more than an
earlier one, a deeper ``clips.toml`` more than one above it.
"""

from __future__ import annotations

from dataclasses import fields, replace
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from mgjax.core.errors import ConfigError
from mgjax.io.reading.read_as import ReadAs, validate_read_as
from mgjax.io.toml_file import read_toml
from mgjax.io.user_path import user_path

NAME = "clips.toml"
_KEYS = tuple(field.name for field in fields(ReadAs))


class ClipsToml:
    """All ``clips.toml`` files below a folder."""

    def __init__(self, folder: str | Path) -> None:
        """Reads them.

        Raises:
            FileFormatError: one is no TOML.
            ConfigError: an unknown key or a value that means nothing.
        """
        self.folder = Path(folder)
        self._rules: list[tuple[Path, str, dict[str, Any]]] = []
        for file in sorted(self.folder.rglob(NAME), key=lambda p: len(p.parts)):
            _, document = read_toml(file)
            tables = {k: v for k, v in document.items() if isinstance(v, dict) and k != "roles"}
            plain = {k: v for k, v in document.items() if k not in tables}
            for pattern, table in (("*", plain), *tables.items()):
                read_as_from(table, file)
                self._rules.append((file, pattern, table))

    def of(self, path: Path) -> ReadAs:
        """How a file below the folder is to be read."""
        said: dict[str, Any] = {}
        for file, pattern, table in self._rules:
            if file.parent in path.parents:
                name = path.relative_to(file.parent).as_posix()
                if pattern == "*" or fnmatch(name, pattern) or name.startswith(f"{pattern}/"):
                    said |= table
        return read_as_from(said, self.folder / NAME)


def read_as_from(table: dict[str, Any], file: Path) -> ReadAs:
    """A table of settings as :class:`ReadAs`; files in it are named relative to ``file``."""
    for key in table:
        if key not in _KEYS:
            raise ConfigError(f"{file}: got {key!r}, expected one of {', '.join(_KEYS)}")
    said = dict(table)
    for key in {"asf", "body_model"} & said.keys():
        said[key] = file.parent / user_path(str(said[key]))
    if "roles" in said:
        said["roles"] = _roles(said["roles"], file)
    for key, kinds in (("units", str), ("up", str), ("front", str), ("frame_rate", (int, float))):
        if key in said and not isinstance(said[key], kinds):
            raise ConfigError(f"{file}: got {key} = {said[key]!r}, expected another type")
    read_as = ReadAs(**said)
    try:
        validate_read_as(read_as)
    except ConfigError as error:
        raise ConfigError(str(error), place=str(file)) from None
    return read_as


def _roles(value: Any, file: Path) -> tuple[tuple[str, str], ...]:
    if isinstance(value, str):
        _, value = read_toml(file.parent / value)
    if not isinstance(value, dict) or not all(isinstance(name, str) for name in value.values()):
        raise ConfigError(f"{file}: got roles = {value!r}, expected a table of joint names")
    return tuple(value.items())


def over(base: ReadAs, said: ReadAs) -> ReadAs:
    """``said`` where it says something, else ``base``."""
    given = {f.name: getattr(said, f.name) for f in fields(ReadAs)}
    return replace(base, **{k: v for k, v in given.items() if v is not None and v != ()})
