"""Settings of an experiment: a TOML file, the tiny version, single settings; and their help."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

from mgjax.core.errors import ConfigError
from mgjax.io.settings import Words, changed
from mgjax.io.text import quoted
from mgjax.io.toml_file import load_config, toml_value

T = TypeVar("T")


def resolve(
    kind: type[T], file: Path | None = None, *, smoke: bool = False, settings: Sequence[str] = ()
) -> T:
    """The settings of a run: defaults, then the file, then the tiny version, then single settings.

    Args:
        kind: frozen dataclass whose fields all have defaults; nested dataclasses are tables. Its
            class method ``smoke()`` returns the settings of the tiny version, by dotted key.
        file: TOML.
        smoke: asks for the tiny version.
        settings: ``"key=value"``, dotted keys for nested dataclasses. The value is TOML; a word
            needs no quotes.

    Raises:
        ConfigError: an unknown key (the nearest known one is named), or a value of another type.
        FileFormatError: no TOML.
    """
    config = kind() if file is None else load_config(file, kind)
    if smoke:
        tiny = getattr(kind, "smoke", None)
        if tiny is None:
            raise ConfigError(got="--smoke", expected="an experiment that has a tiny version")
        for key, value in tiny().items():
            config = changed(config, key, value, "smoke")
    for text in settings:
        key, equals, value = text.partition("=")
        if not equals:
            raise ConfigError(got=quoted(text), expected="key=value", place="--set")
        config = changed(config, key.strip(), Words(value.strip()), "--set")
    return config


def describe(kind: type) -> str:
    """The settings with their defaults and docstrings, for a help text."""
    config, lines = kind(), []
    documents = _documents(kind)
    for item in dataclasses.fields(config):  # pyright: ignore[reportArgumentType]
        value = getattr(config, item.name)
        if dataclasses.is_dataclass(value):
            shown = f"{item.name}.…"
        else:
            shown = item.name if value is None else f"{item.name} = {toml_value(value)}"
        text = f"{shown}: {' '.join(documents.get(item.name, '').split())}".rstrip(": ")
        lines += textwrap.wrap(text, 96, initial_indent="  ", subsequent_indent="      ")
    return "\n".join(lines)


def _documents(kind: type) -> dict[str, str]:
    """The strings that stand below the fields in the source."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(kind)))
    except (OSError, TypeError, SyntaxError):
        return {}
    body = tree.body[0].body if isinstance(tree.body[0], ast.ClassDef) else []
    documents: dict[str, str] = {}
    for field, below in zip(body, body[1:], strict=False):
        named = isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        text = below.value if isinstance(below, ast.Expr) else None
        if named and isinstance(text, ast.Constant) and isinstance(text.value, str):
            documents[field.target.id] = text.value  # pyright: ignore
    return documents
