"""Settings that are written for an adult, made another body's. Imports neither jax nor numpy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, TypeVar

Config = TypeVar("Config")


def sized(config: Config, names: Iterable[str], scale: float) -> Config:
    """A dataclass of settings with some of them times a factor; tuples number by number.

    Args:
        config: the settings, which may be traced.
        names: of lengths and speeds; those that are None stay.
        scale: of the body; see :func:`mgjax.core.body.height.body_scale`.
    """
    if scale == 1:
        return config
    values = {name: getattr(config, name) for name in names}
    scaled = {name: _times(value, scale) for name, value in values.items() if value is not None}
    return replace(config, **scaled)  # pyright: ignore[reportArgumentType]


def _times(value: Any, scale: float) -> Any:
    return tuple(x * scale for x in value) if isinstance(value, tuple) else value * scale
