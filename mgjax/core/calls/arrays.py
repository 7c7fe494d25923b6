"""Arrays of a kind and a shape; lists and numbers are made into them."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from mgjax.core.calls.dimensions import Sizes, fitting
from mgjax.core.calls.refused import Refused, shown

KINDS = {"f": "numbers", "i": "whole numbers", "b": "booleans"}
_KIND = {"b": "b", "i": "i", "u": "i", "f": "f", "V": "f"}
"""By kind of a dtype; jax's short floats are of kind V."""


def array_admission(hint: Any) -> Callable[[Any, str, Sizes], Any]:
    """Arrays of a kind and a shape; lists and numbers are made into them."""
    kind = _KIND[_first_kind(hint)]
    dims: str = hint.dim_str
    words = f"{KINDS[kind]} of shape [{', '.join(dims.split())}]" if dims else "a number"
    dtype = {"f": np.float32, "i": np.int32, "b": np.bool_}[kind]
    fit = fitting(dims)
    of_numpy = hint.array_type is np.ndarray

    def look(value: Any, argument: str, sizes: Sizes) -> Any:
        array = value
        if not isinstance(value, np.ndarray | jax.Array):
            array = _made(value, words)
        found = _KIND.get(array.dtype.kind, "")
        if found != kind:
            if kind != "f" or found != "i":
                raise Refused(shown(array), words)
            array = array.astype(dtype)
        elif array is not value and kind == "f":
            array = array.astype(np.float64 if of_numpy else np.float32)
        elif array is not value:
            array = array.astype(dtype)
        wrong = fit(array.shape, argument, sizes)
        if wrong:
            raise Refused(shown(array), f"{words}{wrong}")
        return array

    return look


def _first_kind(hint: Any) -> str:
    first = str(next(iter(hint.dtypes)))
    return first[0] if first[0] in "biu" and not first.startswith("bfloat") else "f"


def _made(value: Any, words: str) -> np.ndarray | jax.Array:
    if value is None or isinstance(value, str | bytes | Path):
        raise Refused(shown(value), words)
    try:
        array = np.asarray(value)
    except jax.errors.TracerArrayConversionError:
        return jnp.asarray(value)
    except (ValueError, TypeError):
        raise Refused("rows that differ in length", words) from None
    if array.dtype.kind not in "biuf":
        raise Refused(shown(value), words)
    return array


def is_finite(value: Any) -> bool:
    """Whether there is nothing but finite numbers in it, as far as that is known."""
    if isinstance(value, float):
        return math.isfinite(value)
    if not isinstance(value, np.ndarray | jax.Array) or isinstance(value, Tracer):
        return True
    return value.dtype.kind != "f" or bool(np.isfinite(np.asarray(value)).all())
