"""The graph of the embedded walks, prepared once, and tabs on it."""

from __future__ import annotations

import pytest

from mgjax.hybrid.config import ReachConfig
from mgjax.hybrid.prepared import prepare
from mgjax.stage.apps.sketch.solve import Solver
from mgjax.stage.apps.sketch.walking import walking_graph
from tests.stage.apps.sketch.tab import Tab


@pytest.fixture(scope="package")
def solver() -> Solver:
    """See this module."""
    graph = walking_graph(None, None)
    return Solver(graph, prepare(graph, ReachConfig()))


@pytest.fixture
def tab(solver: Solver) -> Tab:
    """A page that was just opened."""
    return Tab(solver)
