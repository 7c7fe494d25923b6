"""What an annotation admits: values as they are, or made into it where nothing is lost."""

from __future__ import annotations

import collections.abc
import operator
import types
import typing
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import jax
import numpy as np
from jax.core import Tracer

from mgjax.core.calls.arrays import array_admission
from mgjax.core.calls.dimensions import Sizes
from mgjax.core.calls.refused import Refused, one, shown
from mgjax.core.traced import TRACED

Admission = Callable[[Any, str, Sizes], Any]
"""Takes a value, the name of its argument and the sizes of arguments before it; gives the value
that the function gets, or raises :class:`Refused`."""


def admission_of(hint: Any) -> Admission:
    """What an annotation admits. One that says nothing (``Any``) admits everything."""
    origin, inside = typing.get_origin(hint), typing.get_args(hint)
    if hasattr(hint, "dim_str"):
        return array_admission(hint)
    if origin in (typing.Union, types.UnionType):
        return _union(inside)
    if origin is Literal:
        return _one_of(inside)
    if TRACED in getattr(hint, "__metadata__", ()):
        return _real
    if hint in _PLAIN:
        return _PLAIN[hint]
    if (origin is tuple and len(inside) != 2) or (origin is tuple and inside[1] is not Ellipsis):
        return _fixed(inside)
    if origin is not None and _is_a(origin, collections.abc.Iterable):
        return _several(origin, inside)
    if origin is collections.abc.Callable or hint is collections.abc.Callable:
        return _callable
    if isinstance(hint, type):
        return _instance(hint)
    return _anything


def _anything(value: Any, argument: str, sizes: Sizes) -> Any:
    return value


def _callable(value: Any, argument: str, sizes: Sizes) -> Any:
    if not callable(value):
        raise Refused(shown(value), "a function")
    return value


def _is_a(kind: Any, of: type) -> bool:
    return isinstance(kind, type) and issubclass(kind, of)


def _instance(kind: type) -> Admission:
    if not _checkable(kind):
        return _anything
    words, validate = one(kind.__name__), getattr(kind, "validate", None)

    def look(value: Any, argument: str, sizes: Sizes) -> Any:
        if not isinstance(value, kind):
            raise Refused(shown(value), words)
        if validate is not None:
            validate(value)
        return value

    return look


def _checkable(kind: type) -> bool:
    try:
        isinstance(None, kind)
    except TypeError:  # a protocol that only checkers of types know
        return False
    return True


def _whole(value: Any, argument: str, sizes: Sizes) -> Any:
    if isinstance(value, bool | np.bool_) or np.ndim(value) != 0:
        raise Refused(shown(value), "a whole number")
    try:
        return value if isinstance(value, Tracer) else operator.index(value)
    except TypeError:
        raise Refused(shown(value), "a whole number") from None


def _real(value: Any, argument: str, sizes: Sizes) -> Any:
    if isinstance(value, Tracer) and value.ndim == 0:
        return value
    number = isinstance(value, int | float | np.number | np.ndarray | jax.Array)
    if not number or isinstance(value, bool) or np.ndim(value) != 0:
        raise Refused(shown(value), "a number")
    if np.asarray(value).dtype.kind not in "fiu":
        raise Refused(shown(value), "a number")
    return value


def _flag(value: Any, argument: str, sizes: Sizes) -> Any:
    if not isinstance(value, bool | np.bool_):
        raise Refused(shown(value), "True or False")
    return bool(value)


def _text(value: Any, argument: str, sizes: Sizes) -> Any:
    if not isinstance(value, str):
        raise Refused(shown(value), "a text")
    return value


def _path(value: Any, argument: str, sizes: Sizes) -> Any:
    if not isinstance(value, Path):
        raise Refused(shown(value), "a path")
    return value


def _nothing(value: Any, argument: str, sizes: Sizes) -> Any:
    if value is not None:
        raise Refused(shown(value), "None")
    return value


_PLAIN: dict[Any, Admission] = {
    int: _whole,
    float: _real,
    bool: _flag,
    str: _text,
    Path: _path,
    type(None): _nothing,
    Any: _anything,
    object: _anything,
}


def _union(members: tuple[Any, ...]) -> Admission:
    looks = [admission_of(each) for each in members]

    def look(value: Any, argument: str, sizes: Sizes) -> Any:
        refusals: list[Refused] = []
        for admits in looks:
            tried = dict(sizes)
            try:
                admitted = admits(value, argument, tried)
            except Refused as refused:
                refusals.append(refused)
                continue
            sizes.update(tried)
            return admitted
        expected = dict.fromkeys(each.expected for each in refusals)
        raise Refused(refusals[0].got, " or ".join(expected))

    return look


def _one_of(values: tuple[Any, ...]) -> Admission:
    def look(value: Any, argument: str, sizes: Sizes) -> Any:
        if not any(type(value) is type(each) and value == each for each in values):
            raise Refused(shown(value), " or ".join(map(repr, values)))
        return value

    return look


def _several(origin: type, inside: tuple[Any, ...]) -> Admission:
    """Sequences, and whatever else is gone through."""
    if _is_a(origin, collections.abc.Mapping) or _is_a(origin, collections.abc.Iterator):
        return _instance(origin)
    each = admission_of(inside[0]) if inside else _anything
    plain = each is _anything
    words = one(origin.__name__.lower())
    if inside and not plain:
        words += f" of {_many(inside[0])}"
    counted = _is_a(origin, collections.abc.Sized) or _is_a(origin, collections.abc.Collection)

    def look(value: Any, argument: str, sizes: Sizes) -> Any:
        if isinstance(value, str | bytes) or not isinstance(value, collections.abc.Iterable):
            raise Refused(shown(value), words)
        if not counted or isinstance(value, np.ndarray | jax.Array):
            return value if origin is not tuple else tuple(value)
        if not isinstance(value, collections.abc.Collection):
            raise Refused(shown(value), words)
        if not plain:
            for number, item in enumerate(value):
                try:
                    each(item, argument, dict(sizes))
                except Refused as refused:
                    raise Refused(f"{refused.got} at {number}", refused.expected) from None
        return tuple(value) if origin is tuple else value

    return look


def _many(hint: Any) -> str:
    plain = {int: "whole numbers", float: "numbers", str: "texts"}
    kind = typing.get_origin(hint) or hint
    if kind in (typing.Union, types.UnionType):
        return " or ".join(_many(each) for each in typing.get_args(hint))
    if kind is tuple:
        return f"pairs ({', '.join(_name(each) for each in typing.get_args(hint))})"
    return plain.get(hint, f"{kind.__name__}s" if isinstance(kind, type) else "values")


def _name(hint: Any) -> str:
    return getattr(hint, "__name__", str(hint))


def _fixed(inside: tuple[Any, ...]) -> Admission:
    """Tuples of a known length."""
    looks = [admission_of(each) for each in inside]
    words = f"({', '.join(_name(each) for each in inside)})"

    def look(value: Any, argument: str, sizes: Sizes) -> Any:
        known = isinstance(value, tuple | list | np.ndarray) and len(value) == len(looks)
        if not known:
            raise Refused(shown(value), words)
        return tuple(
            admits(item, argument, sizes) for admits, item in zip(looks, value, strict=True)
        )

    return look
