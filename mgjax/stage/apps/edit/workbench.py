"""What all tabs share: clips, labels, the graph, and the work that goes on in the background."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.coverage.throws import Coverage
from mgjax.clips.types import Labels
from mgjax.core.errors import ConfigError, GraphError
from mgjax.graph.config import GraphConfig
from mgjax.graph.types import MotionGraph
from mgjax.stage.apps.edit.cover import cover, coverage_map
from mgjax.stage.apps.edit.job import Job
from mgjax.stage.apps.edit.labels import LabelBook
from mgjax.stage.apps.edit.library import Library
from mgjax.stage.apps.edit.messages import entry_row, labels_message, sentence
from mgjax.stage.apps.edit.picture import graph_picture
from mgjax.stage.apps.edit.rebuild import Built, describe, rebuild
from mgjax.stage.serve.session import Message

TELL_S = 0.1
"""Progress is told this often."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What a graph is built with; see :class:`mgjax.graph.config.GraphConfig`."""

    threshold_m: float | None = None
    keep: float = 0.9
    retarget: bool = False

    def config(self) -> GraphConfig:
        return GraphConfig(threshold_m=self.threshold_m, keep=self.keep, retarget=self.retarget)


class Workbench:
    """The state of the application.

    Args:
        library: the clips.
        book: their labels.
        settings: of the next build.
        folder: where a build that was asked for is written, or None.
    """

    def __init__(
        self, library: Library, book: LabelBook, settings: Settings, folder: Path | None
    ) -> None:
        self.library, self.book, self.settings = library, book, settings
        self.config = AvoidanceConfig()
        self.graph: MotionGraph | None = None
        self.coverage: Coverage | None = None
        self.left_out: set[str] = set()
        self._built_with: Labels = {}
        self._folder = folder
        self._jobs: dict[str, Job] = {}
        self._rounds: list[Coverage] = []
        self._told_at = 0.0
        self._told: Message | None = None
        self.listeners: list[Callable[[Message], None]] = []

    def tell(self, message: Message) -> None:
        """Tells all tabs."""
        for send in list(self.listeners):
            send(message)

    def take_graph(self, graph: MotionGraph, labels: Labels) -> None:
        """Shows another graph from now on; what was found of the one before goes."""
        self.stop("cover")
        self.graph, self.coverage, self._built_with = graph, None, labels
        self._rounds = []  # what is still thrown at the one before goes nowhere

    def build(self, settings: Settings, *, write: bool) -> None:
        """Begins to build the graph; :class:`ConfigError` while one is being built."""
        if "build" in self._jobs:
            raise ConfigError(got="another build", expected="the end of this one, or stop it")
        self.settings = settings
        config, labels = settings.config(), self.book.table.labels()
        folder, without = self._folder if write else None, frozenset(self.left_out)
        self._jobs["build"] = Job(
            lambda watch: rebuild(self.library, labels, without, config, folder, watch), "build"
        )

    def cover(self, rounds: int) -> None:
        """Begins to throw balls at the graph; :class:`GraphError` where there is none."""
        graph = self.need_graph()
        if self._jobs:
            raise ConfigError(got="a second piece of work", expected="the end of the first")
        self.coverage = None
        self._rounds = []
        found = self._rounds.append
        self._jobs["cover"] = Job(
            lambda watch: cover(graph, self.config, rounds, found, watch), "coverage"
        )

    def stop(self, name: str) -> None:
        """Stops a piece of work, if it goes on: soon, not at once."""
        job = self._jobs.get(name)
        if job is not None:
            job.stop()

    @property
    def busy(self) -> bool:
        """Whether work goes on in the background."""
        return bool(self._jobs)

    def need_graph(self) -> MotionGraph:
        """The graph; :class:`GraphError` where there is none yet."""
        if self.graph is None:
            raise GraphError("got no graph yet, expected one: press Build graph")
        return self.graph

    def close(self) -> None:
        """Ends all work."""
        for job in self._jobs.values():
            job.stop()
        for job in self._jobs.values():
            job.stop(wait=1.0)
        self._jobs.clear()
        self.library.close()

    def poll(self) -> None:
        """Tells what has come of the work since this was called last."""
        entries = self.library.take_new()
        if entries:
            rows = [entry_row(entry, self.book) for entry in entries]
            self.tell({"type": "note", "event": "rows", "rows": rows})
        if self._rounds:
            self.coverage = self._rounds[-1]
            self._rounds.clear()
            self.tell(self.map_message())
        for name, job in list(self._jobs.items()):
            if job.over:
                del self._jobs[name]
                self.tell(
                    {
                        "type": "note",
                        "event": "job",
                        "job": name,
                        "share": 1.0,
                        "text": "",
                        "running": False,
                    }
                )
                self._ended(name, job)
        self._progress()

    def greeting(self) -> list[Message]:
        """All that a new tab has to know."""
        file = self.book.file
        path = None if file is None else file.path.name
        ready: Message = {"type": "ready", "app": "edit", "title": "Edit", "options": {}}
        first: Message = {
            "type": "note",
            "event": "clips",
            "names": list(self.library.names),
            "folder": None if self.library.folder is None else str(self.library.folder),
            "labels_file": path,
            "strange": [] if file is None else file.strange,
            "settings": vars(self.settings),
        }
        entries = [entry_row(entry, self.book) for entry in self.library.entries()]
        messages = [
            ready,
            first,
            {"type": "note", "event": "rows", "rows": entries},
            labels_message(self.book, None),
        ]
        messages.append(self.used_message())
        if self.graph is not None:
            messages.append(self.graph_message())
        if self.coverage is not None:
            messages.append(self.map_message())
        return messages + ([self._told] if self._told is not None and self._jobs else [])

    def used_message(self) -> Message:
        """The clips that the next graph is built without."""
        return {"type": "note", "event": "used", "left_out": sorted(self.left_out)}

    def graph_message(self) -> Message:
        """The graph as a picture."""
        graph = self.need_graph()
        return {
            "type": "note",
            "event": "graph",
            "sentence": describe(graph.report),
            "notes": [str(note) for note in graph.report.get("notes", [])],
            **graph_picture(graph, self._built_with),
        }

    def map_message(self) -> Message:
        """The coverage as a map."""
        assert self.coverage is not None
        return {"type": "note", "event": "map", **coverage_map(self.coverage)}

    def _progress(self) -> None:
        now = time.monotonic()
        if not self._jobs or now - self._told_at < TELL_S:
            return
        name, job = next(iter(self._jobs.items()))
        message: Message = {
            "type": "note",
            "event": "job",
            "job": name,
            "share": job.share,
            "text": job.text,
        }
        message["running"] = True
        if message != self._told:
            self._told, self._told_at = message, now
            self.tell(message)

    def _ended(self, name: str, job: Job) -> None:
        result: Any = job.result
        if job.error:
            self.tell(sentence(job.error, "bad"))
        elif job.stopped and name == "cover":
            self.tell(sentence("Throwing was stopped; the map has the balls thrown until then."))
        elif isinstance(result, Built):
            self.take_graph(result.graph, result.labels)
            self.tell(self.graph_message())
            self.tell(sentence(f"Graph built: {result.sentence}.", "good"))
        elif result is None:
            self.tell(sentence("The build was stopped; the graph is the one before."))
        else:
            self.tell(sentence("The coverage map is complete. Click a cell to see a ball.", "good"))
