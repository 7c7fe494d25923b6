"""Calls of public functions, looked at before they are made.

A wrong one is answered by one sentence with what was got and what is expected, and lists are
taken wherever arrays are. What a function takes is read from its annotations, so that there is one
description of it. Only calls through the public names of a room come by here.
"""

from __future__ import annotations

import functools
import inspect
import typing
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from jax.core import Tracer

from mgjax.core.calls.admitted import Admission, admission_of
from mgjax.core.calls.arrays import is_finite
from mgjax.core.calls.dimensions import Sizes
from mgjax.core.calls.refused import Refused
from mgjax.core.errors import ArgumentError, MotionError
from mgjax.core.motion import Motion, validate_motion
from mgjax.core.skeleton import Skeleton

Method = TypeVar("Method", bound=Callable[..., Any])
_TAKES_ANY = "_takes_not_finite"
COMPILED = ("lower", "trace", "eval_shape", "clear_cache")
"""What functions compiled by jax have beyond being called."""


def door(function: Callable[..., Any], package: str, name: str) -> Callable[..., Any]:
    """The function, with its arguments looked at first.

    Args:
        function: a function, compiled or not.
        package: the package that users import it from.
        name: its name there.

    Returns:
        A function of the same signature. It raises :class:`ArgumentError` where an argument is not
        what the annotation says, and :class:`MotionError` where a motion is of another skeleton.
        A missing or unknown argument remains a ``TypeError``.
    """
    signature = inspect.signature(function)
    places = list(signature.parameters)
    finite = not getattr(function, _TAKES_ANY, False)

    @functools.cache
    def admissions() -> dict[str, Admission]:
        hints = typing.get_type_hints(inspect.unwrap(function), include_extras=True)
        return {each: admission_of(hints[each]) for each in places if each in hints}

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        if len(args) > len(places):
            return function(*args, **kwargs)  # Python says it
        admitted = admissions()
        sizes: Sizes = {}
        given = list(args)
        for place, value in enumerate(args):
            given[place] = _admit(name, places[place], value, admitted, sizes, finite)
        for argument, value in kwargs.items():
            kwargs[argument] = _admit(name, argument, value, admitted, sizes, finite)
        _one_body(name, [*given, *kwargs.values()])
        return function(*given, **kwargs)

    call.__module__, call.__qualname__ = package, name  # where pickle finds it
    for each in COMPILED:
        if hasattr(function, each):
            setattr(call, each, getattr(function, each))
    return call


def checked(method: Method) -> Method:
    """As :func:`door`, of a method of a public class."""
    looked_at: Any = door(method, method.__module__, method.__qualname__)
    return looked_at


def takes_not_finite(function: Method) -> Method:
    """Marks a function that has an answer of its own to what is not finite, such as a status."""
    setattr(function, _TAKES_ANY, True)
    return function


def _not_finite(value: Any) -> str:
    return "a value that is not finite" if np.ndim(value) else repr(float(value))


def _admit(
    function: str,
    argument: str,
    value: Any,
    admitted: dict[str, Admission],
    sizes: Sizes,
    finite: bool,
) -> Any:
    look = admitted.get(argument)
    if look is None:
        return value
    try:
        taken = look(value, argument, sizes)
        if finite and not is_finite(taken):
            raise Refused(_not_finite(taken), "nothing but finite numbers")
        return taken
    except Refused as refused:
        raise ArgumentError(
            got=refused.got, expected=refused.expected, place=f"{function}({argument})"
        ) from None


def _one_body(function: str, values: list[Any]) -> None:
    """A motion belongs to the skeleton beside it."""
    skeletons = [each for each in values if isinstance(each, Skeleton)]
    if len(skeletons) != 1:
        return
    for motion in values:
        if not isinstance(motion, Motion) or _traced(motion):
            continue
        try:
            validate_motion(skeletons[0], motion)
        except MotionError as error:
            raise MotionError(f"{function}: {error}") from None


def _traced(motion: Motion) -> bool:
    parts = (motion.root_translation, motion.local_rotations)
    return any(isinstance(each, Tracer) for each in parts)
