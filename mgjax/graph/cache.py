"""The one cache of the library for what is computed from a motion graph.

A graph does not change and is compared by identity, so what follows from it is kept by its
identity, for the graphs used last. The cache holds graphs weakly: what was computed from a graph
goes with it. Arrays of a graph that the cache knows are read-only, so nothing kept can go stale.
"""

from __future__ import annotations

import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

import numpy as np

from mgjax.graph.types import MotionGraph

T = TypeVar("T")

MAX_GRAPHS = 8
"""Graphs whose values are kept; of more, those used longest ago lose theirs."""

MAX_VALUES = 16
"""Values kept for one graph, under as many settings; of more, those used longest ago go."""


class GraphCache:
    """Values computed from graphs, for the ``max_graphs`` graphs that were used last.

    Of each graph the last ``MAX_VALUES`` are kept.

    Threads may share it. Two that ask for one value at the same time wait for one computation;
    values of other graphs, and other values of the same graph, do not wait for it.

    Args:
        max_graphs: at least 1.
    """

    def __init__(self, max_graphs: int = MAX_GRAPHS) -> None:
        self._max_graphs = max_graphs
        # Reentrant: a collection may drop a graph, and run ``_forget``, while the lock is held.
        self._lock = threading.RLock()
        self._entries: OrderedDict[int, _Entry] = OrderedDict()

    def __len__(self) -> int:
        """Graphs with kept values."""
        return len(self._entries)

    def cached(self, graph: MotionGraph, key: Hashable, make: Callable[[], T]) -> T:
        """The value of a key for a graph, computed where it is not kept.

        Args:
            graph: compared by identity, and held weakly. Its arrays become read-only.
            key: names the value and all that it depends on beside the graph.
            make: computes it. The value must not refer to the graph, or neither is ever freed; a
                raised error is passed on and not kept. It may call ``cached`` for other keys.
        """
        with self._lock:
            slot = self._entry(graph).slot(key)
        with slot.lock:
            if not slot.full:
                slot.value = make()
                slot.full = True
            return slot.value

    def _entry(self, graph: MotionGraph) -> _Entry:
        """The entry of a graph, the last one used from now on; the lock is held."""
        number = id(graph)
        entry = self._entries.get(number)
        if entry is None or entry.graph() is not graph:
            _freeze(graph)
            entry = _Entry(weakref.ref(graph, lambda dead: self._forget(number, dead)))
            self._entries[number] = entry
        self._entries.move_to_end(number)
        while len(self._entries) > self._max_graphs:
            self._entries.popitem(last=False)
        return entry

    def _forget(self, number: int, dead: weakref.ref[MotionGraph]) -> None:
        """Drops the values of a graph that is gone; its number may belong to another by now."""
        with self._lock:
            entry = self._entries.get(number)
            if entry is not None and entry.graph is dead:
                del self._entries[number]


class _Entry:
    """The values of one graph by key."""

    def __init__(self, graph: weakref.ref[MotionGraph]) -> None:
        self.graph = graph
        self.slots: OrderedDict[Hashable, _Slot] = OrderedDict()

    def slot(self, key: Hashable) -> _Slot:
        """The slot of a key, the last one used from now on."""
        slot = self.slots.setdefault(key, _Slot())
        self.slots.move_to_end(key)
        while len(self.slots) > MAX_VALUES:
            self.slots.popitem(last=False)
        return slot


class _Slot:
    """Place of one value, with a lock for computing it once."""

    def __init__(self) -> None:
        # Reentrant, so that a value that asks for itself fails by recursion and does not hang.
        self.lock = threading.RLock()
        self.full = False
        self.value: Any = None


def _freeze(graph: MotionGraph) -> None:
    """Makes the arrays of a graph read-only."""
    for value in [*vars(graph).values(), graph.skeleton.offsets]:
        if isinstance(value, np.ndarray):
            value.flags.writeable = False


_CACHE = GraphCache()


def cached(graph: MotionGraph, key: Hashable, make: Callable[[], T]) -> T:
    """The value of a key for a graph, from the library's one cache; see :meth:`GraphCache.cached`.

    Args:
        graph: compared by identity, and held weakly.
        key: the room, what it is and what it depends on, such as ``("hybrid", "macro edges")``.
        make: computes the value, which must not refer to the graph.
    """
    return _CACHE.cached(graph, key, make)
