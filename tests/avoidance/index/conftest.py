"""An index that is built once for all of its tests."""

from __future__ import annotations

import pytest

from mgjax.avoidance.index.build import build_index
from mgjax.avoidance.index.index import GridIndex
from mgjax.graph.types import MotionGraph
from tests.avoidance.index.made import SHORT_S


@pytest.fixture(scope="package")
def made_index(made_graph: MotionGraph) -> GridIndex:
    return build_index(made_graph, horizon=SHORT_S)
