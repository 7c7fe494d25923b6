"""What was got, in a few words, and what is expected."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax
import numpy as np

from mgjax.core.calls.dimensions import shown_shape


class Refused(Exception):
    """What was got and what is expected."""

    def __init__(self, got: str, expected: str) -> None:
        self.got, self.expected = got, expected
        super().__init__(f"got {got}, expected {expected}")


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
    return one(type(value).__name__)


def one(name: str) -> str:
    """The name with its article."""
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"
