"""TOML files into the frozen dataclasses of the rooms, and back to TOML."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any, TypeVar

from mgjax.core.errors import ConfigError, FileFormatError, printable
from mgjax.io.settings import changed
from mgjax.io.text import read_text

T = TypeVar("T")


def load_config(path: str | Path, kind: type[T]) -> T:
    """Reads a TOML file into a config dataclass; nested dataclasses are tables.

    Raises:
        FileFormatError: no TOML.
        ConfigError: an unknown key (the nearest known one is named), or a value of another type.
    """
    config = kind()
    text, document = read_toml(path)
    for key, value in document.items():
        config = changed(config, key, value, lambda k: f"{printable(path)}:{_line_of(text, k)}")
    return config


def read_toml(path: str | Path) -> tuple[str, dict[str, Any]]:
    """The text of a TOML file and what it says; :class:`FileFormatError` if it is none."""
    text = read_text(path, "TOML")
    try:
        return text, tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FileFormatError(path, _line_in(str(error)), f"no TOML ({error})", "TOML") from None
    except RecursionError:
        raise FileFormatError(path, None, "TOML nested too deep", "TOML") from None


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


def to_toml(config: Any) -> str:
    """A config as TOML that :func:`load_config` reads back as it is.

    TOML has no form for None: such settings are left out, and None has to be their default.
    """
    return "\n".join(_table(config, "")).strip() + "\n"


def _table(config: Any, name: str) -> list[str]:
    lines: list[str] = []
    tables: list[str] = []
    default = type(config)()
    for item in dataclasses.fields(config):
        value = getattr(config, item.name)
        if dataclasses.is_dataclass(value):
            tables += _table(value, f"{name}.{item.name}".strip("."))
        elif value is not None:
            lines.append(f"{item.name} = {toml_value(value)}")
        elif getattr(default, item.name) is not None:
            raise ConfigError(f"got {name}.{item.name} = None, which TOML cannot say")
    return [*(["", f"[{name}]"] if name else []), *lines, *tables]


def toml_value(value: Any) -> str:
    """One setting as TOML has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value)) if math.isfinite(value) else str(float(value))
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    if isinstance(value, dict):
        pairs = (f"{toml_value(str(key))} = {toml_value(item)}" for key, item in value.items())
        return "{" + ", ".join(pairs) + "}"
    raise TypeError(f"got a setting of type {type(value).__name__}, expected one that TOML has")
