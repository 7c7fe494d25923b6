"""What an annotation admits: values as they are, or made into it where nothing is lost."""

from __future__ import annotations

import collections.abc
import math
import operator
import types
import typing
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import jax
import numpy as np
from jax.core import Tracer

from mgjax.core.dimensions import Sizes, fitting, shown_shape
from mgjax.core.traced import TRACED

Admission = Callable[[Any, str, Sizes], Any]
"""Takes a value, the name of its argument and the sizes of arguments before it; gives the value
that the function gets, or raises :class:`Refused`."""
_KIND = {"b": "b", "i": "i", "u": "i"}
KINDS = {"f": "numbers", "i": "whole numbers", "b": "booleans"}


class Refused(Exception):
    """What was got and what is expected."""

    def __init__(self, got: str, expected: str) -> None:
        self.got, self.expected = got, expected
        super().__init__(f"got {got}, expected {expected}")


def admission_of(hint: Any) -> Admission:
    """What an annotation admits. One that says nothing (``Any``) admits everything."""
    origin, inside = typing.get_origin(hint), typing.get_args(hint)
    if hasattr(hint, "dim_str"):
        return _array(hint)
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


def shown(value: Any) -> str:
    """A value in a few words: its type, and itself where that is short."""
    if isinstance(value, (np.ndarray, jax.Array)):
        return f"an array of {value.dtype}{shown_shape(value.shape)}"
    if value is None:
        return "None"
    if isinstance(value, bool | int | float | np.generic):
        return repr(value.item() if isinstance(value, np.generic) else value)
    if isinstance(value, str | Path):
        return repr(str(value))[:60]
    return _one(type(value).__name__)


def _one(name: str) -> str:
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


def _instance(kind: type) -> Admission:
    if not _checkable(kind):
        return _anything
    words, validate = _one(kind.__name__), getattr(kind, "validate", None)

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
        if value not in values:
            raise Refused(shown(value), " or ".join(map(repr, values)))
        return value

    return look


def _several(origin: type, inside: tuple[Any, ...]) -> Admission:
    """Sequences, and whatever else is gone through."""
    if _is_a(origin, collections.abc.Mapping) or _is_a(origin, collections.abc.Iterator):
        return _instance(origin)
    each = admission_of(inside[0]) if inside else _anything
    plain = each is _anything
    words = _one(origin.__name__.lower())
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


def _array(hint: Any) -> Admission:
    """Arrays of a kind and a shape; lists and numbers are made into them."""
    kind = _KIND.get(_first_kind(hint), "f")
    dims: str = hint.dim_str
    words = f"{KINDS[kind]} of shape [{', '.join(dims.split())}]" if dims else "a number"
    dtype = {"f": np.float32, "i": np.int32, "b": np.bool_}[kind]
    fit = fitting(dims)
    of_numpy = hint.array_type is np.ndarray

    def look(value: Any, argument: str, sizes: Sizes) -> Any:
        array = value
        if not isinstance(value, np.ndarray | jax.Array):
            array = _made(value, words)
        found = _KIND.get(array.dtype.kind, "f")
        if found != kind:
            if kind != "f" or found != "i":
                raise Refused(shown(array), words)
            array = array.astype(dtype)
        elif array is not value and kind == "f":
            array = array.astype(np.float64 if of_numpy else np.float32)
        elif array is not value:
            array = array.astype(dtype)
        wrong = fit(array.shape, argument, sizes)
        if wrong:
            raise Refused(shown(array), f"{words}{wrong}")
        return array

    return look


def _first_kind(hint: Any) -> str:
    first = str(next(iter(hint.dtypes)))
    return first[0] if first[0] in "biu" and not first.startswith("bfloat") else "f"


def _made(value: Any, words: str) -> np.ndarray:
    if value is None or isinstance(value, str | bytes | Path):
        raise Refused(shown(value), words)
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):
        raise Refused("rows that differ in length", words) from None
    if array.dtype.kind not in "biuf":
        raise Refused(shown(value), words)
    return array


def is_finite(value: Any) -> bool:
    """Whether there is nothing but finite numbers in it, as far as that is known."""
    if isinstance(value, float):
        return math.isfinite(value)
    if not isinstance(value, np.ndarray | jax.Array) or isinstance(value, Tracer):
        return True
    return value.dtype.kind != "f" or bool(np.isfinite(np.asarray(value)).all())
