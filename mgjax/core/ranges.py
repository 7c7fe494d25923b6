"""Numbers of settings held to their ranges: one check and one wording.

Neither jax nor numpy is imported here.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from numbers import Integral, Real
from typing import Any, TypeAlias

from mgjax.core.errors import ConfigError

Ranges: TypeAlias = Mapping[str, tuple[float, float]]
"""Smallest and largest value of each setting that is a number, or a tuple of numbers, by name;
dotted where it lies in a config of its own. Where the largest is infinite, any finite number will
do."""


def check_ranges(
    config: Any,
    ranges: Ranges,
    place: str = "",
    *,
    whole: Collection[str] = (),
    optional: Collection[str] = (),
    endless: Collection[str] = (),
) -> None:
    """Raises :class:`ConfigError` naming the first setting that is out of range.

    Args:
        config: a dataclass of settings.
        ranges: of its settings.
        place: the message begins with it, such as ``"analysis."``.
        whole: names of settings that must be whole numbers.
        optional: names of settings that may be None.
        endless: names of settings that may be infinite.
    """
    for key, (low, high) in ranges.items():
        value = config
        for name in key.split("."):
            value = getattr(value, name)
        if (value is None and key in optional) or (key in endless and value == math.inf):
            continue
        for number in value if isinstance(value, tuple) else (value,):
            check_range(place + key, number, low, high, whole=key in whole)


def check_range(name: str, value: Any, low: float, high: float, *, whole: bool = False) -> None:
    """Raises :class:`ConfigError` unless ``value`` is a number in the range.

    Numbers that are traced, and arrays that a sweep goes over, pass: they have no one value.
    """
    if not isinstance(value, Real) and hasattr(value, "dtype"):
        try:
            value = float(value)
        except TypeError:
            return
    ok = isinstance(value, Integral if whole else Real) and not isinstance(value, bool)
    if not (ok and math.isfinite(value) and low <= float(value) <= high):
        top = f" … {high:g}" if high < math.inf else " or more"
        kind = "a whole number " if whole else ""
        raise ConfigError(got=f"{name} = {value!r}", expected=f"{kind}{low:g}{top}")
