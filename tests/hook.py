"""Annotations are checked when functions are called: kinds, and shapes that have to agree.

jaxtyping's import hook puts ``jaxtyping.jaxtyped`` on every function and dataclass of the package.
Here that means: the first :data:`MOST` calls of a function in each test are checked. Most functions
are called far less often; those in inner loops were half the time of a test run. What a test does
not call is not prepared for checking, either, which is a tenth of a second for each module.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable
from types import CodeType
from typing import Any

import jaxtyping
from beartype import BeartypeConf, beartype

MOST = 20
"""Calls of a function that are checked in a test; those of a function within another one count
together, however often it is made."""

check = beartype(conf=BeartypeConf(is_pep484_tower=True))  # ints where floats are asked for
_every_call: Any = jaxtyping.jaxtyped
_calls: dict[CodeType, int] = {}


def install() -> None:
    """Call it before the package is imported."""
    jaxtyping.jaxtyped = _decorator
    jaxtyping.install_import_hook("mgjax", "tests.hook.check")


def begin_test() -> None:
    """From here on the first calls are checked again."""
    _calls.clear()


def _decorator(*, typechecker: Any) -> Callable[[Any], Any]:
    def decorate(decorated: Any) -> Any:
        if not inspect.isclass(decorated):
            return _first_calls(decorated, typechecker)
        if dataclasses.is_dataclass(decorated) and "__init__" in vars(decorated):
            made: Any = decorated
            made.__init__ = _first_calls(made.__init__, typechecker)
        return decorated

    return decorate


def _first_calls(function: Callable[..., Any], typechecker: Any) -> Callable[..., Any]:
    code = getattr(inspect.unwrap(function), "__code__", None)
    if code is None:  # made by something else
        return function
    checked: Callable[..., Any] | None = None

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        __tracebackhide__ = True
        nonlocal checked
        count = _calls.get(code, 0)
        if count >= MOST:
            return function(*args, **kwargs)
        _calls[code] = count + 1
        if checked is None:
            checked = _every_call(function, typechecker=typechecker)
        return checked(*args, **kwargs)

    return call
