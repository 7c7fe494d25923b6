"""The type of settings that may be traced. Imports neither jax nor numpy when it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

TRACED = "a number that may be traced"

if TYPE_CHECKING:
    from mgjax.core.arrays import Array

    Number: TypeAlias = float | Array
else:
    Number = Annotated[Any, TRACED]
"""A Python float, or a jax scalar: settings that are traced, so that sweeps and gradients go
through them without a new compilation."""
