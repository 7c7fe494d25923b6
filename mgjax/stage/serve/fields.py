"""Fields of a page's message, checked: nothing in it is trusted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import ConfigError
from mgjax.stage.serve.session import Message

FARTHEST_M = 1000.0
"""No place lies farther from the origin, along any axis."""


def number(message: Message, name: str, low: float, high: float) -> float:
    """A number within a range, both ends included; :class:`ConfigError` otherwise."""
    value = message.get(name)
    if (  # what is not finite is in no range
        isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high
    ):
        raise ConfigError(got=f"{name} {_short(value)}", expected=f"{low:g} … {high:g}")
    return float(value)


def whole(message: Message, name: str, low: int, high: int) -> int:
    """A whole number within a range, both ends included; :class:`ConfigError` otherwise."""
    value = number(message, name, low, high)
    if value != int(value):
        raise ConfigError(got=f"{name} {value:g}", expected="a whole number")
    return int(value)


def flag(message: Message, name: str) -> bool:
    """True or false; :class:`ConfigError` otherwise."""
    value = message.get(name)
    if not isinstance(value, bool):
        raise ConfigError(got=f"{name} {_short(value)}", expected="true or false")
    return value


def text(message: Message, name: str, known: Sequence[str] | None = None, most: int = 200) -> str:
    """One of some known texts, or any of at most ``most`` characters without control characters."""
    value = message.get(name)
    if not isinstance(value, str) or (known is not None and value not in known):
        expected = "a text" if known is None else " or ".join(known)
        raise ConfigError(got=f"{name} {_short(value)}", expected=expected)
    if len(value) > most or not value.isprintable():
        raise ConfigError(
            got=f"{name} {_short(value)}", expected=f"at most {most} printable characters"
        )
    return value


def content(message: Message, name: str, most: int = 2_000_000) -> str:
    """The text of an uploaded file, of at most ``most`` characters."""
    value = message.get(name)
    if not isinstance(value, str) or len(value) > most:
        raise ConfigError(got=f"{name} {_short(value)}", expected=f"a text of at most {most}")
    return value


def point(message: Message, name: str) -> Float[np.ndarray, "3"]:
    """Three numbers, m; :class:`ConfigError` otherwise."""
    return points({name: [message.get(name)]}, name, most=1)[0]


def points(message: Message, name: str, most: int, size: int = 3) -> Float[np.ndarray, "N size"]:
    """One to ``most`` points of ``size`` numbers, m; :class:`ConfigError` otherwise."""
    value = message.get(name)
    if not isinstance(value, list) or not 1 <= len(value) <= most:
        raise ConfigError(got=f"{name} {_short(value)}", expected=f"1 … {most} points")
    for row in value:
        good = isinstance(row, list) and len(row) == size and all(map(_is_place, row))
        if not good:
            raise ConfigError(
                got=f"{name} {_short(row)}",
                expected=f"{size} numbers from {-FARTHEST_M:g} to {FARTHEST_M:g}",
            )
    return np.array(value, dtype=np.float64)


def _is_place(value: Any) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and abs(value) <= FARTHEST_M


def _short(value: Any) -> str:
    shown = ascii(value)
    return shown if len(shown) <= 40 else shown[:39] + "…"
