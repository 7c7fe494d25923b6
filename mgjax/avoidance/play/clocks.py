"""Clocks, and where searches run: simulated, or real ones in a thread (§6)."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class Clock(Protocol):
    """Tells the seconds since playback began."""

    def now(self) -> float: ...


class SimulatedClock:
    """A clock that stands still until it is moved."""

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        return self._now

    def advance(self, seconds: float) -> float:
        """Moves the clock on and returns the new time, s."""
        self._now += seconds
        return self._now


class WallClock:
    """Real seconds since this object was made."""

    def __init__(self) -> None:
        self._begin = time.perf_counter()

    def now(self) -> float:
        return time.perf_counter() - self._begin


@runtime_checkable
class Ticket(Protocol):
    """A call that was handed in and will be answered later."""

    def done(self, when: float) -> bool:
        """Whether it is answered by ``when``, seconds on the planner's clock."""
        ...

    def result(self) -> Any: ...

    def cancel(self, when: float) -> None: ...


@runtime_checkable
class Searches(Protocol):
    """Runs calls beside playback, one at a time and in the order they come in."""

    def submit(self, when: float, call: Callable[[], Any], *, search: bool = True) -> Ticket: ...

    def close(self) -> None: ...


class SimulatedSearches:
    """Searches that take a given time on a simulated clock; everything runs in one thread.

    As with a real thread there is one worker: a search that was cancelled after it began still
    keeps it busy. Calls that are no search (checks of what was played) take no time.

    Args:
        latency: seconds that each search takes, or a function that draws them.
    """

    def __init__(self, latency: float | Callable[[], float] = 0.0) -> None:
        self._latency = latency
        self._free = 0.0

    def submit(self, when: float, call: Callable[[], Any], *, search: bool = True) -> Ticket:
        if not search:
            return _SimulatedTicket(self, call, when, when, when)
        before = self._free
        begin = max(when, before)
        seconds = self._latency() if callable(self._latency) else self._latency
        self._free = begin + seconds
        return _SimulatedTicket(self, call, begin, self._free, before)

    def give_back(self, ready: float, before: float) -> None:
        """The search that would have ended at ``ready`` never began."""
        if self._free == ready:
            self._free = before

    def close(self) -> None:
        """Nothing runs that would have to end."""


@dataclass
class _SimulatedTicket:
    searches: SimulatedSearches
    call: Callable[[], Any]
    begin: float
    ready: float
    before: float

    def done(self, when: float) -> bool:
        return self.ready <= when

    def result(self) -> Any:
        return self.call()

    def cancel(self, when: float) -> None:
        if self.begin > when:
            self.searches.give_back(self.ready, self.before)


class ThreadSearches:
    """Searches in one background thread (§6)."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="mgjax-search")

    def submit(self, when: float, call: Callable[[], Any], *, search: bool = True) -> Ticket:
        return _ThreadTicket(self._pool.submit(call))

    def close(self) -> None:
        """Waits for the call that is running; those that have not begun are dropped."""
        self._pool.shutdown(wait=True, cancel_futures=True)


@dataclass
class _ThreadTicket:
    future: Future

    def done(self, when: float) -> bool:
        return self.future.done()

    def result(self) -> Any:
        return self.future.result()

    def cancel(self, when: float) -> None:
        self.future.cancel()
