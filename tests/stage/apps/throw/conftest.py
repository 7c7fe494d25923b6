"""A session whose time is the test's, on the graph of the embedded clips."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from mgjax.avoidance.play.clocks import SimulatedSearches
from mgjax.avoidance.prepared import Prepared, prepare
from mgjax.clips.synthetic import synthetic_clips
from mgjax.graph.build import build_graph
from mgjax.graph.config import EMBEDDED
from mgjax.stage.apps.throw.clock import SessionClock
from mgjax.stage.apps.throw.session import ThrowSession


class Played:
    """A tab, what it was told, and a clock that the test moves."""

    def __init__(self, prepared: Prepared, seed: int = 0) -> None:
        self.real = 0.0
        self.told: list[dict[str, Any]] = []
        clock = SessionClock(lambda: self.real)
        self.session = ThrowSession(
            prepared,
            self.told.append,
            seed=seed,
            clock=clock,
            searches=lambda: SimulatedSearches(0.01),
        )

    def play(self, seconds: float) -> None:
        """Ticks for so long."""
        for _ in range(round(seconds * 60)):
            self.real += 1 / 60
            self.session.tick()

    def notes(self, event: str) -> list[dict[str, Any]]:
        return [m for m in self.told if m.get("event") == event]

    def of_type(self, kind: str) -> list[dict[str, Any]]:
        return [m for m in self.told if m["type"] == kind]

    def throw(self, **more: Any) -> None:
        """A click at the first character's chest, from where the camera would be."""
        lane = self.session._lanes[0]
        root = lane.predicted_root(self.session._clock.now())
        place = [float(root[0]), 1.2, float(root[2])]
        eye = [place[0] + 1.0, 1.7, place[2] + 5.0]
        self.session.receive({"type": "throw", "from": eye, "to": place, "place": place, **more})


@pytest.fixture(scope="package")
def prepared() -> Prepared:
    clips, labels = synthetic_clips()
    return prepare(build_graph(clips, labels=labels, config=EMBEDDED))


@pytest.fixture
def open_tab(prepared: Prepared) -> Callable[..., Played]:
    return lambda seed=0: Played(prepared, seed)
