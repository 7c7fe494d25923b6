"""The cache of what is computed from a graph: bounded, weak, built once, safe in threads."""

from __future__ import annotations

import gc
import threading
import time
import weakref
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mgjax.graph.cache import MAX_GRAPHS, MAX_VALUES, GraphCache, cached
from mgjax.graph.types import MotionGraph


def copy_of(graph: MotionGraph) -> MotionGraph:
    """Another graph with arrays of its own."""
    return replace(graph, root_translation=graph.root_translation.copy())


class Maker:
    """Counts how often it computes; the value is a large array."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> np.ndarray:
        self.calls += 1
        return np.full(100_000, self.calls)


def test_a_value_is_computed_once_for_each_graph_and_key(made_graph: MotionGraph) -> None:
    cache, make = GraphCache(), Maker()
    other = copy_of(made_graph)
    first = cache.cached(made_graph, ("a", 1), make)
    assert cache.cached(made_graph, ("a", 1), make) is first
    assert cache.cached(made_graph, ("a", 2), make) is not first
    assert cache.cached(other, ("a", 1), make) is not first
    assert make.calls == 3
    assert len(cache) == 2


def test_none_is_a_value(made_graph: MotionGraph) -> None:
    cache = GraphCache()
    assert cache.cached(made_graph, "none", lambda: None) is None
    assert cache.cached(made_graph, "none", lambda: 1) is None


def test_memory_goes_with_the_graph(made_graph: MotionGraph) -> None:
    cache = GraphCache()
    graph = copy_of(made_graph)
    dead = [weakref.ref(graph), weakref.ref(cache.cached(graph, "big", Maker()))]
    assert dead[1]() is not None
    del graph
    gc.collect()
    assert [reference() for reference in dead] == [None, None]
    assert len(cache) == 0


def test_the_library_s_cache_lets_go_as_well(made_graph: MotionGraph) -> None:
    graph = copy_of(made_graph)
    value = weakref.ref(cached(graph, ("test", "big"), Maker()))
    assert value() is not None
    del graph
    gc.collect()
    assert value() is None


def test_six_graphs_in_turn_are_built_once(made_graph: MotionGraph) -> None:
    cache, make = GraphCache(), Maker()
    graphs = [copy_of(made_graph) for _ in range(6)]
    for _ in range(5):
        for graph in graphs:
            cache.cached(graph, "value", make)
    assert make.calls == 6


def test_the_graph_used_longest_ago_is_dropped(made_graph: MotionGraph) -> None:
    cache, make = GraphCache(), Maker()
    graphs = [copy_of(made_graph) for _ in range(MAX_GRAPHS + 1)]
    for graph in graphs[:-1]:
        cache.cached(graph, "value", make)
    cache.cached(graphs[0], "value", make)  # used again: the second is now the oldest
    cache.cached(graphs[-1], "value", make)
    assert len(cache) == MAX_GRAPHS
    assert make.calls == MAX_GRAPHS + 1
    for graph in (*graphs[2:], graphs[0]):
        cache.cached(graph, "value", make)
    assert make.calls == MAX_GRAPHS + 1
    cache.cached(graphs[1], "value", make)
    assert make.calls == MAX_GRAPHS + 2


def test_a_graph_with_the_address_of_a_dead_one_gets_nothing_of_it(made_graph: MotionGraph) -> None:
    cache = GraphCache()
    for number in range(50):  # CPython reuses the address at once
        graph = copy_of(made_graph)
        assert cache.cached(graph, "number", lambda number=number: number) == number
        del graph


def test_arrays_cannot_go_stale(made_graph: MotionGraph) -> None:
    graph = copy_of(made_graph)
    graph.root_translation[0] += 0.0
    total = GraphCache().cached(graph, "sum", lambda: float(graph.root_translation.sum()))
    with pytest.raises(ValueError, match="read-only"):
        graph.root_translation[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        graph.edge_distance *= 2
    assert float(graph.root_translation.sum()) == total


def test_errors_are_passed_on_and_not_kept(made_graph: MotionGraph) -> None:
    cache = GraphCache()

    def fail() -> int:
        raise KeyError("no")

    with pytest.raises(KeyError):
        cache.cached(made_graph, "value", fail)
    assert cache.cached(made_graph, "value", lambda: 7) == 7


def test_values_may_be_made_of_others(made_graph: MotionGraph) -> None:
    cache = GraphCache()

    def sum_of() -> int:
        return cache.cached(made_graph, "part", lambda: 3) + 1

    assert cache.cached(made_graph, "sum", sum_of) == 4


def in_threads(count: int, do: Callable[[int], None]) -> None:
    threads = [threading.Thread(target=do, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def test_threads_wait_for_one_computation(made_graph: MotionGraph) -> None:
    cache, make = GraphCache(), Maker()
    found: list[Any] = [None] * 8

    def slow() -> np.ndarray:
        time.sleep(0.05)
        return make()

    def ask(number: int) -> None:
        found[number] = cache.cached(made_graph, "slow", slow)

    in_threads(8, ask)
    assert make.calls == 1
    assert all(value is found[0] for value in found)


def test_another_graph_does_not_wait(made_graph: MotionGraph) -> None:
    cache = GraphCache()
    entered, release = threading.Event(), threading.Event()

    def blocked() -> int:
        entered.set()
        assert release.wait(300)
        return 1

    thread = threading.Thread(target=cache.cached, args=(made_graph, "blocked", blocked))
    thread.start()
    assert entered.wait(300)
    # Neither do the other values of the same graph.
    assert cache.cached(copy_of(made_graph), "blocked", lambda: 2) == 2
    assert cache.cached(made_graph, "free", lambda: 3) == 3
    release.set()
    thread.join()


def test_threads_that_make_and_drop_graphs(made_graph: MotionGraph) -> None:
    cache = GraphCache(max_graphs=3)
    wrong: list[Any] = []

    def churn(number: int) -> None:
        for round_number in range(30):
            graph = copy_of(made_graph)
            value = cache.cached(graph, "value", lambda r=round_number: (number, r))
            again = cache.cached(graph, "value", lambda r=round_number: (number, r))
            if value != (number, round_number) or again != value:
                wrong.append((value, again))

    in_threads(6, churn)
    gc.collect()
    assert not wrong
    assert len(cache) == 0


def test_the_values_of_one_graph_are_bounded(made_graph: MotionGraph) -> None:
    cache, make = GraphCache(), Maker()
    for number in range(MAX_VALUES + 1):
        cache.cached(made_graph, number, make)
    assert make.calls == MAX_VALUES + 1
    cache.cached(made_graph, MAX_VALUES, make)
    assert make.calls == MAX_VALUES + 1
    cache.cached(made_graph, 0, make)  # used longest ago, so it is gone
    assert make.calls == MAX_VALUES + 2
