"""Public names that are loaded when they are first used, so that importing a package is quick."""

from __future__ import annotations

import functools
import importlib
import inspect
from collections.abc import Callable, Mapping
from typing import Any


def attach(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """What a package's ``__init__.py`` needs to have names that live in other modules.

    Functions are handed out with :func:`mgjax.core.calls.door.door` before them.

    Type checkers do not follow this: the package imports the same names under ``TYPE_CHECKING``,
    and calls ``attach`` only outside of it.

    Args:
        package: its ``__name__``.
        homes: by public name, the module that has it; a module of that name stands for itself.

    Returns:
        ``__getattr__``, ``__dir__`` and ``__all__``.
    """

    @functools.cache
    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module = importlib.import_module(homes[name])
        if homes[name] == f"{package}.{name}":
            return module
        found = getattr(module, name)
        if isinstance(found, type) or not inspect.isfunction(inspect.unwrap(found)):
            return found
        from mgjax.core.calls.door import door

        return door(found, package, name)

    public = sorted(homes)
    return load, lambda: sorted(public), public
