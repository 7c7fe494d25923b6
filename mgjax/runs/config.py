"""Settings from TOML files into the frozen dataclasses of the rooms."""

from __future__ import annotations

import dataclasses
import difflib
import tomllib
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import cattrs

from mgjax.core.errors import ConfigError, FileFormatError
from mgjax.io.text import read_text

T = TypeVar("T")


def load_config(path: str | Path, kind: type[T]) -> T:
    """Reads a TOML file into a config dataclass; nested dataclasses are tables.

    Raises:
        FileFormatError: no TOML.
        ConfigError: an unknown key (the nearest known one is named), or a value of another type.
    """
    text = read_text(path, "TOML")
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FileFormatError(path, _line_in(str(error)), f"no TOML ({error})", "TOML") from None
    _check_keys(path, text, document, kind, "")
    converter = cattrs.Converter(forbid_extra_keys=True)
    converter.register_structure_hook(float, _number)
    converter.register_structure_hook(bool, _truth)
    converter.register_structure_hook_func(_is_mixed, lambda value, _: value)
    try:
        return converter.structure(document, kind)
    except (cattrs.BaseValidationError, ValueError, TypeError) as error:
        reason = "; ".join(cattrs.transform_error(error)) if isinstance(error, Exception) else ""
        raise ConfigError(f"{path}: got {reason}, expected the types of {kind.__name__}") from None


def _number(value: Any, _: type) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{value!r} where a number is meant")
    return float(value)


def _truth(value: Any, _: type) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{value!r} where true or false is meant")
    return value


def _is_mixed(kind: Any) -> bool:
    """Types that are checked where they are used: a number that may be traced, str | dict."""
    return kind is Any or kind == str | dict[str, float]


def _check_keys(path: str | Path, text: str, table: dict, kind: type, prefix: str) -> None:
    hints = get_type_hints(kind)
    for key, value in table.items():
        if key not in hints:
            near = difflib.get_close_matches(key, hints, n=1, cutoff=0.0)
            raise ConfigError(
                f"{path}:{_line_of(text, key)}: got unknown key {prefix + key!r}, expected one such"
                f" as {near[0]!r} (known: {', '.join(hints)})"
            )
        if dataclasses.is_dataclass(hints[key]):
            if not isinstance(value, dict):
                raise ConfigError(
                    f"{path}:{_line_of(text, key)}: got {key} = {value!r}, expected a table"
                )
            _check_keys(path, text, value, hints[key], f"{prefix}{key}.")  # pyright: ignore[reportArgumentType]


def _line_of(text: str, key: str) -> int:
    lines = text.splitlines()
    return next((no for no, line in enumerate(lines, 1) if key in line), 1)


def _line_in(message: str) -> int | None:
    """The line number in a message such as "… (at line 3, column 7)"."""
    words = message.replace(",", " ").split()
    if "line" in words[:-1] and words[words.index("line") + 1].isdigit():
        return int(words[words.index("line") + 1])
    return None
