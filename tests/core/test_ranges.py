from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mgjax.core.errors import ConfigError
from mgjax.core.ranges import check_range, check_ranges


@dataclass(frozen=True, kw_only=True)
class Inner:
    weights: tuple[float, ...] = (0.5, 1.0)


@dataclass(frozen=True, kw_only=True)
class Outer:
    length: Any = 1.0
    inner: Inner = field(default_factory=Inner)


@pytest.mark.parametrize("value", [0.0, 1, 2.0, np.float32(1.5), jnp.array(0.5), np.ones(3)])
def test_in_range(value) -> None:
    """Ends belong to the range; arrays that a sweep goes over are not looked at."""
    check_range("length", value, 0.0, 2.0)


def test_what_is_traced_is_not_looked_at() -> None:
    def checked(value: jax.Array) -> jax.Array:
        check_range("length", value, 0.0, 2.0)
        return value

    assert float(jax.jit(checked)(jnp.array(9.0))) == 9.0


ARRAYS = [np.float32(3), jnp.array(9.0)]


@pytest.mark.parametrize(
    "value", [-0.1, 2.1, math.nan, math.inf, -math.inf, True, "1", None, [1.0], *ARRAYS]
)
def test_out_of_range(value) -> None:
    with pytest.raises(ConfigError, match=r"^got length = .*, expected 0 … 2$"):
        check_range("length", value, 0.0, 2.0)


def test_without_a_largest_value() -> None:
    check_range("length", 1e300, 0.0, math.inf)
    for value in (-1.0, math.inf, math.nan):
        with pytest.raises(ConfigError, match=r"^got length = .*, expected 0 or more$"):
            check_range("length", value, 0.0, math.inf)


def test_settings_of_settings() -> None:
    ranges = {"length": (0.0, 2.0), "inner.weights": (0.0, 1.0)}
    check_ranges(Outer(), ranges)
    for config, text in (
        (Outer(length=-1.0), "got a.length = -1.0, expected 0 … 2"),
        (Outer(inner=Inner(weights=(0.5, 1.5))), "got a.inner.weights = 1.5, expected 0 … 1"),
    ):
        with pytest.raises(ConfigError, match=f"^{re.escape(text)}$"):
            check_ranges(config, ranges, "a.")


def test_whole_optional_and_endless() -> None:
    check_ranges(Outer(length=None), {"length": (0.0, 2.0)}, optional=("length",))
    check_ranges(Outer(length=math.inf), {"length": (0.0, 2.0)}, endless=("length",))
    check_ranges(Outer(length=2), {"length": (0.0, 2.0)}, whole=("length",))
    with pytest.raises(ConfigError, match=r"^got length = 1.0, expected a whole number 0 … 2$"):
        check_ranges(Outer(length=1.0), {"length": (0.0, 2.0)}, whole=("length",))
