"""What a notebook shows in the place of a thing's ``repr``, and what the thing was made of.

A motion alone cannot be drawn, its skeleton is missing; a selection lacks graph and attack. Who
makes a thing may have it remember what it was made of. That is no field: it takes no part in
equality, pickles, pytrees or ``dataclasses.replace``, and jitted code never sees it.
"""

from __future__ import annotations

import importlib
from typing import Any, TypeVar

T = TypeVar("T")

_NAME = "_made_of"


class Shown:
    """Base of what plays in a notebook's cell (:mod:`mgjax.stage.notebook`, loaded only then)."""

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        return importlib.import_module("mgjax.stage.notebook").mime_bundle(self)

    def _repr_html_(self) -> str | None:
        return self._repr_mimebundle_().get("text/html")

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != _NAME}


def made_of(thing: T, *origin: Any) -> T:
    """The thing itself, which remembers from now on what it was made of."""
    object.__setattr__(thing, _NAME, origin)
    return thing


def like(thing: T, other: Any) -> T:
    """The thing itself, made of what the other one was made of, if that is known."""
    origin = origin_of(other)
    return thing if origin is None else made_of(thing, *origin)


def origin_of(thing: Any) -> tuple[Any, ...] | None:
    """What a thing was made of, or None where it does not know."""
    return getattr(thing, "__dict__", {}).get(_NAME)
