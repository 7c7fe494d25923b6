"""Numbers of settings held to their ranges: one check and one wording.

Neither jax nor numpy is imported here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Real
from typing import Any, TypeAlias

from mgjax.core.errors import ConfigError

Ranges: TypeAlias = Mapping[str, tuple[float, float]]
"""Smallest and largest value of each setting that is a number, or a tuple of numbers, by name;
dotted where it lies in a config of its own. Where the largest is infinite, any finite number will
do."""


def check_ranges(config: Any, ranges: Ranges, place: str = "") -> None:
    """Raises :class:`ConfigError` naming the first setting that is out of range.

    Args:
        config: a dataclass of settings.
        ranges: of its settings.
        place: the message begins with it, such as ``"analysis."``.
    """
    for key, (low, high) in ranges.items():
        value = config
        for name in key.split("."):
            value = getattr(value, name)
        for number in value if isinstance(value, tuple) else (value,):
            check_range(place + key, number, low, high)


def check_range(name: str, value: Any, low: float, high: float) -> None:
    """Raises :class:`ConfigError` unless ``value`` is a number in the range, or is a jax array."""
    if hasattr(value, "dtype") and not isinstance(value, Real):
        return  # traced, or an array that a sweep goes over
    ok = isinstance(value, Real) and not isinstance(value, bool)
    if not (ok and math.isfinite(value) and low <= float(value) <= high):
        top = f" … {high:g}" if high < math.inf else " or more"
        raise ConfigError(f"got {name} = {value!r}, expected {low:g}{top}")
