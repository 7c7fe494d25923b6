"""What either half of a comparison does: calls that are timed, and how well each met its work.

Imports the standard library only: peers' environments have no mgjax.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


def _same(number: int) -> int:
    return number


@dataclass(frozen=True, kw_only=True)
class Calls:
    """One half of a comparison, set up.

    Attributes:
        count: items of the work, such as targets.
        call: does one, of what ``before`` made of its number; it returns when all is computed.
        miss: how far from right its result is, m or a number, by the item's number.
        before: what is not timed.
    """

    count: int
    call: Callable[[Any], Any]
    miss: Callable[[int, Any], float]
    before: Callable[[int], Any] = _same


def warmed(calls: Calls) -> dict[str, Any]:
    """Does every item once: ``first_call_s``, with all compilation, and the ``misses``."""
    given = calls.before(0)
    begun = time.perf_counter()
    results = [calls.call(given)]
    first = time.perf_counter() - begun
    results += [calls.call(calls.before(number)) for number in range(1, calls.count)]
    misses = [float(calls.miss(number, result)) for number, result in enumerate(results)]
    return {"first_call_s": first, "misses": misses}


def turn(calls: Calls, least_s: float) -> list[float]:
    """Seconds of each call: all items, again and again until so much time is over."""
    seconds: list[float] = []
    end = time.perf_counter() + least_s
    while not seconds or time.perf_counter() < end:
        for number in range(calls.count):
            given = calls.before(number)
            begun = time.perf_counter()
            calls.call(given)
            seconds.append(time.perf_counter() - begun)
    return seconds
