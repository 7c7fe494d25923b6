"""The application: a graph of walking, prepared and compiled, and a session for each tab."""

from __future__ import annotations

import threading

from mgjax.graph.types import MotionGraph
from mgjax.hybrid.config import ReachConfig
from mgjax.hybrid.prepared import prepare
from mgjax.stage.apps.sketch.session import SketchSession
from mgjax.stage.apps.sketch.solve import Solver
from mgjax.stage.apps.sketch.walking import walking_graph, warm, warm_head
from mgjax.stage.serve.options import Options
from mgjax.stage.serve.session import Progress, Send
from mgjax.stage.show.body import body_of


def make_app(options: Options) -> SketchApp:
    """The application behind ``mgjax view sketch``."""
    return SketchApp(options)


class SketchApp:
    """What all tabs share: the graph, and the walks that were found on it."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._graph: MotionGraph | None = None
        self._solver: Solver | None = None

    def prepare(self, progress: Progress) -> None:
        """Loads or builds the graph, and walks and reaches once."""
        progress(0.05, "reading the motion graph")
        graph = self._graph = walking_graph(self._options.graph, self._options.clips)
        progress(0.2, "making the body")
        body_of(graph.skeleton)
        progress(0.3, "preparing the search")
        prepared = prepare(graph, ReachConfig())
        warm(graph, prepared, progress, 0.35)
        self._solver = Solver(graph, prepared)
        threading.Thread(
            target=warm_head, args=(graph, prepared), daemon=True, name="mgjax-compile"
        ).start()

    def open(self, send: Send) -> SketchSession:
        assert self._solver is not None
        return SketchSession(self._solver, send)

    def close(self) -> None:
        self._solver = self._graph = None
