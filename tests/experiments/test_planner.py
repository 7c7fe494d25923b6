"""The benchmark of the planner, on a simulated clock and in real time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from experiments.avoidance.graphs import built
from experiments.benchmarks.planner import ball_at, play, soak
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.play.clocks import ThreadSearches, Ticket, WallClock
from mgjax.avoidance.play.planner import Planner
from mgjax.graph.types import MotionGraph

QUICK = AvoidanceConfig(checks=12)


@pytest.fixture(scope="module")
def graph() -> MotionGraph:
    return built()


class HandMovedTime:
    """What stands in for :mod:`time`: it passes only while something sleeps."""

    def __init__(self) -> None:
        self.now = 0.0

    def perf_counter(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


class AwaitedSearches(ThreadSearches):
    """Searches in a real thread, of which some are waited for, however long they take."""

    def __init__(self) -> None:
        super().__init__()
        self.tickets: list[Ticket] = []
        self.threads: set[str] = set()

    def submit(self, when: float, call: Callable[[], Any], *, search: bool = True) -> Ticket:
        def named() -> Any:
            self.threads.add(threading.current_thread().name)
            return call()

        self.tickets.append(super().submit(when, named, search=search))
        return self.tickets[-1]


def test_real_time_with_a_thread(graph: MotionGraph, monkeypatch: pytest.MonkeyPatch) -> None:
    time = HandMovedTime()
    monkeypatch.setattr("mgjax.avoidance.play.clocks.time", time)
    monkeypatch.setattr("experiments.benchmarks.planner.time", time)
    clock, searches = WallClock(), AwaitedSearches()
    planner = Planner(graph, clock=clock, searches=searches, config=QUICK, seed=0)
    rng = np.random.default_rng(0)
    pending = [0.3, 0.35, 1.4]

    def before(now: float) -> None:
        if pending and now >= pending[0]:
            pending.pop(0)
            root = np.asarray(planner.frame().root_translation[0])
            planner.attack(ball_at(rng, root, clock.now()))
            if not pending:  # the last search is answered in the frame in which it was asked
                searches.tickets[-1].result()

    report = play(planner.frame, 3.2, before_frame=before)
    answers = planner.finish()
    planner.close()
    counts = planner.counts()
    assert counts["attacks"] == 3 == len(answers)
    assert counts["open"] == 0
    last = max(answers, key=lambda answer: answer.number)
    assert last.search != "late"
    assert (last.waited, last.restarts) == (0.0, 0)
    assert len(searches.threads) == 1
    assert searches.threads != {threading.current_thread().name}
    assert report.frames == pytest.approx(3.2 * 60, abs=1)
    assert report.longest_gap == pytest.approx(1 / 60)
    assert report.longest_frame == 0.0


@pytest.mark.parametrize("minutes", [0.4, pytest.param(2.0, marks=pytest.mark.long)])
def test_soak(graph: MotionGraph, minutes: float) -> None:
    found = soak(graph, minutes, config=QUICK)  # raises where an attack is lost
    assert found["attacks"] > 30 * minutes
    assert found["frames"] == pytest.approx(3600 * minutes, abs=2)
    assert found["avoided"] > 0
    assert found["searched"]["avoided"] > 0
