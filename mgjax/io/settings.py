"""Settings as frozen dataclasses: keys and values from files and command lines, checked.

Every setting that a user writes goes through :func:`changed`, whether it stands in a TOML file
(:mod:`mgjax.io.toml_file`) or on a command line (:mod:`mgjax.runs.settings`).
"""

from __future__ import annotations

import dataclasses
import difflib
import tomllib
import types
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from mgjax.core.errors import ConfigError
from mgjax.io.text import quoted

T = TypeVar("T")
Place = Callable[[str], str]
"""Where a key stands, for messages: a file and a line, or an argument."""


@dataclasses.dataclass(frozen=True)
class Words:
    """A value from the command line: TOML, or a word without quotes."""

    text: str

    def value(self, kind: Any) -> Any:
        """The value where a ``kind`` is wanted."""
        try:
            document = tomllib.loads(f"x = {self.text}")
        except (tomllib.TOMLDecodeError, RecursionError):
            return self.text
        value = document["x"] if list(document) == ["x"] else self.text
        # A word may look like a number: a folder that is called 2012.
        return self.text if kind is str and not isinstance(value, str) else value


def changed(config: T, key: str, value: Any, place: str | Place = "") -> T:
    """A config with one setting changed; a table changes all that it names.

    Args:
        config: frozen dataclass; nested dataclasses are tables.
        key: name of a field, dotted for one of a nested dataclass.
        value: as TOML has it; whole numbers become floats and lists tuples where those are wanted.
            :class:`Words` are read as TOML first.
        place: where it stands, for messages; or what says so for the last part of a key.

    Raises:
        ConfigError: an unknown key (the nearest known one is named), or a value of another type.
    """
    return _changed(config, key, key, value, place if callable(place) else lambda _: place)


def _changed(
    config: Any, key: str, whole: str, value: Any, place: Place, *, in_table: bool = False
) -> Any:
    """``key`` is what is left of the dotted key ``whole``, or stands in the table of the rest."""
    hints = get_type_hints(type(config))
    name, dot, rest = key.partition(".")
    before = whole[: len(whole) - len(key)]
    if name not in hints or name not in (field.name for field in dataclasses.fields(config)):
        raise _unknown(config, name, before, "" if in_table else before, place(name))
    kind, old = hints[name], getattr(config, name)
    if isinstance(value, Words) and not dot:
        value = value.value(kind)
    if not dataclasses.is_dataclass(old):
        if dot:
            raise ConfigError(
                got=f"key {quoted(whole)}", expected=f"no more than {name!r}", place=place(name)
            )
        new = _checked(value, kind, whole, place(name))
    elif dot:
        new = _changed(old, rest, whole, value, place)
    elif isinstance(value, dict):
        new = old
        for inner, item in value.items():
            new = _changed(new, inner, f"{whole}.{inner}", item, place, in_table=True)
    elif type(value) is type(old):
        new = value
    else:
        raise ConfigError(got=f"{whole} = {_shown(value)}", expected="a table", place=place(name))
    return dataclasses.replace(config, **{name: new})


def _unknown(config: Any, name: str, before: str, written: str, place: str) -> ConfigError:
    known = [field.name for field in dataclasses.fields(config)]
    near = (difflib.get_close_matches(name, known, n=1, cutoff=0.0) or [""])[0]
    return ConfigError(
        got=f"unknown key {quoted(before + name)}",
        expected=f"one such as {written + near!r} (known: {', '.join(known)})",
        place=place,
    )


class _MisfitError(Exception):
    """Says what was expected."""


def _checked(value: Any, kind: Any, key: str, place: str) -> Any:
    try:
        return _fit(value, kind)
    except _MisfitError as error:
        expected = str(error)
    raise ConfigError(got=f"{key} = {_shown(value)}", expected=expected, place=place)


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
            if get_origin(kind) is dict:
                expected.append("a table of numbers")
            elif kind is not types.NoneType:
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
