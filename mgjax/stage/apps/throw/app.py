"""The application: a graph, compiled ahead, and a session for each tab."""

from __future__ import annotations

import threading

import numpy as np

from mgjax.avoidance.choice.compile_ahead import compile_all, programs
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.prepared import Prepared, prepare
from mgjax.core.errors import GraphError
from mgjax.graph.embedded import embedded_graph
from mgjax.graph.files import load_graph
from mgjax.graph.types import MotionGraph
from mgjax.stage.apps.throw.session import ThrowSession
from mgjax.stage.apps.throw.warm import warm_session
from mgjax.stage.serve.collector import waiting_collector
from mgjax.stage.serve.options import Options
from mgjax.stage.serve.session import Progress, Send
from mgjax.stage.show.body import body_of

_SOON = 0.6
"""Share of the programs that are compiled before the page is ready."""
_PATIENT_S = 3.0
"""The page waits so long for the others, s: they were compiled before, or they take far longer."""


def make_app(options: Options) -> ThrowApp:
    """The application behind ``mgjax view throw``."""
    return ThrowApp(options)


class ThrowApp:
    """What all tabs share: the graph and what was prepared of it."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._prepared: Prepared | None = None
        self._opened = 0
        self._stop = threading.Event()

    def prepare(self, progress: Progress) -> None:
        """Loads or builds the graph, and compiles what throws need."""
        progress(0.05, "reading the motion graph")
        graph = self._graph()
        progress(0.15, "making the body")
        body_of(graph.skeleton)
        progress(0.25, "preparing the search")
        prepared = self._prepared = prepare(graph, AvoidanceConfig())
        calls = programs(prepared)
        soon = int(np.ceil(_SOON * len(calls)))
        compile_all(
            calls[:soon],
            lambda done: progress(0.35 + 0.55 * done / soon, f"compiled {done} of {soon}"),
        )

        def later() -> None:
            with waiting_collector():
                for call in calls[soon:]:
                    if self._stop.is_set():
                        return
                    call()

        compiling = threading.Thread(target=later, daemon=True, name="mgjax-compile")
        compiling.start()
        progress(0.9, "programs that few throws need")
        compiling.join(_PATIENT_S)
        progress(0.95, "a first throw")
        warm_session(prepared)

    def open(self, send: Send) -> ThrowSession:
        assert self._prepared is not None
        self._opened += 1
        return ThrowSession(self._prepared, send, seed=self._opened)

    def close(self) -> None:
        self._stop.set()

    def _graph(self) -> MotionGraph:
        if self._options.graph is None:
            return embedded_graph()
        graph = load_graph(self._options.graph)
        if not len(graph.label_kind):
            raise GraphError(
                f"{self._options.graph}: got a graph without labelled parts, expected avoidance"
                " parts to throw balls at (mgjax build --labels FILE)"
            )
        return graph
