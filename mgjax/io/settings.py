"""Settings of an experiment: a TOML file, the tiny version, single settings; and back to TOML."""

from __future__ import annotations

import ast
import dataclasses
import difflib
import inspect
import json
import math
import textwrap
import tomllib
import types
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from mgjax.core.errors import ConfigError, printable
from mgjax.io.text import quoted, read_text
from mgjax.io.toml_file import load_config

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
    config = kind()
    if file is not None:
        config = load_config(file, kind)
        for key, value in tomllib.loads(read_text(file, "TOML")).items():
            config = changed(config, key, value, f"{printable(file)}: ")
    if smoke:
        tiny = getattr(kind, "smoke", None)
        if tiny is None:
            raise ConfigError("got --smoke, expected an experiment that has a tiny version")
        for key, value in tiny().items():
            config = changed(config, key, value, "smoke: ")
    for text in settings:
        key, equals, value = text.partition("=")
        if not equals:
            raise ConfigError(f"--set: got {quoted(text)}, expected key=value")
        config = changed(config, key.strip(), _Words(value.strip()), "--set: ")
    return config


@dataclasses.dataclass(frozen=True)
class _Words:
    """A value from the command line: TOML, or a word without quotes."""

    text: str

    def value(self, kind: Any) -> Any:
        try:
            document = tomllib.loads(f"x = {self.text}")
        except (tomllib.TOMLDecodeError, RecursionError):
            return self.text
        value = document["x"] if list(document) == ["x"] else self.text
        # A word may look like a number: a folder that is called 2012.
        return self.text if kind is str and not isinstance(value, str) else value


class _MisfitError(Exception):
    """Says what was expected."""


def changed(config: T, key: str, value: Any, place: str = "") -> T:
    """The config with one setting changed; a table changes all that it names.

    Raises:
        ConfigError: see :func:`resolve`; the message begins with ``place``.
    """
    return _changed(config, key, key, value, place)


def _changed(config: Any, key: str, whole: str, value: Any, place: str) -> Any:
    hints = get_type_hints(type(config))
    known = [item.name for item in dataclasses.fields(config)]
    name, dot, rest = key.partition(".")
    before = whole[: len(whole) - len(key)]
    if name not in known:
        near = (difflib.get_close_matches(name, known, n=1, cutoff=0.0) or [""])[0]
        raise ConfigError(
            f"{place}got unknown key {quoted(before + name)}, expected one such as"
            f" {before + near!r} (known: {', '.join(known)})"
        )
    kind, old = hints[name], getattr(config, name)
    if isinstance(value, _Words) and not dot:
        value = value.value(kind)
    if not dataclasses.is_dataclass(old):
        if dot:
            raise ConfigError(f"{place}got key {quoted(whole)}, expected no more than {name!r}")
        new = _checked(value, kind, whole, place)
    elif dot:
        new = _changed(old, rest, whole, value, place)
    elif isinstance(value, dict):
        new = old
        for inner, item in value.items():
            new = _changed(new, inner, f"{whole}.{inner}", item, place)
    elif type(value) is type(old):
        new = value
    else:
        raise ConfigError(f"{place}got {whole} = {_shown(value)}, expected a table")
    return dataclasses.replace(config, **{name: new})


def _checked(value: Any, kind: Any, key: str, place: str) -> Any:
    try:
        return _fit(value, kind)
    except _MisfitError as error:
        shown = _shown(value)
        raise ConfigError(f"{place}got {key} = {shown}, expected {error}") from None


def _shown(value: Any) -> str:
    return quoted(value) if isinstance(value, str) else quoted(repr(value))[1:-1]


_PLAIN = {
    bool: (bool, "true or false"),
    int: (int, "a whole number"),
    float: (int | float, "a number"),
    Any: (int | float, "a number"),  # a setting that is traced
    str: (str, "a word"),
    types.NoneType: (types.NoneType, "nothing"),
}


def _fit(value: Any, kind: Any) -> Any:
    """The value as ``kind`` wants it: whole numbers become floats, lists tuples."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind in _PLAIN:
        accepted, expected = _PLAIN[kind]
        if not isinstance(value, accepted) or (isinstance(value, bool) and kind is not bool):
            raise _MisfitError(expected)
        return float(value) if kind is float else value
    if origin is Literal:
        if not any(value == word and type(value) is type(word) for word in arguments):
            raise _MisfitError(" or ".join(repr(word) for word in arguments))
        return value
    if origin in (Union, types.UnionType):
        return _fit_any(value, arguments)
    if origin in (tuple, list):
        return _fit_list(value, origin, arguments)
    if origin is dict:
        if not isinstance(value, dict):
            raise _MisfitError("a table")
        return {key: _fit(item, arguments[1]) for key, item in value.items()}
    raise TypeError(f"got a setting of type {kind}, expected one that TOML has")


def _fit_any(value: Any, kinds: Sequence[Any]) -> Any:
    expected: list[str] = []
    for kind in kinds:
        try:
            return _fit(value, kind)
        except _MisfitError as error:
            if kind is not types.NoneType:
                expected.append(str(error))
    raise _MisfitError(" or ".join(expected))


def _fit_list(value: Any, origin: type, kinds: Sequence[Any]) -> Any:
    if not isinstance(value, list | tuple):
        raise _MisfitError("a list in brackets")
    if origin is tuple and kinds[-1] is not Ellipsis:
        if len(value) != len(kinds):
            raise _MisfitError(f"a list of {len(kinds)}")
    else:
        kinds = [kinds[0]] * len(value)
    try:
        return origin(_fit(item, kind) for item, kind in zip(value, kinds, strict=True))
    except _MisfitError as error:
        raise _MisfitError(f"a list, each of it {error}") from None


def to_toml(config: Any) -> str:
    """The settings as TOML that :func:`resolve` reads back as they are.

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
            lines.append(f"{item.name} = {_toml(value)}")
        elif getattr(default, item.name) is not None:
            raise ConfigError(f"got {name}.{item.name} = None, which TOML cannot say")
    return [*(["", f"[{name}]"] if name else []), *lines, *tables]


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value)) if math.isfinite(value) else str(float(value))
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    if isinstance(value, dict):
        pairs = (f"{_toml(str(key))} = {_toml(item)}" for key, item in value.items())
        return "{" + ", ".join(pairs) + "}"
    raise TypeError(f"got a setting of type {type(value).__name__}, expected one that TOML has")


def describe(kind: type) -> str:
    """The settings with their defaults and docstrings, for a help text."""
    config, lines = kind(), []
    documents = _documents(kind)
    for item in dataclasses.fields(config):  # pyright: ignore[reportArgumentType]
        value = getattr(config, item.name)
        if dataclasses.is_dataclass(value):
            shown = f"{item.name}.…"
        else:
            shown = item.name if value is None else f"{item.name} = {_toml(value)}"
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
    found: dict[str, str] = {}
    for field, below in zip(body, body[1:], strict=False):
        named = isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        text = below.value if isinstance(below, ast.Expr) else None
        if named and isinstance(text, ast.Constant) and isinstance(text.value, str):
            found[field.target.id] = text.value  # pyright: ignore
    return found
