"""Playback for the planner (§6): the timeline of edges, clocks, and where searches run."""

from __future__ import annotations

import bisect
import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from mgjax.core import planar
from mgjax.core.motion import Motion
from mgjax.graph.types import MotionGraph
from mgjax.graph.walk import Walk, make_walk, sample_walk


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


@dataclass(frozen=True, kw_only=True)
class Played:
    """An edge of the history: when it began, s, and the factor on its duration."""

    edge: int
    start: float
    scale: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """A stretch of the timeline.

    Attributes:
        walk: its edges.
        begins: when the first of them begins, s.
        start: planar frame of the body there, in the world. [3]
    """

    walk: Walk
    begins: float
    start: Float[np.ndarray, "3"]


class Timeline:
    """The edges that were played or are decided, in the world and on the planner's clock.

    The last stretch of an edge, of one frame, leads to the first pose of the edge that follows (as
    in :func:`mgjax.graph.walk.sample_walk`). So the next edge has to be known at ``deadline``, one
    frame before the end; from then on what is shown is what will be written.

    Args:
        graph: a motion graph.
        node: where the body stands at 0 s.
        start: its planar frame in the world; default: at the origin, heading +Z.
    """

    def __init__(
        self, graph: MotionGraph, node: int, start: Float[np.ndarray, "3"] | None = None
    ) -> None:
        self.graph = graph
        self.node = node
        self.start = np.zeros(3) if start is None else np.asarray(start, dtype=np.float64)
        self.edges: list[int] = []
        self.scales: list[float] = []
        self.starts = [0.0]
        inverse = np.asarray(planar.inverse(graph.node_plane[node].astype(np.float64)))
        self._places = [tuple(float(v) for v in planar.compose(self.start, inverse))]

    @property
    def end(self) -> float:
        """When the last edge ends, s."""
        return self.starts[-1]

    @property
    def deadline(self) -> float:
        """When the edge after the last has to be known, s."""
        if not self.edges:
            return 0.0
        return self.end - self.scales[-1] / self.graph.frame_rate

    def append(self, edge: int, scale: float = 1.0) -> None:
        """Plays an edge after the last one, at ``scale`` times its natural duration."""
        turn, x, z = self.graph.edge_exit[edge].tolist()
        theta, x0, z0 = self._places[-1]
        c, s = math.cos(theta), math.sin(theta)
        self.edges.append(edge)
        self.scales.append(scale)
        seconds = float(self.graph.edge_frames[edge] / self.graph.frame_rate * scale)
        self.starts.append(self.end + seconds)
        self._places.append((theta + turn, x * c + z * s + x0, z * c - x * s + z0))
        self.node = int(self.graph.edge_target[edge])

    def frame_at_end(self) -> Float[np.ndarray, "3"]:
        """Planar frame of the body, in the world, where the last edge arrives."""
        plane = self.graph.node_plane[self.node].astype(np.float64)
        return np.asarray(planar.compose(np.array(self._places[-1]), plane))

    def between(self, first: float, last: float) -> Piece:
        """The edges that are played from ``first`` to ``last`` s, and the next one if decided."""
        a = self._index(first)
        b = min(self._index(last) + 2, len(self.edges))
        edges = np.array(self.edges[a:b])
        plane = self.graph.node_plane[self.graph.edge_source[edges[0]]].astype(np.float64)
        return Piece(
            walk=Walk(edges=edges, scales=np.array(self.scales[a:b])),
            begins=self.starts[a],
            start=np.asarray(planar.compose(np.array(self._places[a]), plane)),
        )

    def sample(self, times: Float[np.ndarray, " T"]) -> Motion:
        """Poses in the world at ascending times."""
        piece = self.between(float(times[0]), float(times[-1]))
        return sample_walk(self.graph, piece.walk, times - piece.begins, start=piece.start)

    def history(self) -> list[Played]:
        """What was played since 0 s, and what is already decided."""
        rows = zip(self.edges, self.starts[:-1], self.scales, strict=True)
        return [Played(edge=edge, start=start, scale=scale) for edge, start, scale in rows]

    def walk(self) -> Walk:
        """The history as a walk; with ``start`` as its start it gives the poses that are shown."""
        return make_walk(self.graph, self.edges, self.scales)

    def _index(self, when: float) -> int:
        return min(max(bisect.bisect_right(self.starts, when) - 1, 0), len(self.edges) - 1)
