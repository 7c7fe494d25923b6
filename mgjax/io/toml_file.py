"""Settings from TOML files into the frozen dataclasses of the rooms."""

from __future__ import annotations

import dataclasses
import difflib
import re
import tomllib
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import cattrs

from mgjax.core.errors import ConfigError, FileFormatError, printable
from mgjax.io.text import quoted, read_text

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
    except RecursionError:
        raise FileFormatError(path, None, "TOML nested too deep", "TOML") from None
    _check_keys(path, text, document, kind, "")
    converter = cattrs.Converter(forbid_extra_keys=True)
    converter.register_structure_hook(float, lambda value, _: float(value))
    converter.register_structure_hook_func(_is_checked, lambda value, _: value)
    try:
        return converter.structure(document, kind)
    except (cattrs.BaseValidationError, ValueError, TypeError) as error:
        reason = "; ".join(cattrs.transform_error(error))
        raise ConfigError(
            f"{printable(path)}: got {reason}, expected the types of {kind.__name__}"
        ) from None


def _is_checked(kind: Any) -> bool:
    """Types that cattrs would convert or does not know; :func:`_check_keys` has looked at them."""
    return kind is Any or kind == str | dict[str, float]


def _expectation(value: Any, kind: Any) -> str | None:
    """What is expected where ``value`` is no ``kind``, else None."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if kind in (float, Any, float | None):
        return None if number else "a number"
    if kind is bool:
        return None if isinstance(value, bool) else "true or false"
    if kind is int:
        return None if number and isinstance(value, int) else "a whole number"
    if kind is str:
        return None if isinstance(value, str) else "a word"
    if get_origin(kind) is Literal:
        words = get_args(kind)
        return None if value in words else " or ".join(repr(word) for word in words)
    if kind == str | dict[str, float]:
        table = isinstance(value, dict) and all(
            _expectation(item, float) is None for item in value.values()
        )
        return None if table or isinstance(value, str) else "a word or a table of numbers"
    return None


def _check_keys(path: str | Path, text: str, table: dict, kind: type, prefix: str) -> None:
    hints = get_type_hints(kind)
    for key, value in table.items():
        place = f"{printable(path)}:{_line_of(text, key)}"
        if key not in hints:
            near = difflib.get_close_matches(key, hints, n=1, cutoff=0.0)
            raise ConfigError(
                f"{place}: got unknown key {prefix + key!r}, expected one such as"
                f" {near[0]!r} (known: {', '.join(hints)})"
            )
        nested = dataclasses.is_dataclass(hints[key])
        if nested and isinstance(value, dict):
            _check_keys(path, text, value, hints[key], f"{prefix}{key}.")  # pyright: ignore[reportArgumentType]
            continue
        expected = "a table" if nested else _expectation(value, hints[key])
        if expected is not None:
            shown = quoted(str(value)) if isinstance(value, str) else repr(value)[:40]
            raise ConfigError(f"{place}: got {prefix}{key} = {shown}, expected {expected}")


def _line_of(text: str, key: str) -> int:
    """The line in which a key, or its table, is set; the first one that mentions it otherwise."""
    lines = text.splitlines()
    word = re.escape(key)
    for pattern in (rf"\s*[\"']?{word}[\"']?\s*=", rf"\s*\[\[?.*\b{word}\b", rf".*{word}"):
        for number, line in enumerate(lines, 1):
            if re.match(pattern, line):
                return number
    return 1


def _line_in(message: str) -> int | None:
    """The line number in a message such as "… (at line 3, column 7)"."""
    words = message.replace(",", " ").split()
    if "line" in words[:-1] and words[words.index("line") + 1].isdigit():
        return int(words[words.index("line") + 1])
    return None
