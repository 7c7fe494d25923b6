"""A workbench with few clips, and what pages are told."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import pytest

from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip, Label
from mgjax.graph.build import build_graph
from mgjax.graph.types import MotionGraph
from mgjax.stage.apps.edit.labels import LabelBook
from mgjax.stage.apps.edit.library import Library, memory_library
from mgjax.stage.apps.edit.workbench import Settings, Workbench
from mgjax.stage.packet import pack

SETTINGS = Settings(threshold_m=0.05)
NAMES = ("duck", "sway", "crouch_jump", "turns")


@pytest.fixture(scope="package")
def some() -> tuple[list[Clip], dict[str, tuple[Label, ...]]]:
    """Four of the embedded clips, and their labels."""
    clips, labels = synthetic_clips()
    return [c for c in clips if c.name in NAMES], {n: labels[n] for n in NAMES if n in labels}


@pytest.fixture(scope="package")
def graph(some: tuple[list[Clip], dict[str, tuple[Label, ...]]]) -> MotionGraph:
    """Their graph."""
    return build_graph(some[0], labels=some[1], config=SETTINGS.config())


class Page:
    """Takes what a tab is sent, which has to fit into packets."""

    def __init__(self) -> None:
        self.messages: list[dict[str, Any]] = []

    def __call__(self, message: dict[str, Any]) -> None:
        pack(message)
        self.messages.append(message)

    def of(self, name: str) -> list[dict[str, Any]]:
        """All messages of a type, or notes of an event."""
        return [m for m in self.messages if name in (m["type"], m.get("event"))]

    def last(self, name: str) -> dict[str, Any]:
        """The last of them."""
        return self.of(name)[-1]


def until_idle(bench: Workbench) -> None:
    """Polls until no work is left, for a minute at most."""
    end = time.monotonic() + 60
    while bench.busy and time.monotonic() < end:
        bench.poll()
        time.sleep(0.005)
    assert not bench.busy
    bench.poll()


@pytest.fixture
def library(some: tuple[list[Clip], dict[str, tuple[Label, ...]]]) -> Library:
    """The clips, not read yet."""
    return memory_library(some[0])


@pytest.fixture
def bench(library: Library, some: Any, graph: MotionGraph) -> Iterator[Workbench]:
    """A workbench without files, with a graph."""
    made = Workbench(library, LabelBook(library, None, some[1]), SETTINGS, None)
    made.take_graph(graph, some[1])
    yield made
    made.close()
