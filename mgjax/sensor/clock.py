"""The clock by which arrivals are stamped and decisions timed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeAlias

Clock: TypeAlias = Callable[[], float]
"""Gives the time, s, from any beginning; never goes back."""


def clock() -> float:
    """The clock of this machine, s."""
    return time.perf_counter()
