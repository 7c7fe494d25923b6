"""One way to make a frozen dataclass a jax pytree.

``jax.tree_util.register_dataclass`` calls ``__init__`` when it unflattens, and jax unflattens with
placeholders in the place of arrays (in ``vmap``, ``scan``, ``eval_shape``). Where ``__init__``
checks shapes, as it does in the tests, that fails. This registration rebuilds the object with
``object.__new__`` and never runs ``__init__``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, TypeVar

import jax
from jax import export

T = TypeVar("T")


def register(*static: str) -> Callable[[type[T]], type[T]]:
    """Class decorator: registers a frozen dataclass as a pytree.

    Args:
        static: names of the fields that are part of the structure (hashable, not traced). All
            other fields are children.
    """

    def decorate(cls: type[T]) -> type[T]:
        names = [field.name for field in dataclasses.fields(cls)]  # type: ignore[arg-type]
        dynamic = [name for name in names if name not in static]

        def flatten_with_keys(obj: T) -> tuple[list[tuple[Any, Any]], tuple[Any, ...]]:
            children = [(jax.tree_util.GetAttrKey(n), getattr(obj, n)) for n in dynamic]
            return children, tuple(getattr(obj, n) for n in static)

        def flatten(obj: T) -> tuple[list[Any], tuple[Any, ...]]:
            return [getattr(obj, n) for n in dynamic], tuple(getattr(obj, n) for n in static)

        def unflatten(aux: tuple[Any, ...], children: Any) -> T:
            obj = object.__new__(cls)
            for name, value in zip(dynamic, children, strict=True):
                object.__setattr__(obj, name, value)
            for name, value in zip(static, aux, strict=True):
                object.__setattr__(obj, name, value)
            return obj

        jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)
        if not static and "<locals>" not in cls.__qualname__:
            export.register_pytree_node_serialization(
                cls,
                serialized_name=f"{cls.__module__}.{cls.__qualname__}",
                serialize_auxdata=lambda aux: b"",
                deserialize_auxdata=lambda written: (),
            )
        return cls

    return decorate
